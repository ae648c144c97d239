"""A mixture of Gaussians fitted to draws, with a broad Student t beside it: what to propose from where one peak is not
enough.

Source: C. M. Bishop, Pattern Recognition and Machine Learning, 2006, §9.2 (expectation maximisation).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from .laplace import StudentT
from .log_sum import log_sum

_COMPONENTS = 4  # at most
_ROUNDS = 40  # of expectation and maximisation
_BROADER = 1.2  # of every width: a proposal narrower than its target has weights without bound
_DEFENCE = 0.1  # share of the broad t, which bounds the weights (Hesterberg, Technometrics 37 (1995) 185)


class Mixture(NamedTuple):
    """`shares` (c,) of the `parts`."""

    shares: np.ndarray
    parts: tuple[StudentT, ...]

    def draw(self, random: np.random.RandomState | np.random.Generator, count: int) -> np.ndarray:
        """(count, p) points."""
        counts = random.multinomial(count, self.shares)
        return np.concatenate([part.draw(random, int(k)) for part, k in zip(self.parts, counts, strict=True)])

    def log_density(self, x: np.ndarray) -> np.ndarray:
        """(k,) at points (k, p)."""
        return log_sum(self._by_part(x), axis=0)

    def _by_part(self, x: np.ndarray) -> np.ndarray:
        pairs = zip(self.parts, self.shares, strict=True)
        return np.stack([part.log_density(x) + np.log(max(share, 1e-300)) for part, share in pairs])


def fit_mixture(draws: np.ndarray, seed: int = 0) -> Mixture:
    """A proposal for the density that `draws` (k, p) came from."""
    k, p = draws.shape
    random = np.random.default_rng(seed)
    mean, whole = draws.mean(axis=0), np.atleast_2d(np.cov(draws.T)) + 1e-12 * np.eye(p)
    count = max(1, min(_COMPONENTS, k // (20 * p)))
    factor = np.linalg.cholesky(whole)
    centres = draws[random.choice(k, count, replace=False)]
    covariances = [whole.copy() for _ in range(count)]
    shares = np.full(count, 1.0 / count)
    for _ in range(_ROUNDS if count > 1 else 1):
        parts = tuple(_gaussian(c, v) for c, v in zip(centres, covariances, strict=True))
        by_part = Mixture(shares, parts)._by_part(draws)
        held = np.exp(by_part - log_sum(by_part, axis=0))
        weight = held.sum(axis=1) + 1e-9
        shares = weight / weight.sum()
        centres = held @ draws / weight[:, None]
        for c in range(count):
            off = draws - centres[c]
            # As many draws' worth of the whole as there are dimensions keeps every part from collapsing.
            covariances[c] = ((held[c, :, None] * off).T @ off + p * whole) / (weight[c] + p)
    parts = tuple(_gaussian(c, _BROADER**2 * v) for c, v in zip(centres, covariances, strict=True))
    broad = StudentT(mean, _BROADER * factor, 5.0)
    return Mixture(np.append((1 - _DEFENCE) * shares, _DEFENCE), (*parts, broad))


def _gaussian(centre: np.ndarray, covariance: np.ndarray) -> StudentT:
    return StudentT(centre, np.linalg.cholesky(covariance), 1e6)  # so many degrees of freedom are a Gaussian
