"""Mains hum: lines at known frequencies that no model explains, and that therefore are noise."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.polynomial.legendre import legvander

from ..record import NoiseFloor
from .autoregression import (
    MAX_ORDER,
    Autoregression,
    ar_spectrum,
    fit_autoregression,
    leverage_of,
    levinson,
    variance_of,
)
from .signal_basis import beside, dies

MAINS = (50.0, 60.0)
"""Hz; hum is a nuisance of the laboratory, never a property of the device."""

HUM = tuple(hz * order for hz in MAINS for order in (1, 2, 3))
"""Hz, with its overtones."""

_STANDS = 16.0  # times the noise beside it: a line of noise alone has as much power once in 3000 times
_SEEN = 0.3  # of a line, at least, beside all else: of less the record is too short to tell it from the rest
HUMS, SURROUNDINGS = "mains hum", "a line of the surroundings"  # the lines of a floor, in words
PERIODS = 2.5  # that a record holds of a line, at least: of fewer it is a level that bends
_ABOUT = 0.02 * np.pi  # rad per sample on either side of a line: so narrow is its peak in an autoregression
_FINE = 4096  # frequencies from which covariances are read


def told_apart(lines: Sequence[float], rate: float | None, n: int, periods: float = PERIODS) -> list[float]:
    """Those of some lines that n samples tell from a level and from the drive, whose harmonics lie `rate` apart (rad
    per sample, as the lines); of each there are more than so many `periods`."""
    width = 2 * np.pi / n
    near = [rate is not None and abs(line - round(line / rate) * rate) < 1.5 * width for line in lines]
    return [line for line, drive in zip(lines, near, strict=True) if periods * width < line < 3.0 and not drive]


def with_hum(
    residual: np.ndarray, basis: np.ndarray, lines: list[float], fit: Autoregression
) -> tuple[Autoregression, float]:
    """The noise with the mains lines that stand out of it, and the share of its power that is hum.

    **Arguments:** `residual` (n,) of a fit of the orthonormal `basis` (n, M), `lines` rates in rad per sample, `fit`:
    the noise without regard to hum.
    """
    n = len(residual)
    power, covariance = 0.0, np.zeros(MAX_ORDER + 1)
    rest, own, waves = residual, [], _waves(lines, n)
    alone = beside(basis, waves)
    for k, line in enumerate(lines):
        columns, inside = waves[:, 2 * k : 2 * k + 2], alone[:, 2 * k : 2 * k + 2]
        seen = np.sum(inside**2) / np.sum(columns**2)
        if seen < _SEEN:
            continue
        weights = np.linalg.lstsq(inside, rest, rcond=None)[0]
        level = float(np.interp(line, np.linspace(0, np.pi, len(fit.spectrum)), fit.spectrum))
        gain = float(np.sum((inside @ weights) ** 2)) / level
        amplitude = float(np.sum(weights**2)) / 2 - 2 * level / (n * seen)
        if gain > _STANDS and amplitude > 0:
            rest = rest - inside @ weights
            own.append(inside)
            power += amplitude
            covariance += _covariance(amplitude, line)
    if power == 0.0:
        return fit, 0.0
    leverage = leverage_of(basis) + leverage_of(np.linalg.qr(np.column_stack(own))[0])
    below = fit_autoregression(rest, leverage)
    share = power / (power + below.sigma**2)
    total = float(np.sqrt(power + below.sigma**2))
    below_covariance = np.fft.irfft(below.spectrum, n)[: MAX_ORDER + 1]
    ar, innovation = levinson(below_covariance + covariance, MAX_ORDER)
    error = float(np.hypot(below.relative_error * (1 - share), 0.3 * share / np.sqrt(len(own))))
    spectrum = ar_spectrum(ar, innovation, n)
    return replace(below, sigma=total, ar=tuple(float(a) for a in ar), relative_error=error, spectrum=spectrum), share


def _waves(lines: Sequence[float], n: int) -> np.ndarray:
    """Cosine and sine of each line, (n, 2 lines)."""
    turning = [np.exp(1j * line * np.arange(n)) for line in lines]
    return np.array([part for wave in turning for part in (np.real(wave), np.imag(wave))]).reshape(-1, n).T


def _covariance(power: float, line: float) -> np.ndarray:
    return power * np.cos(line * np.arange(MAX_ORDER + 1))


def standing(left: np.ndarray, lines: Sequence[float]) -> list[float]:
    """The mean square of each line (rad per sample) that stands out of what a model leaves, (n,), and does not die;
    zero of the others. It leaves a level too, that bends: a sensor that drifts does not hum. A line counts by what it
    alone says beside all the others: of two that differ by half a period in a record each seems to say what both do."""
    n, found = len(left), []
    waves, level = _waves(lines, n), legvander(np.linspace(-1, 1, n), round(2 * PERIODS))
    all_of_them = np.column_stack([waves, level])
    weights = np.linalg.lstsq(all_of_them, left, rcond=None)[0]
    spread = np.linalg.pinv(all_of_them.T @ all_of_them)
    rest = left - all_of_them @ weights
    spectrum = fit_autoregression(rest, np.full(n // 2 + 1, len(weights) / n)).spectrum
    for k, line in enumerate(lines):
        its = slice(2 * k, 2 * k + 2)
        own, alone = waves[:, its] @ weights[its], np.linalg.pinv(spread[its, its])
        seen = float(np.trace(alone)) / n  # of the power of its two waves
        beside_it = float(np.interp(line, np.linspace(0, np.pi, len(spectrum)), spectrum))
        gain = float(weights[its] @ alone @ weights[its])
        stands = seen >= _SEEN and gain > _STANDS * beside_it and not dies(rest + own, line)
        found.append(max(float(np.mean(own**2)) - 2 * beside_it / (n * seen), 0.0) if stands else 0.0)
    return found


def knows(noise: NoiseFloor, power: float, line: float) -> bool:
    """Whether a noise floor already has most of the mean square `power` of a line (rad per sample) about it."""
    ar = np.array(noise.ar, float)[:MAX_ORDER]
    spectrum = ar_spectrum(ar, noise.sigma**2 / variance_of(ar, 1.0), _FINE)
    rates = np.linspace(0, np.pi, len(spectrum))
    return float(np.mean(spectrum * (np.abs(rates - line) < _ABOUT))) > 0.5 * power


def with_lines(noise: NoiseFloor, powers: Sequence[float], lines: Sequence[float], what: str) -> NoiseFloor:
    """A noise floor with the mean squares `powers` of lines (rad per sample) as a part of it, and the word for `what`
    they are."""
    white = np.array(noise.ar, float)[:MAX_ORDER]
    below = ar_spectrum(white, noise.sigma**2 / variance_of(white, 1.0), _FINE)
    covariance = np.fft.irfft(below, _FINE)[: MAX_ORDER + 1]
    covariance = covariance + sum(_covariance(power, line) for power, line in zip(powers, lines, strict=True))
    total = float(noise.sigma**2 + sum(powers))
    share = sum(powers) / total
    method = f"{noise.method}; {what}, {share:.0%} of its power, is part of it".lstrip("; ")
    ar = tuple(float(a) for a in levinson(covariance, MAX_ORDER)[0])
    lines_in = tuple(dict.fromkeys([*noise.lines, what]))
    return NoiseFloor(float(np.sqrt(total)), ar, method, noise.relative_error * (1 - share), lines=lines_in)
