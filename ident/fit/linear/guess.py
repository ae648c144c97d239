"""Starting values read off the records themselves: resonance, quality factor, drive gain, and the size of everything.

For a trial resonance the response of a linear oscillator to the measured drive is one filter; gain, initial states and
an offset then follow from linear least squares (variable projection: G. H. Golub, V. Pereyra, SIAM J. Numer. Anal. 10
(1973) 413). Every record is weighted by its own size, so that a strongly nonlinear one does not rule the others.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from functools import lru_cache
from typing import NamedTuple

import numpy as np
from scipy import optimize

from ...campaign.record import Trace
from .decay import read_ringing
from .stretches import Stretch, highest_content, liveliest, stretch_of, sums

_QUALITIES = (4.0, 15.0, 60.0)  # at each frequency of the grid
LEAST_QUALITY = 0.5  # below, nothing oscillates
_LOG_QUALITY = 9.0  # beyond e⁹, nothing decays within a record
_POINTS_PER_OCTAVE = 14  # of the grid
GRID_STEP = math.log(2) / _POINTS_PER_OCTAVE  # in ln f
_LINES = 2  # of each record, where it is liveliest: between the points of the grid a sharp resonance is not seen
_SAME = 0.005  # in ln f: so near two of them are tried once
_STEP, _CYCLE = 0.03, 0.1  # first step of the search in ln f; of a decay, so much of a cycle at its end


class LinearGuess(NamedTuple):
    """`frequency` (Hz), `quality`, and `gain` ((m/s²)/V) of the linear oscillator nearest to the records; `misfit`,
    the rms of what it leaves divided by the rms of the records."""

    frequency: float
    quality: float
    gain: float
    misfit: float


class DataScales(NamedTuple):
    """The largest values in the records, by which shape parameters are placed (SI); `slew`, of the rms rate of the
    voltage, V/s."""

    displacement: float
    velocity: float
    voltage: float
    period: float
    duration: float
    slew: float
    one: float = 1.0

    @property
    def induction(self) -> float:
        """The voltage over the velocity, as that which a coil induces."""
        return self.voltage / self.velocity

    @property
    def nearness(self) -> float:
        """One over the displacement, as of something that acts from so far away."""
        return 1.0 / self.displacement

    @property
    def squared_nearness(self) -> float:
        """The square of that, as of a force whose slope comes to an end."""
        return self.nearness**2

    @property
    def per_squared_velocity(self) -> float:
        """One over the square of the velocity, as of a power whose warmth changes what it comes from."""
        return self.velocity**-2

    @property
    def slowness(self) -> float:
        """One over the rms rate of the voltage, as of an amplifier that can just follow it."""
        return 1.0 / self.slew


def guess_linear(
    records: Sequence[Trace],
    nominal_frequency: float | None = None,
    held: float | None = None,
    mass: float = 1.0,
) -> LinearGuess:
    """The linear oscillator nearest to the records; `held`: its quality factor, if that is known; its `mass`, kg, that
    the records' loads are added to."""
    return _searched(tuple(records), nominal_frequency, held, mass)


@lru_cache(maxsize=32)  # every model of a campaign starts from it
def _searched(
    records: tuple[Trace, ...], nominal_frequency: float | None, held: float | None, mass: float
) -> LinearGuess:
    stretches = [stretch_of(record) for record in records]
    grid = _frequencies(records, nominal_frequency)
    qualities = _QUALITIES if held is None else (held,)
    ringings = [found for r in records if not r.driven and (found := read_ringing(r.response, r.step)) is not None]
    read = [(ringing.frequency, ringing.quality if held is None else held) for ringing in ringings]
    trials = [(_misfit(stretches, f, q, mass), f, q) for f, q in [*((f, q) for q in qualities for f in grid), *read]]
    trials.sort()
    step = min([_STEP, *(_CYCLE / ringing.cycles for ringing in ringings)])
    best = trials[0]
    # Without inertia in the records the search would run off to frequencies that no sample can follow.
    within = [(math.log(grid.min() / 2), math.log(grid.max() * 2)), (math.log(LEAST_QUALITY), _LOG_QUALITY)]
    for start in _distinct(trials)[:2]:
        found = optimize.minimize(
            lambda x: _misfit(stretches, math.exp(x[0]), math.exp(x[1]) if held is None else held, mass),
            [math.log(start[1]), math.log(start[2])],
            method="Nelder-Mead",
            bounds=within,
            options={
                "initial_simplex": _simplex(start[1], start[2], step),
                "xatol": 1e-5,
                "fatol": 1e-9,
                "maxiter": 80,
            },
        )
        quality = math.exp(found.x[1]) if held is None else held
        best = min(best, (float(found.fun), math.exp(found.x[0]), quality))
    misfit, frequency, quality = best
    return LinearGuess(frequency, quality, _gain(stretches, frequency, quality, mass), misfit)


