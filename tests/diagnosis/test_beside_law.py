"""A fault that leaves something competes with a law of the device's coordinates by what each leaves."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any, cast

from ident.campaign.quality.suspect import Suspect
from ident.diagnosis.doubts import beside_law

SETTLES = Suspect("a.csv", "gain", 0.6, "1", 0.95, "", first=True)
LEAVES = Suspect("b.csv", "wrong-record", -7.5, "% of frequency", 0.9, "", first=True, settles=False, left=67.0)
BY_DATA = Suspect("c.csv", "drift", 30.0, "% of rms", 0.5, "", settles=False, left=67.0)


def _law(left: float) -> Any:
    return cast(Any, SimpleNamespace(chi2_after=left))


def test_the_answer_is_what_leaves_less():
    all_three = (SETTLES, LEAVES, BY_DATA)
    assert beside_law(all_three, None) == all_three
    assert beside_law(all_three, _law(4.1)) == (SETTLES, BY_DATA)
    assert beside_law(all_three, _law(70.0)) == all_three
