"""The measured drive between its samples, and its rate of change.

Effects that act on the drive need V and dV/dt at the inner points of the integrator's steps. A smooth V goes exactly
through its samples; dV/dt must not amplify the noise of the drive column. Through a drive with corners (`corners`), or
one that is held by a converter or a switch (`held_drive`), no smooth curve goes.
"""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from .corners import Corners, broken_spline, corners, drive_at, rates
from .held_drive import held_drive
from .period import fourier_basis, least_squares
from .record import Same, Trace
from .smooth_drive import smooth_drive


def drive_frequency(record: Trace) -> float:
    """Drive frequency of a record for any waveform, ω = rms(V̇)/rms(V − mean V), rad/s; 0 for a constant drive.

    Source: docs/physics.md §5; exact for a sine over whole periods.
    """
    return _known_rate(Same(record.drive), record.period) / record.step


@lru_cache(maxsize=1024)  # asked for by every fit
def _known_rate(drive: Same, period: float | None) -> float:
    return drive_rate(drive.array, period)


def drive_rate(drive: np.ndarray, period: float | None = None) -> float:
    """rms(dV/dk)/rms(V − mean V) per sample; over whole periods if the drive is periodic."""
    if np.ptp(drive) == 0:
        return 0.0
    if period is not None and _has_series(period):
        weights, order = _fourier_series(drive, period)
        power = np.abs(weights) ** 2
        return float(2 * np.pi / period * np.sqrt(np.sum(order**2 * power) / np.sum(power)))
    slope = _slope(drive, 1, None)[::2]
    return float(np.sqrt(np.mean(slope**2) / np.var(drive)))


def _has_series(period: float) -> bool:
    """Whether the Fourier series is cheap: by FFT for whole samples, by least squares for a short period."""
    return period == round(period) or period <= 200


def half_step_drive(record: Trace, substeps: int = 1) -> tuple[np.ndarray, np.ndarray]:
    """The drive and its derivative on the half-step grid of a Runge-Kutta solver with `substeps` steps per sample.

    A smooth V is `smooth_drive`; V̇ the derivative of the drive's Fourier series if it is periodic, otherwise of such a
    curve without what the noise of the drive column hides. One with corners is `corners.broken_spline`, one that is
    held `held_drive`.

    **Returns:** V (2 (n−1) `substeps` + 1,) in V, V̇ of the same shape in V/s.

    Source: P. H. C. Eilers, "A perfect smoother", Anal. Chem. 75 (2003) 3631, doi:10.1021/ac034173t.
    """
    voltage, slope = _half_steps(Same(record.drive), substeps, record.period, record.edge)
    return voltage, slope / record.step


@lru_cache(maxsize=64)  # as many as `response.lane` keeps
def _half_steps(drive: Same, substeps: int, period: float | None, edge: float | None) -> tuple[np.ndarray, np.ndarray]:
    """The drive and its derivative per sample interval on the half-step grid."""
    if edge is not None:
        return held_drive(drive.array, substeps, edge)
    samples, n = drive.array, len(drive.array)
    grid = np.arange(2 * (n - 1) * substeps + 1) / (2 * substeps)
    found = corners(samples)
    voltage = drive_at(samples, grid)
    if found:
        slope = rates(broken_spline(_quiet(samples, found), found), grid)
    else:
        voltage[:: 2 * substeps] = samples
        slope = _slope(samples, substeps, period)
    voltage.flags.writeable = False  # it is handed to whoever asks
    return voltage, slope


def _slope(drive: np.ndarray, substeps: int, period: float | None) -> np.ndarray:
    """(2 (n−1) substeps + 1,) derivative of the drive per sample interval."""
    n = len(drive)
    grid = np.arange(2 * (n - 1) * substeps + 1) / (2 * substeps)
    if np.ptp(drive) == 0:
        return np.zeros(len(grid))
    if period is not None and _has_series(period):
        return _fourier_slope(drive, period, grid)
    return smooth_drive(_smoothed(drive)).derivative()(grid)


