"""Zero-point offset of a periodic record: how a response fails to be symmetric, for data and model.

Over the second half of the record's whole periods the response is a Fourier series in the drive's own phase φ
(V = A sin φ + mean):

    z = c0 + Σ_k a_k sin kφ + b_k cos kφ = c0 + Σ_k A_k sin(kφ + θ_k)

and every measure is read off that series. Symmetric physics (odd under a half-period shift) makes c0, A_2, the dwell
asymmetry and the mean at the crossings zero; the difference at the crossings is the opening of the loop.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..campaign.drive_sine import DriveSine, drive_sine
from ..campaign.record import NoiseFloor, Trace

_HARMONICS = 10  # of the drive, in the mean period of a record
_DRAWS = 200  # of noise, which tell the error of a measure
_POINTS = 512  # of a period, between which it is drawn straight
_PHASE = 2  # position of the second harmonic's phase among the measures


class Measure(NamedTuple):
    """What a measure is called, and its unit ("m" or "rad" or "1")."""

    name: str
    unit: str


MEASURES = (
    Measure("mean over periods", "m"),
    Measure("2nd harmonic", "m"),
    Measure("2nd harmonic, phase", "rad"),
    Measure("dwell asymmetry", "1"),
    Measure("at drive zeros, mean", "m"),
    Measure("at drive zeros, gap", "m"),
)
EVEN = (0, 1, 3, 4)
"""Positions of the measures that are zero for symmetric physics; they decide what makes an offset."""


class Measured(NamedTuple):
    """A value and its standard error, SI."""

    value: float
    error: float


class Offset(NamedTuple):
    """One measure of the data, of the model, and their difference."""

    measure: Measure
    data: Measured
    model: Measured
    difference: Measured


def offsets(record: Trace, reading: np.ndarray) -> tuple[Offset, ...] | None:
    """The six measures of a record and of a model's reading of it; None if the drive has no period to fold on.

    A value is that of the mean period. Its error is the larger of what the noise floor explains (zero for the model)
    and of the scatter from period to period (jackknife), which holds what is left of the start transient. Data and
    model share the transient, so their difference is known better than either.

    **Arguments:** `reading` (n,) m.

    Source: B. Efron, R. J. Tibshirani, An Introduction to the Bootstrap, 1993, ch. 11 (jackknife).
    """
    folds = _folds(record)
    if folds is None:
        return None
    sine, blocks, count = folds
    samples = sum(stop - start for start, stop in blocks)
    deviation = _coefficient_noise(record.noise, sine.period, count, samples)
    data, model = (_coefficients(z, blocks, sine, count) for z in (record.response, reading))
    of_data, of_model = _measures(data.mean(axis=0), sine), _measures(model.mean(axis=0), sine)
    noise = _noise_error(data.mean(axis=0), deviation, sine)
    left_data, left_model = _left_out(data, sine), _left_out(model, sine)
    data_error = np.maximum(noise, _jackknife(left_data))
    model_error = _jackknife(left_model)
    difference = _wrapped(of_data - of_model)
    difference_error = np.maximum(noise, _jackknife(_wrapped(left_data - left_model)))
    return tuple(
        Offset(
            measure,
            Measured(float(of_data[i]), float(data_error[i])),
            Measured(float(of_model[i]), float(model_error[i])),
            Measured(float(difference[i]), float(difference_error[i])),
        )
        for i, measure in enumerate(MEASURES)
    )


class Folded(NamedTuple):
    """Readings folded on a record's drive: `measures` (k, 6) of the mean period, in the order of `MEASURES`, and
    `second` (k, 2), sine and cosine of the second harmonic, m."""

    measures: np.ndarray
    second: np.ndarray


def fold(record: Trace, readings: np.ndarray) -> Folded | None:
    """The measures of many readings (k, n) of one record at once; None if the drive has no period to fold on."""
    folds = _folds(record)
    if folds is None:
        return None
    sine, blocks, count = folds
    inverses = []
    for start, stop in blocks:
        basis = _basis(sine.angle(np.arange(start, stop)), count)
        inverses.append((start, stop, np.linalg.solve(basis.T @ basis, basis.T)))
    series = np.mean([readings[:, start:stop] @ inverse.T for start, stop, inverse in inverses], axis=0)
    return Folded(_measures(series, sine), series[:, 3:5])


def _folds(record: Trace) -> tuple[DriveSine, list[tuple[int, int]], int] | None:
    """The drive's sine, the periods over which a record is folded on it, and how many harmonics they tell; None if
    there are too few."""
    sine = drive_sine(record)
    if sine is None:
        return None
    blocks, count = _blocks(record, sine), min(_HARMONICS, int(sine.period) // 4)
    return None if len(blocks) < 2 or count < 2 else (sine, blocks, count)


def _blocks(record: Trace, sine: DriveSine) -> list[tuple[int, int]]:
    """First and last+1 sample of each whole period in the second half of the counted samples."""
    whole = int((len(record.response) - record.skip) / sine.period + 1e-6)
    used = max(whole // 2, min(whole, 2))
    edges = len(record.response) - sine.period * np.arange(used, -1, -1)
    starts = np.ceil(edges - 1e-6).astype(int)
    return [(int(a), int(b)) for a, b in zip(starts[:-1], starts[1:], strict=True)]


def _basis(angle: np.ndarray, count: int) -> np.ndarray:
    """(..., 1 + 2K): 1, sin φ, cos φ, sin 2φ, …"""
    order = np.arange(1, count + 1)
    waves = np.stack([np.sin(angle[..., None] * order), np.cos(angle[..., None] * order)], axis=-1)
    return np.concatenate([np.ones((*angle.shape, 1)), waves.reshape(*angle.shape, 2 * count)], axis=-1)


def _coefficients(response: np.ndarray, blocks: list[tuple[int, int]], sine: DriveSine, count: int) -> np.ndarray:
    """(P, 1 + 2K) Fourier coefficients of each period."""
    found = []
    for start, stop in blocks:
        basis = _basis(sine.angle(np.arange(start, stop)), count)
        found.append(np.linalg.solve(basis.T @ basis, basis.T @ response[start:stop]))
    return np.array(found)


def _measures(series: np.ndarray, sine: DriveSine) -> np.ndarray:
    """(..., 6) measures of Fourier coefficients (..., 1 + 2K)."""
    count = (series.shape[-1] - 1) // 2
    a, b = series[..., 3], series[..., 4]
    curve = series[..., 1:] @ _basis(np.linspace(0, 2 * np.pi, _POINTS + 1), count)[:, 1:].T
    above, size = np.maximum(curve, 0.0), np.abs(curve)
    # Share of each interval above the mean, the curve taken straight between its points.
    share = (above[..., 1:] + above[..., :-1]) / np.maximum(size[..., 1:] + size[..., :-1], 1e-300)
    shift = np.arcsin(np.clip(sine.mean / sine.amplitude, -1.0, 1.0))
    crossing = _basis(np.array([-shift, np.pi + shift]), count)
    rising, falling = series @ crossing[0], series @ crossing[1]
    return np.stack(
        [
            series[..., 0],
            np.hypot(a, b),
            np.arctan2(b, a),
            share.mean(axis=-1) - 0.5,
            (rising + falling) / 2,
            rising - falling,
        ],
        axis=-1,
    )


def _coefficient_noise(noise: NoiseFloor, period: float, count: int, samples: int) -> np.ndarray:
    """(1 + 2K,) standard deviations that the noise causes, after its own spectrum."""

    def power(rate: np.ndarray) -> np.ndarray:
        lags = np.arange(1, len(noise.ar) + 1)
        return 1.0 / np.abs(1.0 - np.exp(-1j * rate[:, None] * lags) @ np.asarray(noise.ar, float)) ** 2

    total = float(np.mean(power((np.arange(8192) + 0.5) * np.pi / 8192)))
    order = np.concatenate([[0], np.repeat(np.arange(1, count + 1), 2)])
    shape = power(2 * np.pi / period * order) / total
    return noise.sigma * np.sqrt(np.where(order == 0, 1.0, 2.0) * shape / samples)


def _noise_error(series: np.ndarray, deviation: np.ndarray, sine: DriveSine) -> np.ndarray:
    draws = series + deviation * np.random.default_rng(0).standard_normal((_DRAWS, len(series)))
    apart = _wrapped(_measures(draws, sine) - _measures(series, sine))
    return np.sqrt(np.mean(apart**2, axis=0))


def _left_out(series: np.ndarray, sine: DriveSine) -> np.ndarray:
    """(P, 6) measures with one period left out in turn."""
    return _measures((series.sum(axis=0) - series) / (len(series) - 1), sine)


def _jackknife(left_out: np.ndarray) -> np.ndarray:
    n = len(left_out)
    apart = _wrapped(left_out - left_out[0])
    return np.sqrt((n - 1) * np.var(apart, axis=0))


def _wrapped(measures: np.ndarray) -> np.ndarray:
    """The same with the phase brought to (−π, π]."""
    measures = np.array(measures)
    measures[..., _PHASE] = (measures[..., _PHASE] + np.pi) % (2 * np.pi) - np.pi
    return measures
