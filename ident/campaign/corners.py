"""A drive with corners: a triangle, a trapezoid, a step that an amplifier ramps.

A smooth curve through the samples of a corner rings: a cubic spline passes it by a tenth of the change of slope per
sample and swings for four more, which a spring with memory, a play or a dry friction, keeps. Between its corners a
drive is as smooth as any other, and the curve is broken there and nowhere else.
"""

from __future__ import annotations

from functools import lru_cache
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from .held_drive import jumps
from .record import Same
from .smooth_drive import smooth_drive

if TYPE_CHECKING:
    from scipy.interpolate import BSpline

_BEND = 8.0  # times the second differences beside it, and most others: of the 400 smooth drives of test_corners, with
# noise or steps of a converter, none then has one, nor at 4; at 2.5 17 have
_LEAST = 1 / 500  # of the range of the drive: through less a curve rings by a five-thousandth of it
_STAYS = 2.0  # times a bend that stays, three samples on: 2 to 3, of one step up 1
_BESIDE = (2, 3)  # samples away: the next may share a corner that lies between two
_NEAR = 0.25  # of a sampling interval, to a corner: a curve through both would make a slope of their noise
_FEWEST = 4  # points of a piece: fewer lie on a line or a parabola, whose other points are as good


class Corners(NamedTuple):
    """Corners of a drive, in order: `at` (c,) the samples, of which each bends; `part` (c,) how far from there to the
    next sample the corner is, where that bends by the rest: where the lines to either side meet."""

    at: np.ndarray
    part: np.ndarray

    def __bool__(self) -> bool:
        return len(self.at) > 0

    @property
    def places(self) -> np.ndarray:
        """Where they are, in samples."""
        return self.at + self.part

    def of(self, drive: np.ndarray) -> np.ndarray:
        """The drive (n,) at its corners."""
        k, f = self.at, self.part
        before = drive[k] + f * (drive[k] - drive[k - 1])
        after = drive[k + 1] - (1 - f) * (drive[k + 2] - drive[k + 1])
        return np.where(f > 0, 0.5 * (before + after), drive[k])


def corners(drive: np.ndarray) -> Corners:
    """Where a drive (n,) has corners: it bends far more there than to either side.

    Found are those that stand eight times above what noise makes of second differences, and not among the first and
    last four samples; a triangle of fewer than eight samples from turn to turn, and a drive that jumps from sample to
    sample, shows none.
    """
    n, reach, none = len(drive), max(_BESIDE), Corners(np.zeros(0, dtype=int), np.zeros(0))
    if n < 2 * reach + 3 or jumps(drive):
        return none
    signed = np.zeros(n)
    signed[1:-1] = np.diff(drive, 2)
    bend = np.abs(signed)
    beside = np.max([np.roll(bend, shift) for away in _BESIDE for shift in (away, -away)], axis=0)
    # At a corner the slope is another one from there on; where a slow drive goes by steps of a converter it is not.
    over = np.abs(np.roll(drive, reach) - 2 * drive + np.roll(drive, -reach))
    most, least = np.maximum(beside, np.quantile(bend, 0.75)), _LEAST * np.ptp(drive)
    found = (bend > np.maximum(_BEND * most, least)) & (over > _STAYS * bend)
    found[: reach + 1] = found[-reach - 1 :] = False
    at = np.flatnonzero(found)
    shared = at[:-1][(np.diff(at) == 1) & (signed[at[:-1]] * signed[at[1:]] > 0)]  # with the next sample
    alone = np.setdiff1d(at, [shared, shared + 1])
    part = signed[shared + 1] / (signed[shared] + signed[shared + 1])
    places = np.concatenate([shared, alone]), np.concatenate([part, np.zeros(len(alone))])
    order = np.argsort(places[0])
    return Corners(places[0][order], places[1][order])


def broken_spline(drive: np.ndarray, found: Corners) -> BSpline:
    """A drive (n,) as a cubic spline of its samples that is broken at its corners, and not-a-knot at the others' ends.

    A sample close to a corner between two samples, which tells the same, is left out.
    """
    from scipy.interpolate import make_interp_spline  # here, because its import costs more than reading a campaign

    index, places = np.arange(len(drive), dtype=float), found.places
    there = np.searchsorted(places, index)
    left, right = places[np.maximum(there - 1, 0)], places[np.minimum(there, len(places) - 1)]
    away = np.minimum(np.abs(index - left), np.abs(index - right)) > _NEAR
    away[0] = away[-1] = True
    x = np.concatenate([index[away], places])
    y = np.concatenate([drive[away], found.of(drive)])
    order = np.argsort(x, kind="stable")
    x, y = x[order], y[order]
    ends = np.concatenate([[0], np.flatnonzero(order >= np.count_nonzero(away)), [len(x) - 1]])
    x, y, ends = _filled(x, y, ends)
    # Each piece has as many coefficients as points: inside it all knots but the second and the last but one.
    inner = np.ones(len(x), dtype=bool)
    inner[[*ends, *(ends[:-1] + 1), *(ends[1:] - 1)]] = False
    knots = np.sort(np.concatenate([np.repeat(x[ends[[0, -1]]], 4), np.repeat(x[ends[1:-1]], 3), x[inner]]))
    return make_interp_spline(x, y, k=3, t=knots)


def drive_at(drive: np.ndarray, places: np.ndarray) -> np.ndarray:
    """A drive (n,) that is not held at places (m,) between its samples, from 0 to n − 1: on a curve that is smooth, but
    for its corners."""
    return _curve(Same(drive))(places)


@lru_cache(maxsize=64)  # as many as `response.lane` keeps: a search for a delay reads each again and again
def _curve(drive: Same) -> BSpline:
    found = corners(drive.array)
    return broken_spline(drive.array, found) if found else smooth_drive(drive.array)


def _filled(x: np.ndarray, y: np.ndarray, ends: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """The points with further ones on the lines and parabolas through those of short pieces, and where pieces end."""
    at, more = x[ends], [(np.zeros(0), np.zeros(0))]
    for k in np.flatnonzero(np.diff(ends) < _FEWEST - 1):
        own = slice(ends[k], ends[k + 1] + 1)
        few = len(x[own])
        between = np.linspace(x[own][0], x[own][1], 2 + _FEWEST - few)[1:-1]
        curve = np.polynomial.Polynomial.fit(x[own], y[own], few - 1)
        more.append((between, curve(between)))
    x, y = (np.concatenate([whole, *parts]) for whole, parts in zip((x, y), zip(*more, strict=True), strict=True))
    order = np.argsort(x)
    return x[order], y[order], np.searchsorted(x[order], at)


def rates(curve: BSpline, grid: np.ndarray) -> np.ndarray:
    """The derivative of a broken curve per sampling interval: at a corner the mean of both sides, and none where the
    drive turns, as at any other turn: what it rubs on stays there."""
    slope = curve.derivative()
    after, before = slope(grid), slope(np.nextafter(grid, -np.inf).clip(grid[0]))
    return np.where(after * before < 0, 0.0, 0.5 * (after + before))
