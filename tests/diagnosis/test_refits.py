"""Where scores cannot be believed, short refits rank: of those that score best, or of all."""

from __future__ import annotations

from types import SimpleNamespace
from typing import cast

import numpy as np
import pytest

from ident.diagnosis.linearised.regression import Regression
from ident.diagnosis.ranking import refits
from ident.diagnosis.ranking.weigh import Candidate

NAMES = [f"effect-{i}" for i in range(30)]


@pytest.mark.parametrize(
    ("first", "answered", "asked"), [(0.97, False, 12), (0.9, False, 30), (0.2, False, 30), (0.2, True, 12)]
)
def test_all_are_asked_if_none_of_the_first_nearly_explains_it(
    monkeypatch: pytest.MonkeyPatch, first: float, answered: bool, asked: int
) -> None:
    """The last one by its score explains most, as the friction did that ruled a slide; not if an answer is known."""
    scored = [Candidate(name, 1.0, 0.1, 1, 0.5, {}, {}, {}, np.zeros((1, 3))) for name in NAMES]
    gains, seen = {NAMES[0]: first, NAMES[-1]: 0.95}, []

    def glimpse(_: Regression, one: Candidate, __: object) -> Candidate:
        seen.append(one.name)
        gain = gains.get(one.name, 0.05)
        return one._replace(drop=1e4 * gain, predicted_gain=gain)

    monkeypatch.setattr(refits, "_best_glimpse", glimpse)
    regression, library = SimpleNamespace(n=1000), dict.fromkeys(NAMES, object)
    ranked = refits.by_refits(cast(Regression, regression), scored, cast(dict, library), lambda _: None, answered)
    assert sorted(seen) == sorted(NAMES[:asked]) and len(ranked) == len(NAMES)
    assert ranked[0].name == (NAMES[0] if asked == 12 else NAMES[-1])
