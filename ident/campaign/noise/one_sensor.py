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
from .autoregression import ORDER_PRICE, ROUNDS, ar_spectrum, outliers, variance_of
from .floor import EXTRAPOLATED, NUMBERS, extrapolated, latest, windowed
from .tail import Beside, beside_a_tail, deviance_of

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
    told.sort(
        key=lambda t: sum(one.beside(t.noise).deviance for o in whole if alike(o, t) and (one := shown.get(id(o))))
    )
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
        """Of the frequencies that an extrapolated floor was read off, but for lines that stick out: of its noise and of
        the tail that a motion has there, for else the tail's foot would stick out."""
        seen = windowed(latest(trace.response))
        power = np.abs(np.fft.rfft(seen)) ** 2 / len(seen)
        above = np.arange(len(power)) >= trace.noise.unseen * len(power)
        shown, place = cls(power, above), np.flatnonzero(above)
        for _ in range(ROUNDS):
            expected = np.ones(len(power))
            beside = np.log(shown.beside(trace.noise).expected)
            expected[above] = np.exp(np.interp(place, np.flatnonzero(shown.free), beside))
            shown = cls(power, above & ~outliers(power, 1.0 - above, expected))
        return shown

    @property
    def price(self) -> float:
        """Of a number that describes it, in −2 log likelihood."""
        return ORDER_PRICE * float(np.log(np.count_nonzero(self.free)))

    def beside(self, floor: NoiseFloor) -> Beside:
        """It as noise of the colour of a floor, beside the tail of a motion where it has one."""
        place = np.flatnonzero(self.free)
        noise = _spectrum(floor, len(self.power))[self.free]
        return beside_a_tail(self.power[self.free], noise, place / place[0], self.price)

    def deviance(self, floor: NoiseFloor) -> float:
        """−2 log likelihood of noise of the colour of a floor, and of nothing else, at the level that fits best."""
        noise, power = _spectrum(floor, len(self.power))[self.free], self.power[self.free]
        return deviance_of(power, float(np.mean(power / noise)) * noise)


def _in_the_best_colour(trace: Trace, seen: Sequence[Trace], shown: _Shown | None) -> NoiseFloor:
    """The floor of a record in the colour of the first of those that are `seen` of its sensor, where that, beside a
    tail, describes the frequencies that it was read off as well as its own coefficients do, which were fitted as if
    all of them showed noise alone, by the criterion that chose these: a colour unlike that of the sensor's other
    records is a number at least, if it is white too."""
    own = trace.noise
    surest = next((other.noise for other in seen if alike(trace, other)), own)
    if surest is own or shown is None:
        return own
    beside, further = shown.beside(surest), extrapolated(surest)
    if beside.deviance > shown.deviance(own) + shown.price * min(max(len(own.ar), 1), NUMBERS):
        return own
    wider = 1.0 if further else WIDER  # which says it already
    error = min(1.0, wider * float(np.hypot(surest.relative_error, 0.5 * beside.error)))
    method = f"{own.method}, in the colour of a record that shows {'more' if further else 'the others too'}"
    return replace(own, sigma=surest.sigma * beside.level**0.5, ar=surest.ar, method=method, relative_error=error)


@lru_cache(maxsize=8)  # a colour is asked of many records as long as one another
def _spectrum(floor: NoiseFloor, count: int) -> np.ndarray:
    """Its power at the `count` frequencies of a periodogram."""
    ar = np.array(floor.ar)
    return ar_spectrum(ar, floor.sigma**2 / variance_of(ar, 1.0), 2 * (count - 1))
