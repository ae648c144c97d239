"""Numbers of each record's own, or of each level's, found in turn with the device's: Gauss-Newton steps of those beside
everything that the model absorbs, and a fit to what is read by them."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from ...fit import Fit
from ..linearised.regression import Regression
from ..unknown.subsets import regress

FEWEST = 3
"""Records, or levels: of two that disagree nobody knows which one is the device's."""
ROUNDS = 6
"""Of the numbers and the device's in turn."""
_SETTLED = 0.3  # of its error bar: a step that moves no number further ends them


class Alternated(NamedTuple):
    """The last `fit`, the `numbers` by which its records are read, (count, q), and their `errors`; both are
    zeros of those held out."""

    fit: Fit
    numbers: np.ndarray
    errors: np.ndarray


def alternated(
    fitted: Fit,
    inside: np.ndarray,
    start: np.ndarray,
    along: Callable[[Fit], tuple[Regression, np.ndarray]],
    refit: Callable[[Fit, np.ndarray], Fit],
    shared: bool,
    most: float = np.inf,
) -> Alternated | None:
    """Numbers that each of several records or levels has of its own; None where one goes beyond `most`.

    **Arguments:** `inside`: which of them are fitted; `start` (count, q): where the numbers begin; `along`: the
    regression of a fit, and what the numbers of those inside do to it, whitened, (numbers, n); `refit`: the fit from
    the values of another one, all read by such numbers; `shared`: whether what all have is the device's own.
    """
    now, numbers, errors = fitted, start.copy(), np.zeros_like(start)
    q = start.shape[1]
    for _ in range(ROUNDS):
        regression, rows = along(now)
        solved = regress(regression.project(rows), regression.residual)
        step, spread = solved.coefficients.reshape(-1, q), solved.spread.reshape(len(inside), q, -1)
        if shared:
            step, spread = step - np.mean(step, axis=0), spread - np.mean(spread, axis=0)
        errors[inside] = np.linalg.norm(spread, axis=2) * np.sqrt(max(regression.chi2 / regression.n, 1.0))
        numbers[inside] += step
        if not np.all(np.abs(numbers) <= most):
            return None
        now = refit(now, numbers)
        if np.all(np.abs(step) < _SETTLED * errors[inside]):
            break
    return Alternated(now, numbers, errors)