def _fourier_series(drive: np.ndarray, period: float) -> tuple[np.ndarray, np.ndarray]:
    """(weights, orders) of the series Σ Re(w exp(2πi k x/P)), k ≥ 1, without harmonics that are within the noise."""
    n = len(drive)
    if period == round(period):
        size = int(period)
        whole = n // size
        folded = drive[: whole * size].reshape(whole, size)
        mean = folded.mean(axis=0)
        noise = float(np.sum((folded - mean) ** 2) / (max(whole - 1, 1) * size)) / whole
        weights = 2.0 * np.fft.rfft(mean)[1 : (size + 1) // 2] / size  # the highest of an even number has no phase
        variance = 4.0 * noise / size
    else:
        count = max(1, int(period / 2 - 0.5))
        basis = fourier_basis(n, period, count)
        fitted = least_squares(basis, drive)
        residual = float(np.sum((drive - basis @ fitted) ** 2)) / max(n - basis.shape[1], 1)
        weights = fitted[1::2] - 1j * fitted[2::2]
        variance = 4.0 * residual / n
    size2 = np.abs(weights) ** 2
    keep = (size2 > 8.0 * variance) & (size2 > 1e-26 * np.max(size2))
    keep[np.argmax(size2)] = True
    return weights[keep], (np.arange(len(weights)) + 1)[keep]


def _fourier_slope(drive: np.ndarray, period: float, grid: np.ndarray) -> np.ndarray:
    """Derivative of the Fourier series of a periodic drive."""
    weights, order = _fourier_series(drive, period)
    rate = 2 * np.pi / period
    weights = weights * 1j * rate * order
    if period == round(period):  # the grid meets the same phases in every period
        per_sample = round(1.0 / (grid[1] - grid[0]))
        one = _series(weights, order, rate, np.arange(int(period) * per_sample) / per_sample)
        return np.resize(one, len(grid))
    return _series(weights, order, rate, grid)


def _series(weights: np.ndarray, order: np.ndarray, rate: float, points: np.ndarray) -> np.ndarray:
    """Σ Re(w exp(i k r x)) of the orders k; by FFT where the points are one period, evenly spaced."""
    base = 2 * np.pi / (len(points) * (points[1] - points[0]))
    if np.isclose(base, rate, rtol=1e-9, atol=0.0) and np.max(order) < len(points) // 2:
        spectrum = np.zeros(len(points) // 2 + 1, dtype=complex)
        spectrum[order] = 0.5 * weights * len(points)
        return np.fft.irfft(spectrum, len(points))
    first, total = np.exp(1j * rate * points), np.zeros(len(points))
    power = np.ones(len(points), dtype=complex)
    by_order = dict(zip(order.tolist(), weights.tolist(), strict=True))
    for k in range(1, int(np.max(order)) + 1):
        power *= first  # a product costs a tenth of an exponential
        if k in by_order:
            total += (by_order[k] * power).real
    return total


def _smoothed(drive: np.ndarray) -> np.ndarray:
    """The drive smoothed by a third-order difference penalty whose weight minimises the expected error of the slope."""
    weight = _weight(drive)
    return drive if weight == 0.0 else _penalised(drive, weight, np.ones(len(drive) - 3))


def _quiet(drive: np.ndarray, found: Corners) -> np.ndarray:
    """The drive smoothed between its corners, as its longest piece tells."""
    ends = np.concatenate([[0], np.ceil(found.places).astype(int), [len(drive)]])
    longest = int(np.argmax(np.diff(ends)))
    weight = _weight(drive[ends[longest] : ends[longest + 1]])
    if weight == 0.0:
        return drive
    counted = np.ones(len(drive) - 3)  # differences of four samples, where these are of one piece
    counted[np.concatenate([found.at - 2, found.at - 1, found.at[found.part > 0]])] = 0.0
    return _penalised(drive, weight, counted)


def _weight(drive: np.ndarray) -> float:
    """The weight λ of the penalty that minimises the expected error of the slope; 0 where no noise is to be seen.

    A penalty λ passes the frequency θ (rad per sample) with H = 1/(1 + λ (2 sin θ/2)⁶). With the spectrum S of the
    drive above its noise floor N the error of the slope is Σ θ² ((1 − H)² S + H² N).
    """
    n = len(drive)
    if n < 32:
        return 0.0
    window = np.hanning(n + 2)[1:-1]
    trend = np.polyval(np.polyfit(np.arange(n), drive, 1), np.arange(n))
    power = np.abs(np.fft.rfft((drive - trend) * window)) ** 2 / np.sum(window**2)
    theta = np.linspace(0.0, np.pi, len(power))
    floor = float(np.median(power[int(0.75 * len(power)) :])) / np.log(2.0)
    signal = np.where(power > 4.0 * floor, power - floor, 0.0)
    stiffness = (2 * np.sin(theta / 2)) ** 6
    best, best_error = 0.0, float(np.sum(theta**2 * floor))
    for weight in np.logspace(-8, 12, 81):
        passed = 1.0 / (1.0 + weight * stiffness)
        error = float(np.sum(theta**2 * ((1 - passed) ** 2 * signal + passed**2 * floor)))
        if error < best_error:
            best, best_error = float(weight), error
    return 0.0 if floor < 1e-20 * float(np.max(power)) else best


def _penalised(values: np.ndarray, weight: float, counted: np.ndarray) -> np.ndarray:
    """Solution of (1 + λ Dᵀ diag(c) D) s = v with third differences D, `counted` (n − 3,), in O(n)."""
    from scipy.linalg import solveh_banded

    n = len(values)
    stencil = np.array([-1.0, 3.0, -3.0, 1.0])
    bands = np.zeros((4, n))  # upper form: bands[3 − k, j] is the k-th off-diagonal of column j
    for shift in range(4):
        for first in range(4 - shift):
            second = first + shift
            columns = np.arange(n - 3) + second
            np.add.at(bands[3 - shift], columns, weight * stencil[first] * stencil[second] * counted)
    bands[3] += 1.0
    return solveh_banded(bands, values)
