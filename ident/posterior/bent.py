"""A mixture along a bent line, fitted to draws: what to propose from where the posterior is a banana.

Draws are longest where the records say least, and there a model is no longer linear: along that direction the others
bend. With u₁ along the longest axis of the draws and u₂… across it,

    v₁ = u₁,   vₖ = uₖ − bₖ u₁² − cₖ u₁³

is straight. The map has the determinant one, so that a density in v is one in x; and it goes on where draws are few, in
the tails, which a mixture alone leaves out.

Sources: H. Haario, E. Saksman, J. Tamminen, Comput. Stat. 14 (1999) 375, §3.1 (the twisted Gaussian); M. D. Parno,
Y. M. Marzouk, SIAM/ASA J. Uncertainty Quantification 6 (2018) 645 (proposals through polynomial maps).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from .mixture import Mixture, fit_mixture

_POWERS = (2, 3)
"""Of the bend. On the weak posterior of experiments/posterior/speed.py the weights had an efficiency of 0.39 and the
slowest parameter took 50 to 210 steps without a bend, 0.53 and 22 with its square, 0.58 and 10 with both."""


class Bent(NamedTuple):
    """`mixture` of v; `centre` (p,) and `axes` (p, p), columns, of u; `length` of the first, the unit of the powers;
    `bend` (powers, p − 1)."""

    mixture: Mixture
    centre: np.ndarray
    axes: np.ndarray
    length: float
    bend: np.ndarray

    def draw(self, random: np.random.RandomState | np.random.Generator, count: int) -> np.ndarray:
        """(count, p) points."""
        v = self.mixture.draw(random, count)
        v[:, 1:] += _powers(v[:, 0] / self.length) @ self.bend
        return self.centre + v @ self.axes.T

    def log_density(self, x: np.ndarray) -> np.ndarray:
        """(k,) at points (k, p)."""
        u = (x - self.centre) @ self.axes
        u[:, 1:] -= _powers(u[:, 0] / self.length) @ self.bend
        return self.mixture.log_density(u)


def fit_bent(draws: np.ndarray, seed: int = 0) -> Bent:
    """A proposal for the density that `draws` (k, p) came from."""
    centre = draws.mean(axis=0)
    axes = np.linalg.eigh(np.atleast_2d(np.cov(draws.T)))[1][:, ::-1]
    u = (draws - centre) @ axes
    length = float(u[:, 0].std()) or 1.0
    along = u[:, 0] / length
    # A straight part is fitted beside the bend and left to the mixture.
    columns = np.column_stack([np.ones(len(u)), along, _powers(along)])
    bend = np.linalg.lstsq(columns, u[:, 1:], rcond=None)[0][2:]
    u[:, 1:] -= _powers(along) @ bend
    return Bent(fit_mixture(u, seed), centre, axes, length, bend)


def _powers(along: np.ndarray) -> np.ndarray:
    return np.stack([along**power for power in _POWERS], axis=1)
