"""What may be wrong with a record as a whole, each told by one number: delay, gain, sign, drift, dropped samples.

A record (n,) is compared with what the model predicts for it, (n,), once the number that suits it best is in; and the
record as it should have been read is made of it, so that a fit can say what all records then say together.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np
from scipy.interpolate import CubicSpline
from scipy.optimize import minimize_scalar

from ...campaign.corners import drive_at
from ...campaign.late import in_time
from ...campaign.quality.suspect import Kind
from ...campaign.record import Trace

DROPPED = "samples from some sample on"
OWN_CLOCK = "of the drive's clock"
_APART = 0.002  # of two clocks: one of a computer is a ten-thousandth wrong, a rate that was rounded ten times as much
_DIPS = 4  # of the mismatch over delays, the deepest
_SAME = 1.02  # of an error: within that two numbers of lost samples say the same
_TOLD_BY = 4000  # samples, by how many a clock has run away by the end; all then tell the rest
_OF_A_SAMPLE = 0.01  # to which it is told by how much a clock has run away by the end
_NEAR = 0.05  # of a time scale, around which a better one is looked for
_SHARP = 1e-6  # of a time scale: after a thousand periods the phase is then right to a hundredth of a radian


class Nuisance(NamedTuple):
    """An explanation: its kind, its number and unit, the rms of what it leaves, in noise floors, and the record read
    so (None if the record says nothing of this device)."""

    kind: Kind
    size: float
    unit: str
    error: float
    corrected: Trace | None = None


def rms(misfit: np.ndarray, sigma: float) -> float:
    """Root mean square of a misfit, in noise floors."""
    return float(np.sqrt(np.mean(misfit**2)) / sigma)


def nuisances(record: Trace, predicted: np.ndarray) -> list[Nuisance]:
    """Every explanation of a record by one number, best first."""
    found = [_gain(record, predicted), _drift(record, predicted)]
    found += [_delay(record, predicted), _own_clock(record, predicted)] if record.driven else []
    return sorted([*found, _dropped(record, predicted)], key=lambda one: one.error)


def _gain(record: Trace, predicted: np.ndarray) -> Nuisance:
    """The response is g times what it should be, beside a zero of its own if it has one; of a wrong sign g is near
    −1."""
    y, p, sigma = record.response[record.counted], predicted[record.counted], record.noise.sigma
    y, p = (y - np.mean(y), p - np.mean(p)) if record.floats else (y, p)
    gain = float(p @ y) / max(float(p @ p), 1e-300)
    if gain == 0:
        return Nuisance("gain", gain, "1", np.inf)
    noise = replace(record.noise, sigma=sigma / abs(gain))
    corrected = replace(record, response=record.response / gain, noise=noise)
    return Nuisance("sign" if gain < 0 else "gain", gain, "1", rms(y - gain * p, sigma), corrected)


def _delay(record: Trace, predicted: np.ndarray) -> Nuisance:
    """The response comes d samples late (negative: early)."""
    size, error = min(_shifts(record, predicted, 0, len(predicted)), key=lambda one: one[1])
    return Nuisance("delay", size, "samples", error, in_time(record, size))


def _shifts(record: Trace, predicted: np.ndarray, first: int, last: int) -> list[tuple[float, float]]:
    """By how many samples those from `first` to `last` may come late, up to a tenth of the record, and what that
    leaves: of a sine such delays lie a period apart, and only the rest differs."""
    measured, n = record.response, len(record.response)
    most = max(2, n // 10)
    index = np.arange(n, dtype=float)
    curve = CubicSpline(index, predicted, bc_type="natural")
    counted = record.counted & (index >= max(most, first)) & (index < min(n - most, last))

    def mismatch(delay: int) -> float:
        return float(np.sum((measured - np.roll(predicted, delay))[counted] ** 2))

    def error(delay: float) -> float:
        return rms(measured[counted] - curve(index[counted] - delay), record.noise.sigma)

    whole = np.array([mismatch(delay) for delay in range(-most, most + 1)])
    dips = [k for k in range(1, len(whole) - 1) if whole[k] <= min(whole[k - 1], whole[k + 1])] or [int(whole.argmin())]
    found = []
    for k in sorted(dips, key=lambda k: whole[k])[:_DIPS]:
        best: Any = minimize_scalar(error, bounds=(k - most - 1, k - most + 1), method="bounded")
        found.append((float(best.x), float(best.fun)))
    return found


def _dropped(record: Trace, predicted: np.ndarray) -> Nuisance:
    """Samples are missing on the way: up to some sample the response is in time, from there on it is early."""
    n = len(record.time)
    sizes = sorted({round(-size) for size, _ in _shifts(record, predicted, 2 * n // 3, n)})
    tried = [_lost(record, predicted, lost) for lost in sizes if 0 < lost < n // 3]
    best = min((one.error for one in tried), default=np.inf)
    # fewest first: whole periods of a steady sine are not missed
    return next((one for one in tried if one.error < _SAME * best), Nuisance("delay", 0.0, DROPPED, np.inf))


def _lost(record: Trace, predicted: np.ndarray, lost: int) -> Nuisance:
    """So many samples are missing, where that suits the record best."""
    kept = len(record.time) - lost
    until_then = (record.response - predicted) ** 2 * record.counted
    early = (record.response[:kept] - predicted[lost:]) ** 2 * record.counted[:kept]
    before = np.concatenate([[0.0], np.cumsum(until_then)])[: kept + 1]
    after = np.concatenate([np.cumsum(early[::-1])[::-1], [0.0]])
    begin = int(np.argmin(before + after))
    error = float(np.sqrt((before[begin] + after[begin]) / max(np.count_nonzero(record.counted[:kept]), 1)))
    if not 0 < begin < kept:
        return Nuisance("delay", -float(lost), DROPPED, np.inf)
    return Nuisance("delay", -float(lost), DROPPED, error / record.noise.sigma, in_time(record, -float(lost), begin))


def _own_clock(record: Trace, predicted: np.ndarray) -> Nuisance:
    """Response and drive were taken by two clocks: the response of time t is that of r t by the drive's."""
    index, n = np.arange(len(predicted), dtype=float), len(predicted)
    curve, measured, sigma = CubicSpline(index, predicted), record.response, record.noise.sigma

    def error(scale: float, every: int = 1) -> float:
        seen = np.flatnonzero(record.counted & (index * scale <= n - 1))[::every]
        return rms(measured[seen] - curve(index[seen] * scale), sigma)

    most, every = math.ceil(_APART * n), math.ceil(n / _TOLD_BY)
    begin = min((1 + samples / n for samples in range(-most, most + 1)), key=lambda scale: error(scale, every))
    best: Any = minimize_scalar(error, bounds=(begin - 1 / n, begin + 1 / n), method="bounded",
                                options={"xatol": _OF_A_SAMPLE / n})  # fmt: skip
    scale = float(best.x)
    return Nuisance("time-scale", scale, OWN_CLOCK, float(best.fun), _by_the_other_clock(record, scale))


