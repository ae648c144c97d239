"""Short stretches in which a sensor left the curve and came back: an echo lost, a beam crossed, a marker mistaken.

Single samples are `outliers`; a stretch longer than a part of a period is nobody's to judge from the data alone.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from .outliers import off_neighbours

_FAR = 12.0  # robust deviations, as of `outliers`
_LONGEST = 2.0  # rad of the motion: beyond that no curve says what was there
_TAIL = 4  # samples at either end that may be off the curve although they are not rough
_SIDE = 1.5  # rad of the motion, on each side, that the curve is drawn through
_DEGREE = 6
_ALIKE = 3.0  # times what such a curve misses elsewhere, beside a gap and within it
_PLACES = 6  # on either side, that say what it misses
_SUDDEN = 0.01  # of a drive's range, more than the steps of a converter of seven bits make
_TRIED = 500  # rough places; where there are more, they are how the device or the sensor works
_MOST = 0.05  # of a record: more is no accident


class _Missed(NamedTuple):
    """Root mean squares of what a curve misses beside a gap and within it, and the curve there."""

    beside: float
    within: float
    curve: np.ndarray


def find_slips(displacement: np.ndarray, drive: np.ndarray) -> np.ndarray | None:
    """(n,) whether a sample belongs to a slip of the sensor; None if none does, or too many.

    A body goes on. One curve runs through what lies on both sides of a slip as well as such curves do elsewhere; the
    samples inside are far from it, and between two of them the body would have gone, seen from the curve, faster than
    it goes anywhere near. After a stop or a blow the motion is another one, on no curve with that before; after a jump
    that stays too. What the `drive` (n,) does at once the displacement may as well.
    """
    x, n = displacement, len(displacement)
    size = float(np.median(np.abs(x - np.median(x))))
    rate = float(np.median(np.abs(np.diff(x)))) / max(size, 1e-300)  # rad between samples
    rough = _rough(x)
    if rate <= 0 or not 0 < np.count_nonzero(rough) <= _MOST * n:
        return None
    places = np.flatnonzero(rough)
    sudden = np.abs(off_neighbours(drive)) > max(_SUDDEN * float(np.ptp(drive)), 1e-300)
    sudden = np.convolve(sudden, np.ones(2 * _TAIL + 1), "same") > 0
    cuts = np.flatnonzero(np.diff(places) > 2)
    starts, stops = places[np.r_[0, cuts + 1]], places[np.r_[cuts, len(places) - 1]] + 1
    found, side = np.zeros(n, dtype=bool), max(int(_SIDE / rate), 8)
    i = len(starts) if len(starts) > _TRIED else 0
    while i < len(starts):
        j = i
        while j < len(starts) and stops[j] - starts[i] <= _LONGEST / rate:
            tails = ((int(starts[i]) - tail, int(stops[j]) + tail) for tail in range(_TAIL + 1))
            own = not np.any(sudden[starts[i] : stops[j]])
            slips = (_slip(x, rough | found, *ends, side) for ends in tails if own)
            slip = next((one for one in slips if one is not None), None)
            if slip is not None:
                found[slip] = True
                i = j
                break
            j += 1
        i += 1
    return found if 0 < np.count_nonzero(found) <= _MOST * n else None


def _rough(x: np.ndarray) -> np.ndarray:
    """(n,) where a sample is far from what its neighbours say."""
    size, levels = np.abs(off_neighbours(x)), np.unique(x)
    step = float(np.min(np.diff(levels))) if len(levels) > 1 else 0.0
    return size > _FAR * max(1.4826 * float(np.median(size)), step / np.sqrt(12))


def _slip(x: np.ndarray, rough: np.ndarray, start: int, stop: int, side: int) -> np.ndarray | None:
    """Which samples belong to a slip, if there is one: those of the stretch, and rough ones beside it off its curve."""
    here = _missed(x, rough, start, stop, side)
    if here is None:
        return None
    around = np.max(np.abs(np.diff(here.curve)))
    off = x[start - side : stop + side] - here.curve
    if not np.max(np.abs(np.diff(np.pad(off[side:-side], 1)))) > around:
        return None
    there = list(_elsewhere(x, rough, start, stop, side))
    usual = lambda sizes: _ALIKE * float(np.median(list(sizes)))
    if not there or here.beside >= usual(o.beside for o in there) or here.within <= usual(o.within for o in there):
        return None
    ends = rough[start - side : stop + side] & (np.abs(off) > _ALIKE * here.beside)
    return np.r_[np.arange(start, stop), start - side + np.flatnonzero(ends)]


def _elsewhere(x: np.ndarray, rough: np.ndarray, start: int, stop: int, side: int) -> Iterator[_Missed]:
    """Curves across gaps as long, at places near that are not rough: what they miss there."""
    for way in (-1, 1):
        count = 0
        for k in range(1, 6 * _PLACES):
            shift = way * k * max((stop - start + side) // 2, 1)
            if count == _PLACES or not side <= start + shift <= len(x) - side - (stop - start):
                break
            if not np.any(rough[start + shift : stop + shift]):
                one = _missed(x, rough, start + shift, stop + shift, side)
                if one is not None:
                    count += 1
                    yield one


def _missed(x: np.ndarray, rough: np.ndarray, start: int, stop: int, side: int) -> _Missed | None:
    """What a curve through the samples beside a gap that are not rough misses; None at the ends of the record, or where
    too many are rough."""
    if start < side or stop + side > len(x):
        return None
    part, at = x[start - side : stop + side], np.linspace(-1.0, 1.0, stop - start + 2 * side)
    good = ~rough[start - side : stop + side]
    good[side:-side] = False
    if min(np.count_nonzero(good[:side]), np.count_nonzero(good[-side:])) < side // 2 + 2:
        return None
    curve = np.polynomial.Chebyshev.fit(at[good], part[good], _DEGREE, domain=[-1, 1])(at)
    off = part - curve
    root = lambda values: float(np.sqrt(np.mean(values**2)))
    return _Missed(root(off[good]), root(off[side:-side]), curve)
