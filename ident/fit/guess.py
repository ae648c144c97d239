"""Starting values read off the records themselves: resonance, quality factor, drive gain, and the size of everything.

For a trial resonance the response of a linear oscillator to the measured drive is one filter; gain, initial states
and an
offset then follow from linear least squares (variable projection: G. H. Golub, V. Pereyra, SIAM J. Numer. Anal. 10
(1973) 413). Every record is weighted by its own size, so that a strongly nonlinear one does not rule the others.
"""

from __future__ import annotations

import cmath
import math
from collections.abc import Mapping, Sequence
from functools import lru_cache
from typing import NamedTuple

import numpy as np
from scipy import optimize

from ..campaign.record import Trace
from ..campaign.recursive import recursive_filter
from .decay import read_ringing

_MOST_SAMPLES = 4000  # of a record: enough to place a resonance, and long records stay cheap
_QUALITIES = (4.0, 15.0, 60.0)
_CRITICAL = 0.4999  # quality below which a start in motion leaves two exponentials
_LEAST_QUALITY, _LOG_QUALITY = 0.5, 9.0  # below, nothing oscillates; beyond e⁹, nothing decays within a record
_POINTS_PER_OCTAVE = 14
GRID_STEP = math.log(2) / _POINTS_PER_OCTAVE  # in ln f
_STEP, _CYCLE = 0.03, 0.1  # first step of the search in ln f; of a decay, so much of a cycle at its end


class LinearGuess(NamedTuple):
    """`frequency` (Hz), `quality`, and `gain` ((m/s²)/V) of the linear oscillator nearest to the records; `misfit`,
    the rms of what it leaves divided by the rms of the records."""

    frequency: float
    quality: float
    gain: float
    misfit: float


class DataScales(NamedTuple):
    """The largest values in the records, by which shape parameters are placed (SI)."""

    displacement: float
    velocity: float
    voltage: float
    period: float
    duration: float
    one: float = 1.0


def guess_linear(
    records: Sequence[Trace], nominal_frequency: float | None = None, held: float | None = None
) -> LinearGuess:
    """The linear oscillator nearest to the records; `held`: its quality factor, if that is known."""
    return _searched(tuple(records), nominal_frequency, held)


