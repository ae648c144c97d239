"""Words of a choice that promise more than the usual ones have kept are refitted too, and the refits decide."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

from ident.diagnosis.ranking import confirm as confirming
from ident.diagnosis.ranking.confirm import Confirmed, confirm
from ident.diagnosis.ranking.weigh import Candidate

N = 400
REGRESSION = SimpleNamespace(refitted={}, best_chi2=4000.0, instead_of=None, n=N, above_noise=3600.0)


def candidate(words: str, drop: float, *others: Candidate) -> Candidate:
    none = np.zeros((1, N))
    return Candidate("stress", drop, 0.5, 1, 0.0, {}, {}, {}, none, words={"closure": words}, otherwise=others)


@pytest.mark.parametrize(
    ("left", "promised", "possible", "wanted"),
    [
        ({"usual": 2.0, "other": 1.0}, 3600.0, True, "other"),
        ({"usual": 1.0, "other": 2.0}, 3600.0, True, "usual"),
        ({"usual": 1.0, "other": 1.0}, 3600.0, True, "usual"),
        ({"usual": 1.1, "other": 1.0}, 3550.0, True, "usual"),  # which leave noise alone
        ({"usual": 2.0, "other": 1.0}, 3000.0, True, "other"),  # a promise is of first order
        ({"usual": 2.0, "other": 1.3}, 3600.0, False, "usual"),  # an effect that ends in what cannot be is refused
        ({"usual": 2.0, "other": 1.0}, 3600.0, False, "other"),  # unless other words leave noise alone
    ],
)
def test_the_words_whose_refit_says_more_are_taken(
    monkeypatch: pytest.MonkeyPatch, left: dict[str, float], promised: float, possible: bool, wanted: str
) -> None:
    rng = np.random.default_rng(1)

    def refitted(regression, effect, one: Candidate, most, base) -> Confirmed:
        word = one.words["closure"]
        rest = left[word] * rng.standard_normal(N)
        rest *= np.sqrt(N * left[word]) / np.linalg.norm(rest)
        can_be = possible or word == "other"
        return Confirmed(one, None, np.zeros(3), float(rest @ rest), 0.0, rest, 3.0, can_be)  # pyright: ignore

    monkeypatch.setattr(confirming, "_refitted", refitted)
    REGRESSION.refitted.clear()
    asked = candidate("usual", 2500.0, candidate("other", promised))
    found = confirm(REGRESSION, type("Stress", (), {"parameters": ()}), asked)  # pyright: ignore[reportArgumentType]
    assert found.candidate.words["closure"] == wanted
    assert asked.promised(REGRESSION) == promised  # pyright: ignore[reportArgumentType]
