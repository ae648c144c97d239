"""A drive with corners: a triangle, a trapezoid, a step that an amplifier ramps.

A smooth curve through the samples of a corner rings: a cubic spline passes it by a tenth of the change of slope per
sample and swings for four more, which a spring with memory, a play or a dry friction, keeps. Between its corners a
drive is as smooth as any other, and the curve is broken there and nowhere else.
"""

from __future__ import annotations

import numpy as np

from .held_drive import jumps

_BEND = 8.0  # times the second differences beside it, and most others: smooth drives with noise or steps of a
# converter then have none (test_corners: of 400 none, nor at 4, at 2.5 one in ten)
_STAYS = 2.0  # times a bend that stays, three samples on: 2 to 3, of one step up 1
_NEAR = 0.25  # of a sampling interval, to a corner: a curve through both would make a slope of their noise
_BESIDE = (2, 3)  # samples away: the next may share a corner that lies between two


def corners(drive: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Where a drive (n,) has corners: it bends far more there than to either side.

    **Returns:** their places (c,), in samples, in order, and the drive there (c,). A corner between two samples, of
    which each bends by its share, is where the lines to either side meet. A drive that jumps from sample to sample has
    none that its samples could show.
    """
    n, reach = len(drive), max(_BESIDE)
    if n < 2 * reach + 3 or jumps(drive):
        return np.zeros(0), np.zeros(0)
    signed = np.zeros(n)
    signed[1:-1] = np.diff(drive, 2)
    bend = np.abs(signed)
    beside = np.max([np.roll(bend, shift) for away in _BESIDE for shift in (away, -away)], axis=0)
    # At a corner the slope is another one from there on; where a slow drive goes by steps of a converter it is not.
    over = np.abs(np.roll(drive, reach) - 2 * drive + np.roll(drive, -reach))
    found = (bend > _BEND * np.maximum(beside, np.quantile(bend, 0.75))) & (over > _STAYS * bend)
    found[: reach + 1] = found[-reach - 1 :] = False
    at = np.flatnonzero(found)
    shared = at[:-1][(np.diff(at) == 1) & (signed[at[:-1]] * signed[at[1:]] > 0)]  # with the next sample
    part = signed[shared + 1] / (signed[shared] + signed[shared + 1])
    before = drive[shared] + part * (drive[shared] - drive[shared - 1])
    after = drive[shared + 1] - (1 - part) * (drive[shared + 2] - drive[shared + 1])
    alone = np.setdiff1d(at, [shared, shared + 1])
    places, values = np.concatenate([shared + part, alone]), np.concatenate([0.5 * (before + after), drive[alone]])
    order = np.argsort(places)
    return places[order], values[order]


def broken_spline(
    drive: np.ndarray, places: np.ndarray, values: np.ndarray, grid: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """A drive (n,) and its derivative per sampling interval at the points of a grid (m,), in samples, by splines from
    one corner to the next (`corners`); at a corner the derivative is the mean of both sides.

    The splines are the not-a-knot cubic ones, of three points the parabola, of two the straight line.
    """
    from scipy.interpolate import make_interp_spline  # here, because its import costs more than reading a campaign

    last = len(drive) - 1
    ends = [
        (0.0, float(drive[0])),
        *zip(places.tolist(), values.tolist(), strict=True),
        (float(last), float(drive[-1])),
    ]
    voltage, slope, times = np.zeros(len(grid)), np.zeros(len(grid)), np.zeros(len(grid))
    for (first, low), (end, high) in zip(ends[:-1], ends[1:], strict=True):
        inside = np.arange(int(first) + 1, int(np.ceil(end)))
        inside = inside[(inside - first > _NEAR) & (end - inside > _NEAR)]
        at = np.array([first, *inside, end])
        spline = make_interp_spline(at, np.array([low, *drive[inside], high]), k=min(3, len(at) - 1))
        own = slice(*np.searchsorted(grid, [first, np.nextafter(end, np.inf)]))
        voltage[own] = spline(grid[own])
        slope[own] += spline.derivative()(grid[own])
        times[own] += 1
    return voltage, slope / times
