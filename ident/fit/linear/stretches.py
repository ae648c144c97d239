"""A record as the searches for a linear model see it, and what an oscillator answers to its drive."""

from __future__ import annotations

import cmath
import math
from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import lru_cache
from typing import NamedTuple

import numpy as np

from ...campaign.corners import corners
from ...campaign.drive import half_step_drive
from ...campaign.noise.recursive import recursive_filter
from ...campaign.record import Trace
from ...campaign.smooth_drive import smooth_drive

_MOST_SAMPLES = 4000  # of a record: enough to place a resonance, and long records stay cheap
_STRAIGHT = 0.13  # of the sampling rate: between the samples of slower drives a line is low by less than 6 %
_REACH = 32  # samples to either side that a smooth drive depends on: those beyond count for less than 10⁻⁴
_CRITICAL = 0.4999  # quality below which a start in motion leaves two exponentials


class Sums(NamedTuple):
    """Of records without what the start may add to them: `forced` x·x, `both` x·y and `measured` y·y of the response x
    to the drive for unit gain and of the measured y; `power` of what was there to explain."""

    forced: float
    both: float
    measured: float
    power: float


class Stretch(NamedTuple):
    """A record for the linear search: its liveliest stretch, the response divided by its `size`; `rest`: whether it
    starts from rest; `power` of the response about its mean; `order` of the derivative of the displacement that it is;
    `edge` of a drive that is held and `load` of the device, as of `Trace`; `finer`: into how many parts its sampling
    intervals are divided, as a `smooth` drive is no line between few samples per period, and the `rate` there, per s;
    `sums` that have been asked for, by frequency, quality and mass."""

    step: float
    drive: np.ndarray
    smooth: np.ndarray
    rate: np.ndarray
    response: np.ndarray
    size: float
    rest: bool
    driven: bool
    power: float
    order: int
    edge: float | None
    load: float
    finer: int
    sums: dict[tuple[float, float, float], Sums]

    @property
    def parts(self) -> int:
        """Points of the grid, on which linear systems are driven, to a sampling interval."""
        return self.finer if self.edge is None else 1

    @property
    def push(self) -> np.ndarray:
        """The drive on that grid: what lines between its points, or values that are held, make of it is the drive."""
        return self.smooth if self.edge is None else self.drive

    @property
    def push_rate(self) -> np.ndarray:
        """Its rate there, per s."""
        return self.rate if self.edge is None else self.rate[:: self.finer]


@lru_cache(maxsize=256)
def stretch_of(record: Trace) -> Stretch:
    """A record for the linear search."""
    part = _liveliest(record.response)
    size = float(np.std(record.response[part])) or 1.0
    response = record.response[part] / size
    smooth, finer = _dense(record.drive, part) if record.driven else (record.drive[part], 1)
    rate = half_step_drive(replace(record, edge=None), finer)[1][::2][finer * part.start :][: len(smooth)]
    return Stretch(
        record.step,
        record.drive[part],
        smooth,
        rate,
        response,
        size,
        record.start == "rest" and part.start == 0,
        record.driven,
        float(np.sum((response - np.mean(response)) ** 2)),
        record.order,
        record.edge,
        record.load,
        finer,
        {},
    )


def _dense(drive: np.ndarray, part: slice) -> tuple[np.ndarray, int]:
    """The drive (n,) in a part of the record at so many points to a sampling interval that lines between them make it,
    sharpened by what they take from its curvature; and how many they are. One with corners is made of lines."""
    last = min(part.stop, len(drive)) - 1
    first, beyond = max(part.start - _REACH, 0), min(last + 1 + _REACH, len(drive))
    if corners(drive):
        return drive[part], 1
    finer = math.ceil(highest_content(drive, 1.0) / _STRAIGHT)
    places = np.arange((last - part.start) * finer + 1) / finer + part.start - first
    curve = smooth_drive(drive[first:beyond])(places)
    curve[1:-1] -= np.diff(curve, 2) / 12
    return curve, finer


