"""Whether a drive repeats itself, and after how many samples."""

from __future__ import annotations

import numpy as np


def find_period(drive: np.ndarray) -> float | None:
    """Samples per period if the drive is periodic over the whole record (at least two periods), else None.

    Candidates are the dips of the mean squared difference between the record and itself shifted by P samples; each is
    refined by least squares on the Fourier series of that period, and kept if the series explains the drive.

    **Arguments:** `drive` (n,) V.
    """
    n = len(drive)
    signal = drive - np.mean(drive)
    size = float(np.sqrt(np.mean(signal**2)))
    if n < 20 or size <= 1e-12 * float(np.max(np.abs(drive)) or 1.0):
        return None
    sine = _sine_period(signal)
    if sine is not None:
        return sine if n >= 1.98 * sine else None
    mismatch = _mismatch(signal)
    low = np.flatnonzero((mismatch[1:-1] <= mismatch[:-2]) & (mismatch[1:-1] <= mismatch[2:])) + 1
    # one sample off the best shift costs a fast signal much; half a sample is what rounding to a sample can cost
    curvature = mismatch[1]
    allowed = 0.5 * curvature + 0.02
    candidates = [int(p) for p in low if p >= 2 and mismatch[p] < allowed]
    for candidate in candidates[:6]:
        refined = _refine(signal, candidate, mismatch)
        if refined is not None and n >= 1.98 * refined:
            return refined
    return None


def _sine_period(signal: np.ndarray) -> float | None:
    """Samples per period of a signal (n,) that is a sine and noise, however many they are; None if it is not.

    The frequency of the highest line of the spectrum, refined by Gauss-Newton steps on level, amplitude, phase and
    frequency together: it ends at the least-squares frequency if it starts within half a line of it.

    Source: IEEE Std 1057-2017, Digitizing Waveform Recorders, §5.4.3.3 (four-parameter sine fit).
    """
    n = len(signal)
    power = np.abs(np.fft.rfft(signal * np.hanning(n), 4 * n)) ** 2  # four times finer than the lines
    omega = 2 * np.pi * max(int(np.argmax(power)), 2) / (4 * n)
    index, residual, size = np.arange(n), np.inf, float(np.mean(signal**2))
    for _ in range(8):
        basis = fourier_basis(n, 2 * np.pi / omega, 1)
        level = least_squares(basis, signal)
        slope = index * (level[2] * basis[:, 1] - level[1] * basis[:, 2])
        misfit = signal - basis @ level
        residual = float(np.mean(misfit**2))
        step = float(least_squares(np.column_stack([basis, slope]), misfit)[-1])
        if not np.isfinite(step) or not 0.0 < omega + step < np.pi:
            return None
        omega += step
        if abs(step) * n < 1e-7 or residual > 0.5 * size:  # it stands, or never will
            break
    if residual > _tolerance(signal, size):
        return None
    return _rounded(2 * np.pi / omega, n)


def _rounded(period: float, n: int) -> float:
    """The whole number of samples that a period is, as far as a record of n samples can tell."""
    nearest = round(period)
    near = abs(period - nearest) * n / period < 0.02 * max(1.0, period / 20)
    return float(nearest) if near and nearest >= 2 else float(period)


def _mismatch(signal: np.ndarray) -> np.ndarray:
    """(n//2 + 2,) mean squared difference after a shift of 0, 1, … samples over twice the mean square, by FFT."""
    n = len(signal)
    last = n // 2 + 2
    size = 1 << (2 * n - 1).bit_length()
    spectrum = np.fft.rfft(signal, size)
    product = np.fft.irfft(spectrum * np.conj(spectrum), size)[:last]
    squares = np.concatenate(([0.0], np.cumsum(signal**2)))
    shift = np.arange(last)
    head, tail = squares[n - shift], squares[n] - squares[shift]
    energy = head + tail
    return np.maximum(energy - 2 * product, 0.0) / np.maximum(energy, 1e-300)


def fourier_basis(n: int, period: float, harmonics: int) -> np.ndarray:
    """(n, 1 + 2K) columns 1, cos, sin of the harmonics 1..K of a period in samples."""
    first = np.exp(2j * np.pi / period * np.arange(n))
    rows = np.ones((1 + 2 * harmonics, n))
    power = np.ones(n, dtype=complex)
    for k in range(harmonics):
        power *= first
        rows[2 * k + 1], rows[2 * k + 2] = np.real(power), np.imag(power)
    return rows.T


def least_squares(basis: np.ndarray, values: np.ndarray) -> np.ndarray:
    """Coefficients by the normal equations: harmonics are nearly orthogonal, and a QR would cost ten times more."""
    scale = np.sqrt(np.einsum("ij,ij->j", basis, basis))
    scale[scale == 0] = 1.0
    normal = (basis.T @ basis) / np.outer(scale, scale)
    normal[np.diag_indices_from(normal)] += 1e-14
    return np.linalg.solve(normal, basis.T @ values / scale) / scale


def _refine(signal: np.ndarray, candidate: int, mismatch: np.ndarray) -> float | None:
    """The period near a candidate for which a Fourier series fits best; None if no series fits."""
    n = len(signal)
    size = float(np.mean(signal**2))
    if candidate > 200 or n > 20 * candidate * candidate:  # an integer period is as good as any here, or cannot be told
        whole = _folded_residual(signal, candidate)
        if whole < 1e-3 * size or candidate > 400:
            return float(candidate) if whole < _tolerance(signal, size) else None
    a, b, c = mismatch[candidate - 1 : candidate + 2]
    curve = a - 2 * b + c
    period = candidate + (0.5 * (a - c) / curve if curve > 0 else 0.0)
    harmonics = max(1, min(int(period / 2 - 0.5), 10))
    index = np.arange(n)
    residual = np.inf
    for count in (1, min(2, harmonics), harmonics, harmonics, harmonics):
        basis = fourier_basis(n, period, count)
        weights = least_squares(basis, signal)
        misfit = signal - basis @ weights
        cosine, sine = weights[1::2], weights[2::2]
        order = np.arange(1, count + 1)
        slope = (basis[:, 2::2] @ (-order * cosine) + basis[:, 1::2] @ (order * sine)) * index  # d/dω
        design = np.column_stack([basis, slope])
        step = float(least_squares(design, misfit)[-1])
        omega = 2 * np.pi / period + step
        if omega <= 0 or abs(2 * np.pi / omega - candidate) > 1.0:
            return None
        residual = float(np.mean(misfit**2))
        period = 2 * np.pi / omega
    if residual > _tolerance(signal, size):
        return None
    return _rounded(period, n)


def _folded_residual(signal: np.ndarray, period: int) -> float:
    whole = len(signal) // period * period
    folded = signal[:whole].reshape(-1, period)
    repeats = max(len(folded) - 1, 1)
    return float(np.mean((folded - folded.mean(axis=0)) ** 2) * len(folded) / repeats)


def noise_between(signal: np.ndarray) -> float:
    """Mean square of the noise of a signal (n,), from sixth differences, which a vibration hardly has (924: their gain
    of noise)."""
    return float(np.mean(np.diff(signal, 6) ** 2)) / 924.0


def _tolerance(signal: np.ndarray, size: float) -> float:
    """Mean square that a periodic drive may leave: its own noise, seen in sixth differences, or 1.5 % of its size."""
    return max(2.0 * min(noise_between(signal), 0.01 * size), (0.015**2) * size)
