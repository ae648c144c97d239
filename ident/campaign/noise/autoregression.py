"""Colour of noise: an autoregressive spectrum fitted to a residual, part of which a signal fit has taken away.

A residual r = (1 − P) e, P projecting on M fitted columns, has at frequency k the expected power S_k (1 − h_k), h_k
being the leverage of the columns there. What is missing, h_k S_k, is filled in with the fit itself and the fit repeated
(expectation maximisation); frequencies that stick out, and those that the columns own, count as missing.

Source: P. Whittle, "Estimation and information in stationary time series", Ark. Mat. 2 (1953) 423; A. P. Dempster,
N. M. Laird, D. B. Rubin, J. R. Stat. Soc. B 39 (1977) 1; the order by G. Schwarz, Ann. Stat. 6 (1978) 461.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

MAX_ORDER = 6  # of an autoregression for the colour of noise
FLICKER_ORDER = 12  # of one in the place of flicker noise: of 4000 samples it costs 4 in −2 log likelihood, 6 cost 15
ROUNDS = 3  # of leaving out the frequencies that stick out
ORDER_PRICE = 1.3  # of a coefficient in −2 log likelihood, times the log of the numbers that are used


@dataclass(frozen=True)
class Autoregression:
    """e[k] = Σ_j ar[j] e[k−1−j] + innovation; `sigma` is the standard deviation of e, `relative_error` that of sigma.

    `spectrum` (n//2 + 1,) is its power at the frequencies of the periodogram; `used` (n//2 + 1,) the weight of each.
    """

    sigma: float
    ar: tuple[float, ...]
    relative_error: float
    spectrum: np.ndarray
    used: np.ndarray


def leverage_of(basis: np.ndarray) -> np.ndarray:
    """(n//2 + 1,) share of the noise at each frequency that orthonormal columns (n, M) take away."""
    spectrum = np.fft.rfft(basis, axis=0)
    return np.sum(np.real(spectrum) ** 2 + np.imag(spectrum) ** 2, axis=1) / len(basis)


def ar_spectrum(ar: np.ndarray, innovation: float, n: int) -> np.ndarray:
    """(n//2 + 1,) power spectrum σ²/|1 − Σ a_j e^{−iωj}|²; its mean over all frequencies is the variance."""
    polynomial = np.append(1.0, -np.asarray(ar))
    lags = np.correlate(polynomial, polynomial, "full")[len(ar) :]  # |…|² is a sum of as many cosines
    lags[1:] *= 2.0
    return innovation / np.maximum(_cosines(n)[: len(lags)].T @ lags, 1e-300)


@lru_cache(maxsize=8)  # records of a campaign are as long as one another
def _cosines(n: int) -> np.ndarray:
    """(FLICKER_ORDER + 1, n//2 + 1) cos ωk at the frequencies of a periodogram of n samples: few lags need no FFT."""
    return np.cos(2 * np.pi / n * np.outer(np.arange(FLICKER_ORDER + 1), np.arange(n // 2 + 1)))


def autocovariance(power: np.ndarray, order: int, n: int) -> np.ndarray:
    """(order + 1,) of a process with this power (n//2 + 1,): its inverse Fourier transform at the first lags."""
    both = 2.0 * power  # each frequency and its negative
    both[0] = power[0]
    if n % 2 == 0:
        both[-1] = power[-1]
    return _cosines(n)[: order + 1] @ both / n


def levinson(covariance: np.ndarray, order: int) -> tuple[np.ndarray, float]:
    """Autoregressive coefficients and innovation variance from autocovariances (order + 1,)."""
    ar, variance = np.zeros(0), float(covariance[0])
    for k in range(1, order + 1):
        reflection = (covariance[k] - np.dot(ar, covariance[k - 1 : 0 : -1])) / variance
        reflection = float(np.clip(reflection, -0.9995, 0.9995))
        ar = with_reflection(ar, reflection)
        variance *= 1.0 - reflection**2
    return ar, variance


def with_reflection(ar: np.ndarray, reflection: float) -> np.ndarray:
    """The coefficients of the next order, whose last is the reflection."""
    return np.append(ar - reflection * ar[::-1], reflection)


def predictors(ar: np.ndarray) -> list[tuple[np.ndarray, float]]:
    """The best predictors of an autoregressive process from its last 0, 1, …, p samples alone, and their error
    variances in units of the innovation: Levinson's recursion run backwards."""
    found = [(np.asarray(ar, float), 1.0)]
    while len(found[-1][0]):
        longer, variance = found[-1]
        reflection, rest = longer[-1], longer[:-1]
        lost = 1.0 - reflection**2
        found.append(((rest + reflection * rest[::-1]) / lost, variance / lost))
    return found[::-1]


def variance_of(ar: np.ndarray, innovation: float) -> float:
    """Variance of an autoregressive process: what is left to predict where nothing came before."""
    return innovation * predictors(ar)[0][1]


def _expectation(power: np.ndarray, missing: np.ndarray, spectrum: np.ndarray) -> np.ndarray:
    return np.where(missing >= 1.0, spectrum, power + missing * spectrum)


def _fit_order(
    power: np.ndarray, missing: np.ndarray, order: int, start: np.ndarray, n: int
) -> tuple[np.ndarray, float, np.ndarray, float]:
    """(ar, innovation, spectrum, −2 log likelihood) of one order."""
    spectrum = start
    ar, innovation, bound = np.zeros(order), 1.0, 1e6 * float(np.mean(start))
    for _ in range(60):
        covariance = autocovariance(_expectation(power, missing, spectrum), order, n)
        ar, innovation = levinson(covariance, order)
        if innovation > bound:  # a root at a frequency that nobody sees: the power there feeds itself
            return ar, bound, start, np.inf
        new = ar_spectrum(ar, innovation, n)
        change = float(np.max(np.abs(np.log(new / spectrum))))
        spectrum = new
        if change < 2e-3:
            break
    weight = np.clip(1.0 - missing, 0.0, 1.0)
    weight[[0, -1]] *= 0.5
    ratio = power / np.maximum(1.0 - missing, 1e-3) / spectrum
    return ar, innovation, spectrum, 2.0 * float(np.sum(weight * (np.log(spectrum) + ratio)))


def outliers(power: np.ndarray, missing: np.ndarray, spectrum: np.ndarray) -> np.ndarray:
    """Frequencies that stick out of the fitted spectrum, alone or as a group of five."""
    ratio = power / np.maximum(1.0 - missing, 1e-3) / spectrum
    ratio = np.where(missing >= 1.0, 1.0, ratio)
    group = np.convolve(ratio, np.full(5, 0.2), mode="same") > 3.3
    return (ratio > 11.0) | np.convolve(group & (ratio > 1.0), np.ones(5), mode="same").astype(bool) & (ratio > 2.0)


def fit_autoregression(
    residual: np.ndarray,
    leverage: np.ndarray | None = None,
    max_order: int = MAX_ORDER,
    excluded: np.ndarray | None = None,
) -> Autoregression:
    """The autoregressive noise behind a residual.

    **Arguments:** `residual` (n,), `leverage` (n//2 + 1,) of the fitted columns at the frequencies of the periodogram,
    `excluded` (n//2 + 1,) frequencies not to be used.
    """
    n = len(residual)
    power = np.abs(np.fft.rfft(residual)) ** 2 / n
    missing = np.zeros(len(power)) if leverage is None else np.clip(leverage, 0.0, 1.0)
    missing = np.where(missing > 0.6, 1.0, missing)
    if excluded is not None:
        missing = np.where(excluded, 1.0, missing)
    missing[0] = 1.0
    power = np.where(missing >= 1.0, 0.0, power)
    kept = missing < 1.0
    if kept.sum() < 4:
        missing, kept = np.zeros(len(power)), np.ones(len(power), dtype=bool)
        power = np.abs(np.fft.rfft(residual)) ** 2 / n
    for _ in range(ROUNDS):
        ar, innovation, spectrum = _best_order(power, missing, max_order, n)
        found = outliers(power, missing, spectrum) & kept
        if not found.any():
            break
        missing = np.where(found, 1.0, missing)
        power = np.where(found, 0.0, power)
        kept = missing < 1.0
    used = np.where(kept, 1.0 - missing, 0.0)
    sigma = float(np.sqrt(variance_of(ar, innovation)))
    return Autoregression(sigma, tuple(float(a) for a in ar), _relative_error(ar, innovation, used, n), spectrum, used)


def _best_order(power: np.ndarray, missing: np.ndarray, max_order: int, n: int) -> tuple[np.ndarray, float, np.ndarray]:
    """(ar, innovation, spectrum) of the order whose criterion is least; orders far beyond it are not tried."""
    kept = missing < 1.0
    level = float(np.mean(power[kept] / (1.0 - missing[kept]))) or 1e-300
    spectrum = np.full(len(power), level)
    count, least = max(2.0 * float(np.sum(1.0 - missing[kept])), 8.0), np.inf
    best: tuple[np.ndarray, float, np.ndarray] | None = None
    for order in range(min(max_order, kept.sum() // 4) + 1):
        ar, innovation, spectrum, deviance = _fit_order(power, missing, order, spectrum, n)
        criterion = deviance + ORDER_PRICE * order * np.log(count)
        if criterion < least:
            least, best = criterion, (ar, innovation, spectrum)
        elif best is not None and order >= len(best[0]) + 3:
            break
    assert best is not None
    return best


def _relative_error(ar: np.ndarray, innovation: float, used: np.ndarray, n: int) -> float:
    """Standard error of log σ from the information that the used frequencies carry."""
    base = np.log(ar_spectrum(ar, innovation, n))
    slopes, gradient = [np.ones(len(base))], [0.5]  # by log innovation
    reference = 0.5 * np.log(variance_of(ar, innovation))
    for j in range(len(ar)):
        step = np.zeros(len(ar))
        step[j] = 1e-5
        slopes.append((np.log(ar_spectrum(ar - step, innovation, n)) - base) / -1e-5)
        gradient.append((0.5 * np.log(abs(variance_of(ar - step, innovation))) - reference) / -1e-5)
    matrix = np.array(slopes)
    information = (matrix * used) @ matrix.T
    information[np.diag_indices_from(information)] *= 1.0 + 1e-9
    try:
        covariance = np.linalg.inv(information)
    except np.linalg.LinAlgError:
        return 1.0
    value = float(np.array(gradient) @ covariance @ np.array(gradient))
    return float(np.sqrt(value)) if 0.0 < value < 1.0 else 1.0
