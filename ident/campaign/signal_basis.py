"""The shape that a driven oscillator's response can have, whatever its physics, so that the rest is noise.

A response to a periodic drive is a Fourier series plus a transient. With the transient's own pole e^{(−α + iω)t} every
weak nonlinearity can only add products of the two: poles −jα + i(jω ± kω_drive), and slow changes of them.
No parameter of a model enters, so the noise floor does not depend on the model being right.

Source: A. H. Nayfeh, D. T. Mook, Nonlinear Oscillations, 1979, ch. 4 (combination tones of a weakly nonlinear oscillator).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.optimize import least_squares

LEVELS = 4
"""How many sets of poles there are: none, the transient itself, its products of second order, and of third order."""


@dataclass(frozen=True)
class Pole:
    """The transient: `rate` ω in rad per sample, `decay` α per sample."""

    rate: float
    decay: float


def harmonic_columns(n: int, drive_rate: float | None, count: int) -> np.ndarray:
    """(n, 1 + 2K) constant, cosines and sines of the drive's harmonics below the Nyquist frequency."""
    columns = [np.ones(n)]
    if drive_rate is not None:
        first = np.exp(1j * drive_rate * np.arange(n))
        power = np.ones(n, dtype=complex)
        for k in range(1, count + 1):
            if k * drive_rate >= np.pi * (1 - 1e-9):
                break
            power = power * first
            columns += [np.real(power), np.imag(power)]
    return np.column_stack(columns)


def transient_columns(n: int, drive_rate: float | None, pole: Pole, level: int) -> np.ndarray:
    """(n, M) decaying columns of a transient and its products with the drive's response."""
    time = np.arange(n)
    position = 2.0 * time / n - 1.0
    columns: list[np.ndarray] = []

    def add(rate: float, orders: int, degree: int = 0) -> None:
        envelope = np.exp(-orders * pole.decay * time)
        wave = envelope * np.exp(1j * abs(rate) * time)
        for power in range(degree + 1):
            shape = position**power
            columns.append(np.real(wave) * shape)
            if abs(rate) > 1e-4:
                columns.append(np.imag(wave) * shape)

    own, drive = pole.rate, drive_rate
    add(own, 1, (0, 0, 2, 3)[level])
    if level >= 2:
        add(0.0, 2, 1)
        add(2 * own, 2, 1)
        add(3 * own, 3)
        add(own, 3)
    if level >= 2 and drive is not None:
        add(drive, 2, 1)
        for order in (1, -1):
            add(own + order * drive, 1, 1)
            add(2 * own + order * drive, 2)
            add(own + 2 * order * drive, 1)
    if level >= 3:
        add(0.0, 1)
    if level >= 3 and drive is not None:
        add(2 * drive, 2)
        for order in (1, -1):
            add(own + 3 * order * drive, 1)
            add(2 * own + 2 * order * drive, 2)
            add(3 * own + order * drive, 3)
    return np.column_stack(columns)


def orthonormal(columns: np.ndarray) -> np.ndarray:
    """(n, M) an orthonormal basis of the columns' span; columns that add nothing are dropped."""
    norms = np.sqrt(np.einsum("ij,ij->j", columns, columns))
    basis, triangle = np.linalg.qr(columns / np.where(norms > 0, norms, 1.0))
    return basis[:, np.abs(np.diag(triangle)) > 1e-9]


def _thinned(values: np.ndarray, block: int) -> np.ndarray:
    """Means over blocks of samples: an exponential stays an exponential."""
    whole = len(values) // block * block
    return values[:whole].reshape(-1, block).mean(axis=1)


def find_transient(response: np.ndarray, drive_rate: float | None, count: int) -> Pole | None:
    """The pole of the transient by separable least squares; None if there is no transient to be seen.

    **Arguments:** `response` (n,), `drive_rate`: rad per sample or None, `count`: harmonics of the drive.
    """
    n = len(response)
    steady = orthonormal(harmonic_columns(n, drive_rate, count))
    rest = response - steady @ (steady.T @ response)
    size = 4 * n
    spectrum = np.abs(np.fft.rfft(rest * np.hanning(n), size))[: int(0.45 * size)]
    floor = float(np.median(spectrum))
    peaks = np.flatnonzero((spectrum[1:-1] > spectrum[:-2]) & (spectrum[1:-1] >= spectrum[2:])) + 1
    peaks = peaks[(spectrum[peaks] > 4.0 * floor) & (peaks > 6)]
    if len(peaks) == 0:
        return None
    rates = 2 * np.pi * peaks[np.argsort(spectrum[peaks])[::-1][:4]] / size
    fastest = max(float(np.max(rates)), drive_rate or 0.0)
    block = max(1, int(2 * np.pi / fastest / 8))
    thin = _thinned(response, block)
    thin_rate = None if drive_rate is None else drive_rate * block
    length = len(thin)
    count = min(count, 6)
    harmonics = orthonormal(harmonic_columns(length, thin_rate, count))
    thin = thin - harmonics @ (harmonics.T @ thin)

    def misfit(parameters: np.ndarray, level: int) -> np.ndarray:
        pole = Pole(float(parameters[0]), float(np.exp(parameters[1])))
        columns = transient_columns(length, thin_rate, pole, level)
        columns = columns - harmonics @ (harmonics.T @ columns)
        basis = np.linalg.qr(columns / np.linalg.norm(columns, axis=0).clip(1e-300))[0]
        return thin - basis @ (basis.T @ thin)

    starts = [np.array([rate * block, np.log(decay / length)]) for rate in rates for decay in (2.0, 8.0)]
    costs = [float(np.sum(misfit(start, 1) ** 2)) for start in starts]
    start = starts[int(np.argmin(costs))]
    scale = np.array([1.0 / length, 0.3])
    bounds = ([1e-3, np.log(0.1 / length)], [np.inf, np.log(100.0 / length)])
    for level, evaluations in ((1, 12), (2, 12)):
        start = np.clip(start, *bounds)
        fit = least_squares(
            misfit, start, x_scale=scale, bounds=bounds, args=(level,), max_nfev=evaluations, xtol=1e-4, ftol=1e-3
        )
        start = fit.x
    return Pole(float(start[0]) / block, float(np.exp(start[1])) / block)
