"""The posterior's peak and its Gaussian: where everything starts from, and often nearly all there is to say.

    ln Z ≈ ln p(x̂) + (p/2) ln 2π + ½ ln |C|

Source: D. J. C. MacKay, Information Theory, Inference, and Learning Algorithms, 2003, ch. 27.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from scipy.special import gammaln

from .density import Density

_MOST = 60  # steps to the peak
_STILL = 1e-6  # nats that a step still promises
_LEAST_DAMPING, _MOST_DAMPING = 1e-4, 1e6  # shares of the Hessian's diagonal
_FREEDOM = 8.0  # of the Student t around the peak: tails heavier than those of any posterior met


class Laplace(NamedTuple):
    """`density` with x = 0 at the peak; there `peak` = ln p; `covariance` (p, p) of x."""

    density: Density
    peak: float
    covariance: np.ndarray

    @property
    def log_evidence(self) -> float:
        p = len(self.covariance)
        return self.peak + 0.5 * p * float(np.log(2 * np.pi)) + 0.5 * float(np.linalg.slogdet(self.covariance)[1])


def find_peak(density: Density) -> Laplace:
    """The highest peak that damped Gauss–Newton reaches from the fit, and from the fit with unlikely values mended.

    Noise colour and priors have moved it a little from the least-squares minimum, or far, where the records leave a
    direction free.
    """
    likely = density.likely()
    found = [_climb(start) for start in (density, likely) if start is not None]
    return max(found, key=lambda peak: peak.peak)


def _climb(density: Density) -> Laplace:
    origin = np.zeros((1, density.size))
    best = float(density.log_posterior(origin)[0])
    damping = 0.0
    for _ in range(_MOST):
        linear, (slope, bend) = density.linearise(), density.prior_slope()
        matrix, gradient = linear.matrix + bend, linear.gradient + slope
        while True:
            step = -inverse(matrix + damping * np.diag(np.diag(matrix))) @ gradient
            gain = float(-0.5 * step @ gradient)
            trial = density.moved(step, linear.starts)
            found = float(trial.log_posterior(origin)[0])
            if found >= best or damping > _MOST_DAMPING:
                break
            damping = max(10.0 * damping, _LEAST_DAMPING)
        if found < best:
            break
        density, best = trial, found
        damping = 0.0 if damping <= _LEAST_DAMPING else damping / 10.0
        if gain < _STILL:
            break
    return Laplace(density, best, inverse(density.linearise().matrix + density.prior_slope()[1]))


def inverse(matrix: np.ndarray) -> np.ndarray:
    """Inverse of a Hessian, singular directions bounded by rounding; priors keep it from having any."""
    matrix = (matrix + matrix.T) / 2
    lengths = np.sqrt(np.maximum(np.diag(matrix), 1e-12))
    sizes, axes = np.linalg.eigh(matrix / np.outer(lengths, lengths))
    axes = axes / lengths[:, None]
    return (axes / np.maximum(sizes, 1e-9)) @ axes.T


class StudentT(NamedTuple):
    """A multivariate Student t, to propose from: `centre` (p,), Cholesky `factor` of its shape matrix, `freedom`."""

    centre: np.ndarray
    factor: np.ndarray
    freedom: float = _FREEDOM

    def draw(self, random: np.random.RandomState | np.random.Generator, count: int) -> np.ndarray:
        """(count, p) points."""
        p = len(self.centre)
        normal = random.normal(size=(count, p)) @ self.factor.T
        return self.centre + normal / np.sqrt(random.chisquare(self.freedom, size=count) / self.freedom)[:, None]

    def log_density(self, x: np.ndarray) -> np.ndarray:
        """(k,) at points (k, p)."""
        p, nu = len(self.centre), self.freedom
        off = np.linalg.solve(self.factor, (x - self.centre).T)
        constant = gammaln((nu + p) / 2) - gammaln(nu / 2) - 0.5 * p * np.log(np.pi * nu)
        size = float(np.sum(np.log(np.diag(self.factor))))
        return constant - size - 0.5 * (nu + p) * np.log1p(np.sum(off**2, axis=0) / nu)


def proposal(laplace: Laplace) -> StudentT:
    """Student's t on the peak."""
    return StudentT(np.zeros(len(laplace.covariance)), np.linalg.cholesky(laplace.covariance))
