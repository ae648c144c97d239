"""A fault that leaves something competes with a law of the device's coordinates by what each leaves."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace
from typing import Any, cast

from ident.campaign.quality.suspect import Suspect
from ident.diagnosis.doubts import beside_law

SETTLES = Suspect("a.csv", "gain", 0.6, "1", 0.95, "", first=True)
LEAVES = Suspect("b.csv", "wrong-record", -7.5, "% of frequency", 0.9, "", first=True, settles=False, left=67.0)
BY_DATA = Suspect("c.csv", "drift", 30.0, "% of rms", 0.5, "", settles=False, left=67.0)


def _law(left: float) -> Any:
    return cast(Any, SimpleNamespace(chi2_after=left))


def test_the_answer_is_what_leaves_less_by_half():
    both = (LEAVES, BY_DATA)
    assert beside_law(both, None) == both
    assert beside_law(both, _law(4.1)) == (BY_DATA,)
    assert beside_law(both, _law(60.0)) == both
    assert beside_law(both, _law(70.0)) == both


def test_what_was_found_one_beside_the_other_stands_or_falls_together():
    """The second was found with the first left out: what that leaves, both leave."""
    second = replace(LEAVES, file="d.csv", left=6.0)
    for chain in ((LEAVES, second), (LEAVES, replace(second, settles=True, left=0.0)), (SETTLES,)):
        assert beside_law((*chain, BY_DATA), _law(5.0)) == (*chain, BY_DATA)
    assert beside_law((LEAVES, second, BY_DATA), _law(2.0)) == (BY_DATA,)