def _by_the_other_clock(record: Trace, scale: float) -> Trace:
    """The record with the drive as it was when the response was taken; of one with edges, whose places no curve keeps,
    the response as it was at the times of the drive."""
    index, smooth = np.arange(len(record.time), dtype=float), record.edge is None
    at = index * scale if smooth else index / scale
    there, within = np.minimum(at, index[-1]), at <= index[-1]
    known = record.counted if smooth else record.counted[np.rint(there).astype(int)]
    resampled = drive_at(record.drive, there) if smooth else CubicSpline(index, record.across(record.response))(there)
    seen = replace(record, masked=None if np.all(known & within) else ~(known & within))
    if not smooth:
        return replace(seen, response=resampled)
    return replace(stretched(seen, scale), drive=resampled, period=record.period and record.period / scale)


def _drift(record: Trace, predicted: np.ndarray) -> Nuisance:
    """The response moves away along a parabola of time; its size is the change in noise floors.

    A parabola that is more of a level than of a change is no drift: an offset is something that a device may have.
    """
    t, sigma = np.linspace(-1.0, 1.0, len(record.time)), record.noise.sigma
    basis = np.column_stack([np.ones_like(t), t, t**2])
    misfit, counted = record.response - predicted, record.counted
    curve = basis @ np.linalg.lstsq(basis[counted], misfit[counted], rcond=None)[0]
    moves = np.ptp(curve) > abs(np.mean(curve))
    error = rms((misfit - curve)[counted], sigma) if moves else np.inf
    size = float(np.ptp(curve)) / sigma
    return Nuisance("drift", size, "noise floors", error, replace(record, response=record.response - curve))


def stretched(record: Trace, scale: float) -> Trace:
    """The record if its time runs `scale` times as fast as it says."""
    return replace(record, time=record.time * scale, into=record.into * scale)


def best_scale(error: Callable[[float], float], tried: Sequence[float]) -> tuple[float, float]:
    """The time scale with the least error, among those that slips make and then around it, and that error."""
    begin = min(tried, key=error)
    best: Any = minimize_scalar(error, bounds=(begin * (1 - _NEAR), begin * (1 + _NEAR)), method="bounded",
                                options={"xatol": _SHARP * begin})  # fmt: skip
    return float(best.x), float(best.fun)