def _liveliest(response: np.ndarray) -> slice:
    """The stretch of a long record that moves most; a lab may wait long before it drives."""
    starts = range(0, max(len(response) - _MOST_SAMPLES, 0) + 1, _MOST_SAMPLES // 2)
    first = max(starts, key=lambda i: float(np.std(response[i : i + _MOST_SAMPLES])))
    return slice(first, first + _MOST_SAMPLES)


def highest_content(signal: np.ndarray, step: float) -> float:
    """Frequency below which 99.9 % of a signal's power lies, Hz; (n,) samples, one every `step` s."""
    power = np.abs(np.fft.rfft((signal - np.mean(signal)) * np.hanning(len(signal)))) ** 2
    index = int(np.searchsorted(np.cumsum(power), 0.999 * np.sum(power)))
    return max(index, 1) / (len(signal) * step)


def liveliest(signal: np.ndarray, step: float, most: int) -> list[float]:
    """Frequencies of the strongest peaks of a signal's spectrum, Hz; (n,) samples, one every `step` s."""
    power = np.abs(np.fft.rfft((signal - np.mean(signal)) * np.hanning(len(signal))))
    peaks = np.flatnonzero((power[1:-1] > power[:-2]) & (power[1:-1] >= power[2:])) + 1
    return [float(k / (len(signal) * step)) for k in peaks[np.argsort(-power[peaks])][:most]]


def answered(
    stretch: Stretch, filter_of: Callable[[float], tuple[np.ndarray, np.ndarray]], push: np.ndarray
) -> np.ndarray:
    """What a linear system answers at the samples (n,) or (n, k) to a push on the grid of `Stretch.push`; `filter_of` a
    step of that grid: its digital filter, exact for a push that is linear between the points, or held."""
    return recursive_filter(*filter_of(stretch.step / stretch.parts), push)[:: stretch.parts]


def oscillator_filter(
    frequency: float, quality: float, step: float, order: int = 0, edge: float | None = None
) -> tuple[np.ndarray, np.ndarray]:
    """Digital filter (b, a) of z̈ + (ω0/Q) ż + ω0² z = u, exact for an input that is linear between samples, or held
    (`edge`, see `Trace`); of z, or of its derivative of some `order` up to 2.

    The response to one triangle of input is the second difference of the response p(t) to a ramp, that to a value that
    is held the difference of p'(t); the poles are those of the oscillator, so three terms of that response fix the
    numerator.

    Source: K. J. Åström, B. Wittenmark, Computer-Controlled Systems, 1997, §2.3 (zero- and first-order hold).
    """
    omega = 2 * math.pi * frequency
    decay = omega / (2 * quality)
    ringing = cmath.sqrt(omega**2 - decay**2) or 1e-9 * omega

    ways = lambda t: (np.exp((-decay + sign * 1j * ringing) * t) for sign in (1, -1))

    def ramp(t: np.ndarray, order: int) -> np.ndarray:
        one, other = ways(t)
        # decaying; sine over its frequency
        cosine, sine = np.real(one + other) / 2, np.real((one - other) / (2j * ringing))
        if order == 0:
            return t / omega**2 - 2 * decay / omega**4 * (1.0 - cosine) + (2 * decay**2 - omega**2) / omega**4 * sine
        if order == 1:
            return (1.0 - cosine - decay * sine) / omega**2
        return sine if order == 2 else cosine - decay * sine

    return sampled_filter(
        ramp, np.array([1.0, -float(np.real(sum(ways(step)))), math.exp(-2 * decay * step)]), step, order, edge
    )


def sampled_filter(
    ramp: Callable[[np.ndarray, int], np.ndarray], a: np.ndarray, step: float, order: int, edge: float | None
) -> tuple[np.ndarray, np.ndarray]:
    """Numerator and denominator `a` (3,) of a system of two poles, from the derivative of some order of its response to
    a `ramp`, at times (n,)."""
    if edge is None:
        p, late = ramp(step * np.arange(4), order), 0
        g = np.array([p[1], p[2] - 2 * p[1], p[3] - 2 * p[2] + p[1]]) / step
    else:  # after so many whole intervals a value has acted since a part of one
        late = max(math.ceil(edge), 0)
        p = ramp(step * (late - edge + np.arange(3)), order + 1)
        g = np.array([p[0], p[1] - p[0], p[2] - p[1]])
    b = np.array([g[0], g[1] + a[1] * g[0], g[2] + a[1] * g[1] + a[2] * g[0]])
    return np.concatenate([np.zeros(late), b]), a


def free_motion(stretch: Stretch, frequency: float, quality: float) -> np.ndarray:
    """What a start in motion may add to the response, (n, 2)."""
    omega = 2 * math.pi * frequency
    t = stretch.step * np.arange(len(stretch.drive))
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


def sums(stretches: Sequence[Stretch], frequency: float, quality: float, mass: float) -> Sums:
    """The records as a trial frequency and quality of the unloaded `mass`, kg, see them.

    A driven record must be explained by its drive: the share of its power that is left beside its free motion counts.
    A decay is free motion, and all of it counts.
    """
    alike: dict[tuple, list[Stretch]] = {}
    for stretch in stretches:  # what is known is remembered: campaigns that differ by a record ask for the others again
        if (frequency, quality, mass) not in stretch.sums:
            alike.setdefault(
                (
                    stretch.step,
                    len(stretch.drive),
                    stretch.rest,
                    stretch.driven,
                    stretch.order,
                    stretch.edge,
                    stretch.load,
                    stretch.finer,
                ),
                [],
            ).append(stretch)
    for group in alike.values():
        heavier = 1 + group[0].load / mass
        loaded = frequency / math.sqrt(heavier), quality * math.sqrt(heavier)
        for stretch, found in zip(group, _projected(group, *loaded, heavier), strict=True):
            stretch.sums[frequency, quality, mass] = found
    return Sums(*np.sum([stretch.sums[frequency, quality, mass] for stretch in stretches], axis=0))


def _projected(stretches: Sequence[Stretch], frequency: float, quality: float, heavier: float) -> list[Sums]:
    """`sums` of each of several records with one clock, start, load and sensor: one filter and one free motion serve
    all. Frequency and quality are those of the loaded device, `heavier` so many times."""
    first = stretches[0]
    measured = np.stack([stretch.response for stretch in stretches])
    forced = np.zeros_like(measured)  # to a decay a constant drive is a level, whatever the gain
    if first.driven:
        drives = np.stack([stretch.push / (stretch.size * heavier) for stretch in stretches], axis=1)
        filter_of = lambda step: oscillator_filter(frequency, quality, step, first.order, first.edge)
        forced = answered(first, filter_of, drives).T
    both = np.stack([forced, measured])
    if first.rest:
        both -= both.mean(axis=2, keepdims=True)
    else:
        constant = np.ones((len(first.drive), 1))
        basis, _ = np.linalg.qr(np.hstack([constant, free_motion(first, frequency, quality)]))
        both -= both @ basis @ basis.T
    xx, xy, yy = (np.sum(both[i] * both[j], axis=1) for i, j in ((0, 0), (0, 1), (1, 1)))
    powers = yy if first.driven else [stretch.power for stretch in stretches]
    return [Sums(*map(float, found)) for found in zip(xx, xy, yy, powers, strict=True)]
