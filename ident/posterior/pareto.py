"""Importance weights and whether they can be trusted: the Pareto shape of their tail.

Sources: A. Vehtari, D. Simpson, A. Gelman, Y. Yao, J. Gabry, Pareto smoothed importance sampling, JMLR 25 (2024) 72;
J. Zhang, M. A. Stephens, Technometrics 51 (2009) 316 (the fit of the tail).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from .log_sum import log_sum

TRUSTED = 0.7
"""Pareto shape above which the mean of the weights converges too slowly to be used (Vehtari et al. 2024, §3)."""
_PRIOR = (10.0, 0.5)  # ten observations at shape ½ steady the fit of a short tail (Vehtari et al. 2024, appendix G)


class Smoothed(NamedTuple):
    """`log_weights` (k,), normalised, their tail smoothed; `shape` k̂; `efficiency`, effective over actual number."""

    log_weights: np.ndarray
    shape: float
    efficiency: float


def smooth(log_weights: np.ndarray) -> Smoothed:
    """Pareto-smoothed importance weights; where no draw hit the target, none that could be used."""
    if not np.isfinite(np.max(log_weights)):
        return Smoothed(np.full(len(log_weights), -np.log(len(log_weights))), np.inf, 1.0 / len(log_weights))
    weights = log_weights - np.max(log_weights)
    k = len(weights)
    tail = int(np.ceil(min(0.2 * k, 3.0 * np.sqrt(k))))
    order = np.argsort(weights)
    cut = weights[order[-tail - 1]]
    top = order[-tail:]
    shape = np.inf
    excess = np.exp(weights[top]) - np.exp(cut)
    if tail >= 5 and excess[-1] > 0:
        fitted, scale = _generalised_pareto(excess)
        shape = fitted
        if np.isfinite(shape):
            share = (np.arange(1, tail + 1) - 0.5) / tail
            quantile = (
                scale * np.expm1(-shape * np.log1p(-share)) / shape if abs(shape) > 1e-9 else -scale * np.log1p(-share)
            )
            weights = weights.copy()
            weights[top] = np.minimum(np.log(quantile + np.exp(cut)), 0.0)
    elif tail >= 5:
        shape = -np.inf  # weights all alike: nothing to worry about
    weights = weights - log_sum(weights)
    return Smoothed(weights, float(shape), float(np.exp(-log_sum(2 * weights)) / k))


def _generalised_pareto(excess: np.ndarray) -> tuple[float, float]:
    """Shape and scale of sorted exceedances, by the quasi-Bayesian estimate of Zhang and Stephens."""
    n = len(excess)
    count = 30 + int(np.sqrt(n))
    quarter = excess[int(n / 4 + 0.5) - 1]
    grid = 1 / excess[-1] + (1 - np.sqrt(count / (np.arange(1, count + 1) - 0.5))) / (3.0 * max(quarter, 1e-300))
    shape = np.mean(np.log1p(-grid[:, None] * excess), axis=1)
    profile = n * (np.log(-grid / shape) - shape - 1)
    weight = np.exp(profile - log_sum(profile))
    theta = float(np.sum(grid * weight))
    found = float(np.mean(np.log1p(-theta * excess)))
    scale = -found / theta
    return (n * found + _PRIOR[0] * _PRIOR[1]) / (n + _PRIOR[0]), scale