@lru_cache(maxsize=32)  # every model of a campaign starts from it
def _searched(records: tuple[Trace, ...], nominal_frequency: float | None, held: float | None) -> LinearGuess:
    pieces = [make_piece(record) for record in records]
    grid = _frequencies(records, nominal_frequency)
    qualities = _QUALITIES if held is None else (held,)
    ringings = [found for r in records if not r.driven and (found := read_ringing(r.response, r.step)) is not None]
    read = [(ringing.frequency, ringing.quality if held is None else held) for ringing in ringings]
    trials = [(_misfit(pieces, f, q), f, q) for f, q in [*((f, q) for q in qualities for f in grid), *read]]
    trials.sort()
    step = min([_STEP, *(_CYCLE / ringing.cycles for ringing in ringings)])
    best = trials[0]
    # Without inertia in the records the search would run off to frequencies that no sample can follow.
    within = [(math.log(grid.min() / 2), math.log(grid.max() * 2)), (math.log(_LEAST_QUALITY), _LOG_QUALITY)]
    for start in _distinct(trials)[:2]:
        found = optimize.minimize(
            lambda x: _misfit(pieces, math.exp(x[0]), math.exp(x[1]) if held is None else held),
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
    return LinearGuess(frequency, quality, _gain(pieces, frequency, quality), misfit)


def coarse_frequency(records: Sequence[Trace], among: Sequence[Trace], held: float | None = None) -> float:
    """The best frequency (Hz) for some records of a campaign, on the grid for all of them; good to a step of it."""
    pieces = [make_piece(record) for record in records]
    qualities = _QUALITIES if held is None else (held,)
    return min((_misfit(pieces, f, q), f) for q in qualities for f in _frequencies(among, None))[1]


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
        half = max(int(0.05 / (frequency * record.step)), 2)
        if len(record.response) > 2 * half + 1:
            line = np.arange(half, -half - 1, -1)  # slope of the straight line through the samples around each one
            slope = np.convolve(record.response, line, "valid") / (np.sum(line**2) * record.step)
            velocity = max(velocity, float(np.percentile(np.abs(slope), 99.5)) / omega**record.order)
    voltage = max(float(np.max(np.abs(r.drive))) for r in records) or 1.0  # where nothing drives, any scale does
    duration = max(float(r.time[-1] - r.time[0]) for r in records)
    return DataScales(displacement, velocity, voltage, 1.0 / frequency, duration)


class Piece(NamedTuple):
    """A record for the linear search: its liveliest stretch, the response divided by its `size`; `rest`: whether it
    starts from rest; `power` of the response about its mean; `order` of the derivative of the displacement that it is;
    `sums` that have been asked for, by frequency and
    quality."""

    step: float
    drive: np.ndarray
    response: np.ndarray
    size: float
    rest: bool
    driven: bool
    power: float
    order: int
    sums: dict[tuple[float, float], _Sums]


@lru_cache(maxsize=256)
def make_piece(record: Trace) -> Piece:
    """A record for the linear search."""
    part = _liveliest(record.response)
    size = float(np.std(record.response[part])) or 1.0
    rest = record.start == "rest" and part.start == 0
    response = record.response[part] / size
    power = float(np.sum((response - np.mean(response)) ** 2))
    return Piece(record.step, record.drive[part], response, size, rest, record.driven, power, record.order, {})


def _liveliest(response: np.ndarray) -> slice:
    """The stretch of a long record that moves most; a lab may wait long before it drives."""
    starts = range(0, max(len(response) - _MOST_SAMPLES, 0) + 1, _MOST_SAMPLES // 2)
    first = max(starts, key=lambda i: float(np.std(response[i : i + _MOST_SAMPLES])))
    return slice(first, first + _MOST_SAMPLES)


def _frequencies(records: Sequence[Trace], nominal: float | None) -> np.ndarray:
    lowest = min(2.0 / (r.time[-1] - r.time[0]) for r in records)
    highest = max(0.3 / r.step for r in records)
    # A signal above a resonance falls with the square of the frequency: nothing is seen far beyond the drive's band.
    band = max(_highest_content(r) for r in records)
    highest = min(highest, 8 * band)
    grid = np.geomspace(lowest, highest, max(int(_POINTS_PER_OCTAVE * math.log2(highest / lowest)), 8))
    return grid if nominal is None else np.append(grid, nominal)


def _highest_content(record: Trace) -> float:
    """Frequency below which 99.9 % of the drive's and the response's power lies, Hz."""
    return max(highest_content(x, record.step) for x in (record.drive, record.response))


def highest_content(signal: np.ndarray, step: float) -> float:
    """Frequency below which 99.9 % of a signal's power lies, Hz; (n,) samples, one every `step` s."""
    power = np.abs(np.fft.rfft((signal - np.mean(signal)) * np.hanning(len(signal)))) ** 2
    index = int(np.searchsorted(np.cumsum(power), 0.999 * np.sum(power)))
    return max(index, 1) / (len(signal) * step)


def oscillator_filter(frequency: float, quality: float, step: float, order: int = 0) -> tuple[np.ndarray, np.ndarray]:
    """Digital filter (b, a) of z̈ + (ω0/Q) ż + ω0² z = u, exact for an input that is linear between samples; of z, or of
    its derivative of some `order` up to 2.

    The response to one triangle of input is the second difference of the response p(t) to a ramp; the poles are those
    of the oscillator, so three terms of that response fix the numerator.

    Source: K. J. Åström, B. Wittenmark, Computer-Controlled Systems, 1997, §2.3 (first-order hold).
    """
    omega = 2 * math.pi * frequency
    decay = omega / (2 * quality)
    ringing = cmath.sqrt(omega**2 - decay**2) or 1e-9 * omega
    t = step * np.arange(4)
    one, other = (np.exp((-decay + sign * 1j * ringing) * t) for sign in (1, -1))
    cosine, sine = (
        np.real(one + other) / 2,
        np.real((one - other) / (2j * ringing)),
    )  # decaying; sine over its frequency
    if order == 0:
        p = t / omega**2 - 2 * decay / omega**4 * (1.0 - cosine) + (2 * decay**2 - omega**2) / omega**4 * sine
    elif order == 1:
        p = (1.0 - cosine - decay * sine) / omega**2
    else:
        p = sine
    a = np.array([1.0, -2 * cosine[1], math.exp(-2 * decay * step)])
    g = np.array([p[1], p[2] - 2 * p[1], p[3] - 2 * p[2] + p[1]]) / step
    return np.array([g[0], g[1] + a[1] * g[0], g[2] + a[1] * g[1] + a[2] * g[0]]), a


def free_motion(piece: Piece, frequency: float, quality: float) -> np.ndarray:
    """What a start in motion may add to the response, (n, 2)."""
    omega = 2 * math.pi * frequency
    t = piece.step * np.arange(len(piece.drive))
    decay = np.exp(-omega / (2 * quality) * t)
    if quality < _CRITICAL:  # two exponentials
        fast, slow = _rates(omega, quality)
        return np.stack([np.exp(-slow * t), np.exp(-fast * t)], axis=1)
    ring = omega * math.sqrt(max(1 - 1 / (4 * quality**2), 1e-6)) * t
    return np.stack([decay * np.cos(ring), decay * np.sin(ring)], axis=1)


def _rates(omega: float, quality: float) -> tuple[float, float]:
    """The fast and the slow rate (1/s) at which an overdamped oscillator comes to rest."""
    fast = omega / (2 * quality) * (1 + math.sqrt(1 - 4 * quality**2))
    return fast, omega**2 / fast


class _Sums(NamedTuple):
    """Of records without what the start may add to them: `forced` x·x, `both` x·y and `measured` y·y of the response x
    to the drive for unit gain and of the measured y; `power` of what was there to explain."""

    forced: float
    both: float
    measured: float
    power: float


def _sums(pieces: Sequence[Piece], frequency: float, quality: float) -> _Sums:
    """The records as a trial frequency and quality see them.

    A driven record must be explained by its drive: the share of its power that is left beside its free motion counts.
    A decay is free motion, and all of it counts.
    """
    return _Sums(*np.sum([_sums_of(piece, frequency, quality) for piece in pieces], axis=0))


def _sums_of(piece: Piece, frequency: float, quality: float) -> _Sums:
    """Of one record, remembered: campaigns that differ by a record ask for the others again."""
    known = piece.sums.get((frequency, quality))
    if known is None:
        known = piece.sums[frequency, quality] = _projected(piece, frequency, quality)
    return known


def _projected(piece: Piece, frequency: float, quality: float) -> _Sums:
    column = np.zeros_like(piece.drive)  # to a decay a constant drive is a level, whatever the gain
    if piece.driven:
        column = recursive_filter(*oscillator_filter(frequency, quality, piece.step, piece.order), piece.drive)
    both = np.stack([column / piece.size, piece.response])
    if piece.rest:
        both -= both.mean(axis=1, keepdims=True)
    else:
        constant = np.ones((len(piece.drive), 1))
        basis, _ = np.linalg.qr(np.hstack([constant, free_motion(piece, frequency, quality)]))
        both -= both @ basis @ basis.T
    (xx, xy), (_, yy) = both @ both.T
    return _Sums(float(xx), float(xy), float(yy), float(yy) if piece.driven else piece.power)


def _misfit(pieces: Sequence[Piece], frequency: float, quality: float) -> float:
    sums = _sums(pieces, frequency, quality)
    driven = any(piece.driven for piece in pieces)
    if driven and not (np.isfinite(sums.forced) and sums.forced > 0.0):
        return 1.0
    left = sums.measured - (sums.both**2 / sums.forced if driven else 0.0)
    return math.sqrt(max(left, 0.0) / sums.power)


def _gain(pieces: Sequence[Piece], frequency: float, quality: float) -> float:
    if not any(piece.driven for piece in pieces):
        return 0.0
    sums = _sums(pieces, frequency, quality)
    return sums.both / sums.forced


def _distinct(trials: list[tuple[float, float, float]]) -> list[tuple[float, float, float]]:
    kept: list[tuple[float, float, float]] = []
    for trial in trials:
        if all(abs(math.log(trial[1] / other[1])) > 0.1 for other in kept):
            kept.append(trial)
    return kept


def _simplex(frequency: float, quality: float, step: float) -> np.ndarray:
    x, y = math.log(frequency), math.log(quality)
    return np.array([[x, y], [x + step, y], [x, y + 0.4]])