def coarse_frequency(records: Sequence[Trace], among: Sequence[Trace], mass: float) -> float:
    """The best frequency (Hz) for some records of a campaign, on the grid for all of them; good to a step of it. `mass`
    as of `guess_linear`."""
    stretches = [stretch_of(record) for record in records]
    return min((_misfit(stretches, f, q, mass), f) for q in _QUALITIES for f in _frequencies(among, None))[1]


def told_guess(start: Mapping[str, float], names: Sequence[str]) -> LinearGuess | None:
    """The linear model of starting values by name; None if they leave one of the three `names` open."""
    if not all(name in start for name in names):
        return None
    frequency, quality, gain = (float(start[name]) for name in names)
    return LinearGuess(frequency, quality, gain, float("nan"))


def data_scales(records: Sequence[Trace], frequency: float) -> DataScales:
    """Largest displacement, velocity, voltage; period of the resonance; longest duration."""
    return _scales(tuple(records), frequency)


@lru_cache(maxsize=32)
def _scales(records: tuple[Trace, ...], frequency: float) -> DataScales:
    omega = 2 * np.pi * frequency
    displacement = max(float(np.max(np.abs(r.response - np.mean(r.response)))) / omega**r.order for r in records)
    velocity = 0.0
    for record in records:
        # A spring may be as good as none: the slope is that of the motion, whatever the resonance is.
        liveliest_at = max(liveliest(record.response, record.step, 1), default=0.0)
        half = max(int(0.05 / (max(frequency, liveliest_at) * record.step)), 2)
        if len(record.response) > 2 * half + 1:
            line = np.arange(half, -half - 1, -1)  # slope of the straight line through the samples around each one
            slope = np.convolve(record.response, line, "valid") / (np.sum(line**2) * record.step)
            velocity = max(velocity, float(np.percentile(np.abs(slope), 99.5)) / omega**record.order)
    voltage = max(float(np.max(np.abs(r.drive))) for r in records) or 1.0  # where nothing drives, any scale does
    duration = max(r.into + float(r.time[-1] - r.time[0]) for r in records)  # since its record began
    slew = max(float(np.sqrt(np.mean(np.diff(r.drive) ** 2))) / r.step for r in records) or voltage * omega
    return DataScales(displacement, velocity, voltage, 1.0 / frequency, duration, slew)


def _frequencies(records: Sequence[Trace], nominal: float | None) -> np.ndarray:
    lowest = min(2.0 / (r.time[-1] - r.time[0]) for r in records)
    highest = max(0.3 / r.step for r in records)
    # A signal above a resonance falls with the square of the frequency: nothing is seen far beyond the drive's band.
    band = max(_highest_content(r) for r in records)
    highest = min(highest, 8 * band)
    grid = np.geomspace(lowest, highest, max(int(_POINTS_PER_OCTAVE * math.log2(highest / lowest)), 8))
    lively = np.array([hz for r in records for hz in liveliest(r.response, r.step, _LINES) if lowest < hz < highest])
    told = lively if nominal is None else np.append(lively, nominal)
    _, apart = np.unique(np.round(np.log(told) / _SAME), return_index=True)
    return np.append(grid, told[apart])


def _highest_content(record: Trace) -> float:
    """Frequency below which 99.9 % of the drive's and the response's power lies, Hz."""
    return max(highest_content(x, record.step) for x in (record.drive, record.response))


def _misfit(stretches: Sequence[Stretch], frequency: float, quality: float, mass: float) -> float:
    seen = sums(stretches, frequency, quality, mass)
    driven = any(stretch.driven for stretch in stretches)
    if driven and not (np.isfinite(seen.forced) and seen.forced > 0.0):
        return 1.0
    left = seen.measured - (seen.both**2 / seen.forced if driven else 0.0)
    return math.sqrt(max(left, 0.0) / seen.power)


def _gain(stretches: Sequence[Stretch], frequency: float, quality: float, mass: float) -> float:
    if not any(stretch.driven for stretch in stretches):
        return 0.0
    seen = sums(stretches, frequency, quality, mass)
    return seen.both / seen.forced


def _distinct(trials: list[tuple[float, float, float]]) -> list[tuple[float, float, float]]:
    kept: list[tuple[float, float, float]] = []
    for trial in trials:
        if all(abs(math.log(trial[1] / other[1])) > 0.1 for other in kept):
            kept.append(trial)
    return kept


def _simplex(frequency: float, quality: float, step: float) -> np.ndarray:
    x, y = math.log(frequency), math.log(quality)
    return np.array([[x, y], [x + step, y], [x, y + 0.4]])
