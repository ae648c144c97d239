"""How probable the records are under a model as a whole: ln Z = ln ∫ prior × likelihood.

Laplace first; then importance sampling from the Student t on the peak, whose weights say themselves whether they can be
trusted; where they waste more than half of the draws, from a mixture fitted to draws of the posterior.

Sources: as in `laplace`, `pareto`, `mixture`, `bent`.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from ..fit.result import Fit
from .bent import fit_bent
from .density import Density, make_density
from .laplace import Laplace, find_peak, proposal
from .log_sum import log_sum
from .pareto import TRUSTED, Smoothed, smooth

_DRAWS = 2048  # from Student's t on the peak
_SERVES = 0.5
"""Efficiency of the weights from which Student's t on the peak serves; of a Gaussian of fourteen dimensions it is 0.54.
At 0.39, the weak posterior of experiments/posterior/speed.py, it missed a tail of 15 % of the mass without a sign in
the weights, and as a proposal of a chain left the slowest parameter at 60 to 250 steps, bent mixtures at 5 to 26."""

_BY_PEAK = "importance sampling"
_ROUNDS = 4  # at most, of fitting the mixture to its own weighted draws, where there is no chain


class Evidence(NamedTuple):
    """ln Z with its Monte-Carlo standard `error`; `method` in words; `shape`, Pareto k̂; `efficiency` of the weights;
    `laplace`, the Gaussian's value. `draws` (k, p) with `log_weights` (k,) represent the posterior of `density`."""

    value: float
    error: float
    method: str
    shape: float
    efficiency: float
    laplace: float
    density: Density
    draws: np.ndarray
    log_weights: np.ndarray

    @property
    def found(self) -> bool:
        """Whether there is any: ln Z is −∞ where the records are impossible at every draw."""
        return bool(np.isfinite(self.value))

    @property
    def trusted(self) -> bool:
        return self.found and bool(self.shape <= TRUSTED)

    @property
    def words(self) -> str:
        """The number, how it was found, and whether it can be used."""
        if not self.found:
            return f"no evidence was found ({self.method}): the records are impossible at every draw"
        doubt = "" if self.trusted else f", not to be trusted: Pareto k = {self.shape:.2f} is above {TRUSTED}"
        return f"ln Z = {self.value:.2f} ± {self.error:.2f} ({self.method}, efficiency {self.efficiency:.2f}{doubt})"

    def resampled(self, count: int, seed: int = 0) -> np.ndarray:
        """(count, p) equally weighted draws of the posterior, by systematic resampling."""
        edges = np.cumsum(np.exp(self.log_weights))
        places = (np.arange(count) + np.random.default_rng(seed).random()) / count
        return self.draws[np.minimum(np.searchsorted(edges / edges[-1], places), len(edges) - 1)]


def log_evidence(
    fit: Fit | Density | Laplace, draws: np.ndarray | None = None, *, count: int = _DRAWS, seed: int = 0
) -> Evidence:
    """The evidence of a fit.

    **Arguments:** `fit`, or its density or peak where these are at hand; `draws` (k, p) of the posterior in the peak's
    coordinates, used where one peak does not describe it; `count` of importance draws.
    """
    laplace = fit if isinstance(fit, Laplace) else find_peak(fit if isinstance(fit, Density) else make_density(fit))
    random = np.random.default_rng([seed, 1])
    best = last = _importance(laplace, proposal(laplace), count, random, _BY_PEAK)
    for _ in range(_ROUNDS if draws is None else 1):
        if best.efficiency >= _SERVES and best.trusted:
            break
        chosen = last.resampled(count, seed) if draws is None else draws
        last = _importance(laplace, fit_bent(chosen, seed), count, random, f"{_BY_PEAK}, bent mixture")
        best = max(best, last, key=lambda evidence: (evidence.trusted, evidence.efficiency))
    return best


def learned(laplace: Laplace, count: int, seed: int = 0) -> np.ndarray:
    """(count, p) draws like the posterior's, to which a proposal can be fitted; none where Student's t on the peak
    serves."""
    evidence = log_evidence(laplace, seed=seed)
    return evidence.resampled(0 if evidence.method == _BY_PEAK and evidence.trusted else count, seed)


def _importance(laplace: Laplace, target: Any, count: int, random: np.random.Generator, method: str) -> Evidence:
    x = target.draw(random, count)
    raw = laplace.density.log_posterior(x) - target.log_density(x)
    found: Smoothed = smooth(raw)
    value = float(log_sum(raw) - np.log(count))
    error = float(np.sqrt(max(1.0 / found.efficiency - 1.0, 0.0) / count))
    return Evidence(
        value, error, method, found.shape, found.efficiency, laplace.log_evidence, laplace.density, x, found.log_weights
    )
