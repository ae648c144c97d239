"""The colour of a sensor's noise, from a record that shows all of it to those that show a part.

Where a drive leaves no frequency of its band free, the noise there is extrapolated from above, and red noise beside
white has more below than two coefficients tell. A record whose drive is periodic shows it between the lines. Where none
has, one colour that describes what all of them show is surer than that which each shows alone: of pink noise half of
the records looked as if it levelled off.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import lru_cache
from typing import NamedTuple

import numpy as np

from ..record import VAGUE, NoiseFloor, Trace
from .autoregression import ORDER_PRICE, ar_spectrum, outliers, variance_of
from .floor import EXTRAPOLATED, NUMBERS, extrapolated, latest, windowed

_SAME = 0.001  # relative: sampling intervals that differ by less are one

WIDER = 1.5
"""Times: no autoregression is white noise beside a red one. Set on 150 floors beneath sweeps, of which the errors of
their levels and of the colour claimed two thirds of what they were off by; on others this claims 1.0 to 1.5 times as
much (`experiments.hidden_noise`)."""


def of_one_sensor(traces: Sequence[Trace]) -> list[NoiseFloor]:
    """The noise floors of records; those that were extrapolated, in the colour of the surest one that was not and was
    read and sampled as they were, or, with none, of the one that describes best what all of these show. Where samples
    say nothing, curves across them have no noise, and say nothing of its colour."""
    whole = [t for t in traces if t.masked is None]
    seen = [t for t in whole if not extrapolated(t.noise) and 0.0 < t.noise.relative_error < EXTRAPOLATED]
    seen.sort(key=lambda trace: trace.noise.relative_error)
    shown = {id(t): _Shown.of(t) for t in whole if extrapolated(t.noise)}
    told = [t for t in whole if id(t) in shown and t.noise.relative_error < VAGUE]
    told.sort(key=lambda t: sum(one.deviance(t.noise) for o in whole if alike(o, t) and (one := shown.get(id(o)))))
    return [_in_the_best_colour(trace, [*seen, *told], shown.get(id(trace))) for trace in traces]


def alike(one: Trace, other: Trace) -> bool:
    """Whether two records were read and sampled the same way."""
    return one.measures == other.measures and bool(np.isclose(one.step, other.step, rtol=_SAME, atol=0.0))


class _Shown(NamedTuple):
    """What a record shows of its noise: its power at the frequencies that its motion leaves free."""

    power: np.ndarray
    free: np.ndarray

    @classmethod
    def of(cls, trace: Trace) -> _Shown:
        """Of the frequencies that an extrapolated floor was read off."""
        seen = windowed(latest(trace.response))
        power = np.abs(np.fft.rfft(seen)) ** 2 / len(seen)
        free = np.arange(len(power)) >= trace.noise.unseen * len(power)
        return cls(power, free & ~outliers(power, 1.0 - free, _spectrum(trace.noise, len(power))))

    def level(self, floor: NoiseFloor) -> float:
        """By how much the power is larger than that of a floor."""
        return float(np.mean(self.power[self.free] / _spectrum(floor, len(self.power))[self.free]))

    def deviance(self, floor: NoiseFloor) -> float:
        """−2 log likelihood of noise of the colour of a floor, at the level that fits best."""
        expected = self.level(floor) * _spectrum(floor, len(self.power))[self.free]
        return 2.0 * float(np.sum(np.log(expected) + self.power[self.free] / expected))


def _in_the_best_colour(trace: Trace, seen: Sequence[Trace], shown: _Shown | None) -> NoiseFloor:
    """The floor of a record in the colour of the first of those that are `seen` of its sensor, where that describes the
    frequencies that it was read off as well as its own coefficients do, by the criterion that chose these."""
    own = trace.noise
    surest = next((other.noise for other in seen if alike(trace, other)), own)
    if surest is own or shown is None:
        return own
    count, further = int(np.count_nonzero(shown.free)), extrapolated(surest)
    if shown.deviance(surest) > shown.deviance(own) + ORDER_PRICE * min(len(own.ar), NUMBERS) * np.log(count):
        return own
    wider = 1.0 if further else WIDER  # which says it already
    error = wider * float(np.hypot(surest.relative_error, np.sqrt(0.25 / count)))
    method = f"{own.method}, in the colour of a record that shows {'more' if further else 'the others too'}"
    sigma = surest.sigma * shown.level(surest) ** 0.5
    return replace(own, sigma=sigma, ar=surest.ar, method=method, relative_error=error)


@lru_cache(maxsize=8)  # a colour is asked of many records as long as one another
def _spectrum(floor: NoiseFloor, count: int) -> np.ndarray:
    """Its power at the `count` frequencies of a periodogram."""
    ar = np.array(floor.ar)
    return ar_spectrum(ar, floor.sigma**2 / variance_of(ar, 1.0), 2 * (count - 1))
