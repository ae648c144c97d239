"""A sweep as the instrument ran it: up or down through the frequencies, the motion carried on from point to point.

The response follows its curve as long as the curve goes on and is stable. Where it turns back there is nothing to
follow, and the response jumps to the stable part that is left.

Source: A. H. Nayfeh, D. T. Mook, Nonlinear Oscillations, 1979, §4.1.2 (jumps).
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from .branches import Branch, Fold, settle
from .periodic import Periodic, Seat


class Passed(NamedTuple):
    """A run over the points of a curve.

    **Arguments:** `unknowns`, (points, n + 2) along the run; `reading`, (points,) m, of the same quantity as was
    measured, NaN where the curve does not reach; `others`, per point the readings of the other stable responses;
    `fold`, the one that the response fell off first, and `after`, how many points had been passed by then.
    """

    unknowns: np.ndarray
    reading: np.ndarray
    others: tuple[tuple[float, ...], ...]
    fold: Fold | None
    after: int


def run_along(
    model: Periodic, branch: Branch, frequency: np.ndarray, first: float, swing: bool, scale: np.ndarray
) -> Passed:
    """Pass frequencies (points,) in the order of a run.

    **Arguments:** `first`: amplitude measured at the first point, m, by which the response begins on one of several
    stable ones; `swing`: whether amplitudes are half peak-to-peak; `scale`: (n + 2,) of the unknowns.
    """
    size = branch.swing if swing else np.abs(branch.tone)
    folds = branch.folds
    places: list[tuple[int, float]] = []
    others: list[tuple[float, ...]] = []
    missing = np.zeros(len(frequency), bool)
    fallen, after = None, 0
    reading_at = lambda place: float(size[place[0]] + place[1] * (size[place[0] + 1] - size[place[0]]))
    for i, (f, crossings) in enumerate(zip(frequency, branch.crossings(frequency), strict=True)):
        stable = [c for c in crossings if branch.stable[c[0]] or branch.stable[c[0] + 1]] or crossings
        missing[i] = not stable
        if missing[i]:
            place = places[-1] if places else (0, 0.0)
        elif np.all(missing[:i]):
            place = min(stable, key=lambda c: abs(reading_at(c) - first))
        else:
            on = [c for c in stable if not _between(places[-1], c, folds, branch.gap)]
            if on:
                place = min(on, key=lambda c: abs(c[0] + c[1] - places[-1][0] - places[-1][1]))
            else:
                place = min(stable, key=lambda c: abs(reading_at(c) - reading_at(places[-1])))
                if fallen is None:
                    fallen, after = _nearest(places[-1], f - frequency[i - 1], folds, branch), i
        places.append(place)
        others.append(tuple(reading_at(c) for c in stable if c != place))
    guess = np.array([branch.at(*place) for place in places])
    guess[:, -1] = frequency
    one = np.ones(len(guess))
    seat = Seat(branch.level * one, branch.load * one, np.tile(scale, (len(guess), 1)))
    found, good, seen = settle(model, guess, seat)
    rough = np.array([reading_at(place) for place in places])
    exact = seen.swing if swing else np.abs(seen.tone)
    # At a fold Newton's method may leave the curve; the cubic along it is nearly as good.
    kept = good & (np.abs(exact - rough) < 0.02 * np.max(rough))
    passed = np.where(missing, np.nan, np.where(kept, exact, rough))
    return Passed(np.where(kept[:, None], found, guess), passed, tuple(others), fallen, after)


def _between(place: tuple[int, float], other: tuple[int, float], folds: Sequence[Fold], gap: int | None) -> bool:
    """Whether the curve turns back between two places, or they lie on two stretches."""
    low, high = sorted((place, other))
    if gap is not None and low[0] <= gap < high[0]:
        return True
    return any(low[0] <= fold.index < high[0] or (fold.index == high[0] and low[0] < high[0]) for fold in folds)


def _nearest(place: tuple[int, float], ahead: float, folds: Sequence[Fold], branch: Branch) -> Fold | None:
    """The fold that ends the stretch of the curve on which a place is, in the direction of the run; where it could be
    followed no further (at the corner that a stop makes of a fold), its last point."""
    f, ends = float(branch.at(*place)[-1]), list(folds)
    if branch.gap is not None:
        last = branch.gap + (place[0] > branch.gap)
        ends = [fold for fold in folds if (fold.index > branch.gap) == (place[0] > branch.gap)]
        ends.append(Fold(last, float(branch.frequency[last]), float(abs(branch.tone[last]))))
    ends = [fold for fold in ends if (fold.frequency - f) * ahead >= 0]
    return min(ends, key=lambda fold: abs(fold.index - place[0]), default=None)
