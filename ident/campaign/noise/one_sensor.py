"""The colour of a sensor's noise, from a record that shows all of it to those that show a part.

Where a drive leaves no frequency of its band free, the noise there is extrapolated from above, and red noise beside
white has more below than two coefficients tell. A record whose drive is periodic shows it between the lines.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from ..record import NoiseFloor, Trace
from .autoregression import ORDER_PRICE, ar_spectrum, outliers, variance_of
from .floor import EXTRAPOLATED, extrapolated, latest, windowed

_SAME = 0.001  # relative: sampling intervals that differ by less are one

WIDER = 1.5
"""Times: no autoregression is white noise beside a red one. Set on 150 floors beneath sweeps, of which the errors of
their levels and of the colour claimed two thirds of what they were off by; on others this claims 1.0 to 1.5 times as
much (`experiments.hidden_noise`)."""


def of_one_sensor(traces: Sequence[Trace]) -> list[NoiseFloor]:
    """The noise floors of records; those that were extrapolated, in the colour of the surest one that was not, if that
    was read and sampled as they were. Where samples say nothing, curves across them have no noise, and say nothing of
    its colour."""
    whole = [t for t in traces if t.masked is None]
    seen = [t for t in whole if not extrapolated(t.noise) and 0.0 < t.noise.relative_error < EXTRAPOLATED]
    seen.sort(key=lambda trace: trace.noise.relative_error)
    return [_in_the_best_colour(trace, seen) for trace in traces]


def alike(one: Trace, other: Trace) -> bool:
    """Whether two records were read and sampled the same way."""
    return one.measures == other.measures and bool(np.isclose(one.step, other.step, rtol=_SAME, atol=0.0))


def _in_the_best_colour(trace: Trace, seen: Sequence[Trace]) -> NoiseFloor:
    surest = next((other.noise for other in seen if alike(trace, other)), None)
    return trace.noise if surest is None else _in_the_colour_of(surest, trace)


def _in_the_colour_of(surest: NoiseFloor, trace: Trace) -> NoiseFloor:
    """The floor of a record in another one's colour, where that describes the frequencies that it was read off as well
    as its own two coefficients do, by the criterion that chose these."""
    own = trace.noise
    if not extrapolated(own) or trace.masked is not None:
        return own
    seen = windowed(latest(trace.response))
    n, power = len(seen), np.abs(np.fft.rfft(seen)) ** 2 / len(seen)
    mine, other = (_spectrum(floor, n) for floor in (own, surest))
    free = np.arange(len(power)) >= own.unseen * len(power)
    free &= ~outliers(power, 1.0 - free, mine)
    count = int(np.count_nonzero(free))
    power, mine, other = power[free], mine[free], other[free]
    scale = float(np.mean(power / other))
    by_own, by_other = (2.0 * float(np.sum(np.log(s) + power / s)) for s in (mine, scale * other))
    if by_other > by_own + ORDER_PRICE * len(own.ar) * np.log(count):
        return own
    error = WIDER * float(np.hypot(surest.relative_error, np.sqrt(0.25 / count)))
    method = f"{own.method}, in the colour of a record that shows the others too"
    return replace(own, sigma=surest.sigma * scale**0.5, ar=surest.ar, method=method, relative_error=error)


def _spectrum(floor: NoiseFloor, n: int) -> np.ndarray:
    """Its power at the frequencies of the periodogram of n samples."""
    ar = np.array(floor.ar)
    return ar_spectrum(ar, floor.sigma**2 / variance_of(ar, 1.0), n)
