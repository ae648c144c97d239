"""A drive with corners: a triangle, a trapezoid, a step that an amplifier ramps.

A smooth curve through the samples of a corner rings: a cubic spline passes it by a tenth of the change of slope per
sample and swings for four more, which a spring with memory, a play or a dry friction, keeps. Between its corners a
drive is as smooth as any other, and the curve is broken there and nowhere else.
"""

from __future__ import annotations

import numpy as np

from .held_drive import jumps

_BEND = 8.0  # times the second differences beside it, and most others: smooth drives with noise or steps of a
# converter then have none (test_corners: of 400 none, of a limit of 4 one in twenty)
_STAYS = 2.0  # times a bend that stays, three samples on: 2 to 3, of one step up 1
_BESIDE = (2, 3)  # samples away: the next may share a corner that lies between two


def corners(drive: np.ndarray) -> np.ndarray:
    """The samples at which a drive (n,) has a corner, in order: where it bends far more than to either side.

    A drive that jumps from sample to sample has none that its samples could show.
    """
    n = len(drive)
    reach = max(_BESIDE)
    if n < 2 * reach + 3 or jumps(drive):
        return np.zeros(0, dtype=int)
    bend = np.zeros(n)
    bend[1:-1] = np.abs(np.diff(drive, 2))
    beside = np.max([np.roll(bend, shift) for away in _BESIDE for shift in (away, -away)], axis=0)
    # At a corner the slope is another one from there on; where a slow drive goes by steps of a converter it is not.
    over = np.abs(np.roll(drive, reach) - 2 * drive + np.roll(drive, -reach))
    found = (bend > _BEND * np.maximum(beside, np.quantile(bend, 0.75))) & (over > _STAYS * bend)
    found[: reach + 1] = found[-reach - 1 :] = False
    return np.flatnonzero(found)


def broken_spline(drive: np.ndarray, breaks: np.ndarray, grid: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """A drive (n,) and its derivative per sampling interval at the points of a grid (m,), in samples, by splines from
    one break to the next; at a break the derivative is the mean of both sides.

    The splines are the not-a-knot cubic ones, of three samples the parabola, of two the straight line.
    """
    from scipy.interpolate import make_interp_spline  # here, because its import costs more than reading a campaign

    ends = [0, *breaks.tolist(), len(drive) - 1]
    voltage, slope, times = np.zeros(len(grid)), np.zeros(len(grid)), np.zeros(len(grid))
    for first, last in zip(ends[:-1], ends[1:], strict=True):
        low, high = np.searchsorted(grid, first, "left"), np.searchsorted(grid, last, "right")
        at = np.arange(first, last + 1, dtype=float)
        spline = make_interp_spline(at, drive[first : last + 1], k=min(3, last - first))
        voltage[low:high] = spline(grid[low:high])
        slope[low:high] += spline.derivative()(grid[low:high])
        times[low:high] += 1
    return voltage, slope / times
