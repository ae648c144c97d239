"""Constant, relative and phase noise from differences of points: a fit of variances to squares.

Each difference of points has a variance that is linear in those of the three kinds of noise. They are found by the
likelihood of Gaussian differences. Where the data would have a variance negative or near zero, the mean of what it may
still be is taken, not the likeliest value: a point without noise would decide everything.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.special import log_ndtr

CLIP = 3.0
"""Standard deviations beyond which a residual counts no more: the rest of a corner, an outlier."""
KEPT = 0.99402
"""E[min(x², 9)] of a standard normal x, by which clipping is undone."""
USUAL = 0.455
"""Median of the square of a standard normal."""
_DECIDED = 4.0  # standard errors from zero beyond which it does not matter that no variance is negative


@dataclass(frozen=True)
class Scatter:
    """Squared residuals, and how much of σ², r² and σ_φ² each has: E[squared] = share @ (σ², r², σ_φ²); `alike`: how
    many residuals say together what one of independent ones does."""

    squared: np.ndarray
    share: np.ndarray
    alike: np.ndarray

    def beside(self, other: Scatter) -> Scatter:
        """Both together."""
        return Scatter(*(np.concatenate([getattr(one, name) for one in (self, other)])
                         for name in ("squared", "share", "alike")))  # fmt: skip


def shares(parts: np.ndarray, sizes: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """How much of σ², r² and σ_φ² a weighted sum of relative errors has, along the response and across it."""
    along, across = np.real(parts) ** 2, np.imag(parts) ** 2
    constant = ((along + across) / sizes**2).sum(1)
    one = np.stack([constant, along.sum(1), across.sum(1)], 1)
    return one, np.stack([constant, across.sum(1), along.sum(1)], 1)


def variances_of(scatter: Scatter) -> tuple[np.ndarray, np.ndarray]:
    """(3,) σ², r², σ_φ² and the covariance of their errors: reweighted least squares on the squared residuals.

    The weights 1/variance² make it the likelihood equation of Gaussian residuals; what is beyond `CLIP` is clipped.
    """
    used = np.flatnonzero(np.any(scatter.share > 0, 0))
    scale = np.array([np.median(scatter.squared / np.maximum(scatter.share[:, k], 1e-300)) for k in used]) / USUAL
    scale = np.maximum(scale, 1e-300)
    share, counts = scatter.share[:, used] * scale, scatter.alike**-0.5
    theta, covariance = np.full(len(used), 1.0 / len(used)), np.eye(len(used))
    for _ in range(60):
        expected = np.maximum(share @ theta, 1e-300)
        squared = np.minimum(scatter.squared, CLIP**2 * expected) / KEPT
        weighted = share * (counts / expected)[:, None]
        covariance = np.linalg.pinv(weighted.T @ weighted / 2.0)
        new = _possible(covariance @ (weighted.T @ (counts * squared / expected)) / 2.0, covariance)
        done = np.max(np.abs(new - theta)) < 1e-6 * np.max(np.abs(new))
        theta = 0.5 * theta + 0.5 * new
        if done:
            break
    variances, errors = np.zeros(3), np.zeros((3, 3))
    variances[used] = theta * scale
    errors[np.ix_(used, used)] = covariance * np.outer(scale, scale)
    return variances, errors


def _possible(estimate: np.ndarray, covariance: np.ndarray) -> np.ndarray:
    """The mean of variances of which an estimate says that they are Gaussian about it, but none of which is negative,
    one after another, the most doubtful first."""
    estimate, error = estimate.copy(), np.sqrt(np.diag(covariance))
    for k in np.argsort(estimate / np.maximum(error, 1e-300)):
        z = float(estimate[k] / max(error[k], 1e-300))
        if z < _DECIDED:
            estimate += covariance[:, k] / error[k] * (_mean_above(z) - z) if error[k] > 0 else 0.0
    return np.maximum(estimate, 1e-3 * error)


def _mean_above(z: float) -> float:
    """The mean of a standard normal about z, given that it is positive."""
    return z + float(np.exp(-0.5 * z * z - log_ndtr(z))) / np.sqrt(2 * np.pi)
