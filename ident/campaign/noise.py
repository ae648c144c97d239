"""The noise floor of a record, from the data alone: what neither repeats with the drive nor decays with the oscillator."""

from __future__ import annotations

import math

import numpy as np

from .autoregression import Autoregression, fit_autoregression
from .record import NoiseFloor
from .signal_basis import LEVELS, Pole, find_transient, harmonic_columns, orthonormal, transient_columns

HARMONICS = 12
LONGEST = 8192


def noise_floor(time: np.ndarray, drive: np.ndarray, response: np.ndarray, period: float | None = None) -> NoiseFloor:
    """Standard deviation and colour of the measurement noise of a record.

    A periodic drive: the noise is what is left of the response beside a Fourier series, a transient and their products.
    A long period: the differences between its repeats. Any other drive: the frequencies that the signal leaves free.

    **Arguments:** `time` (n,) s, `drive` (n,) V, `response` (n,) m, `period`: samples per period of the drive or None.
    """
    response = response - np.mean(response)
    size = float(np.sqrt(np.mean(response**2)))
    if size == 0.0:
        return NoiseFloor(1e-300, method="none: the response is constant", relative_error=1.0)
    response = response / size
    n = len(response)
    if np.ptp(drive) == 0:
        found = _short_period(response[:LONGEST], None)
    elif period is None:
        found = _free_frequencies(drive, response)
    elif period <= 8 * HARMONICS or n / period >= 8:
        found = _short_period(response[-LONGEST:], period)
    else:
        found = _repeats(response, period)
    fit, method = found
    quantum = _resolution(response)
    sigma = max(fit.sigma, quantum / math.sqrt(12.0), 1e-12)
    if sigma > fit.sigma:
        return NoiseFloor(sigma * size, method="the resolution of the response column", relative_error=0.5)
    return NoiseFloor(float(sigma * size), fit.ar, method, float(fit.relative_error))


def _resolution(response: np.ndarray) -> float:
    """Smallest difference between two values of the response."""
    levels = np.unique(response)
    return float(np.min(np.diff(levels))) if len(levels) > 1 else 0.0


def _leverage(basis: np.ndarray) -> np.ndarray:
    """(n//2 + 1,) share of the noise at each frequency that orthonormal columns take away."""
    spectrum = np.fft.rfft(basis, axis=0)
    return np.sum(np.real(spectrum) ** 2 + np.imag(spectrum) ** 2, axis=1) / len(basis)


def _short_period(response: np.ndarray, period: float | None) -> tuple[Autoregression, str]:
    """Fourier series, transient and products removed; as many products as the data ask for."""
    n = len(response)
    rate = None if period is None else 2 * np.pi / period
    harmonics = harmonic_columns(n, rate, HARMONICS)
    pole = find_transient(response, rate, HARMONICS)
    levels = range(LEVELS) if pole is not None else range(1)
    fits = [_removed(response, harmonics, rate, pole, level) for level in levels]
    residual, leverage, columns = fits[-1]
    fit = fit_autoregression(residual, leverage)
    chosen = len(fits) - 1
    whitened = _whitened_energy(residual, fit)
    for level in range(len(fits) - 1):
        gain = _whitened_energy(fits[level][0], fit) - whitened
        if gain < 1.5 * (columns - fits[level][2]) + 6.0:
            chosen = level
            break
    if chosen < len(fits) - 1:
        fit = fit_autoregression(fits[chosen][0], fits[chosen][1])
    words = "a decay" if period is None else f"{n / period:.0f} periods"
    parts = ["the Fourier series of the drive's period"] if period is not None else []
    parts += ["a transient"] if chosen else []
    return fit, f"what {words} leave beside {' and '.join(parts) or 'a constant'} ({fits[chosen][2]} numbers fitted)"


def _removed(
    response: np.ndarray, harmonics: np.ndarray, rate: float | None, pole: Pole | None, level: int
) -> tuple[np.ndarray, np.ndarray, int]:
    columns = harmonics
    if level > 0 and pole is not None:
        columns = np.column_stack([harmonics, transient_columns(len(response), rate, pole, level)])
    basis = orthonormal(columns)
    residual = response - basis @ (basis.T @ response)
    residual = residual - basis @ (basis.T @ residual)
    return residual, _leverage(basis), basis.shape[1]


def _whitened_energy(residual: np.ndarray, fit: Autoregression) -> float:
    """Energy in units of the noise; per real number 1 is expected."""
    power = np.abs(np.fft.rfft(residual)) ** 2 / len(residual)
    return 2.0 * float(np.sum(power / fit.spectrum))


def _repeats(response: np.ndarray, period: float) -> tuple[Autoregression, str]:
    """Few periods of a rich drive: noise is what differs between them. Periods in which a transient dies are dropped."""
    size = int(round(period))
    count = int(len(response) // period)
    starts = np.round((len(response) - period * np.arange(count, 0, -1))).astype(int)
    folded = np.array([response[start : start + size] for start in starts])
    while len(folded) > 2:
        rest = folded - folded[1:].mean(axis=0)
        energy = np.mean(rest**2, axis=1)
        later = float(np.mean(energy[1:])) * (len(folded) - 1) / max(len(folded) - 2, 1)
        if energy[0] < 1.4 * later * (1 + 1 / (len(folded) - 1)):
            break
        folded = folded[1:]
    repeats = len(folded)
    joined = (folded - folded.mean(axis=0)).ravel()
    leverage = np.zeros(len(joined) // 2 + 1)
    leverage[::repeats] = 1.0
    fit = fit_autoregression(joined, leverage)
    return fit, f"differences between {repeats} repeats of the drive's period"


def _free_frequencies(drive: np.ndarray, response: np.ndarray) -> tuple[Autoregression, str]:
    """Frequencies at which neither the drive nor its products leave a trace in the response."""
    n = len(response)
    window = np.hanning(n + 2)[1:-1]
    window = window / np.sqrt(np.mean(window**2))
    power = np.abs(np.fft.rfft((response - response.mean()) * window)) ** 2 / n
    exciting = np.abs(np.fft.rfft((drive - drive.mean()) * window)) ** 2 / n
    total = np.cumsum(exciting)
    top = int(np.searchsorted(total, 0.999 * total[-1]))
    free = np.arange(len(power)) > min(1.5 * top, 0.8 * len(power))
    fit = fit_autoregression(response * window, None, excluded=~free)
    return fit, "frequencies above the drive's"
