"""When a sample can be trusted: autocorrelation time, effective size, rank R̂, Monte-Carlo error.

Walkers of one ensemble move by each other's positions and are no independent chains; several ensembles, started apart
with generators of their own, are.

Sources: J. Goodman, J. Weare, Commun. Appl. Math. Comput. Sci. 5 (2010) 65, §3 (autocorrelation of an ensemble);
A. Vehtari, A. Gelman, D. Simpson, B. Carpenter, P.-C. Bürkner, Bayesian Anal. 16 (2021) 667 (rank-normalised split R̂).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from scipy.stats import norm, rankdata

ENOUGH = 50.0
"""Steps per autocorrelation time below which its own estimate is not to be trusted (emcee's manual)."""
_STABLE = 0.1  # relative change of τ between two checks; its own standard error at N = 50 τ is about that
_MIXED = 1.01  # R̂; Vehtari et al. 2021, §4


class Convergence(NamedTuple):
    """State of a sample: per parameter (p,) `tau` in steps, `ess`, `rhat`, and `error`, the Monte-Carlo standard error
    of the mean in units of x; `steps` kept of each ensemble after `burned` ones; `stable`: τ agreed at the last
    checks."""

    tau: np.ndarray
    ess: np.ndarray
    rhat: np.ndarray
    error: np.ndarray
    steps: int
    burned: int
    stable: bool

    @property
    def reasons(self) -> tuple[str, ...]:
        """Why the sample is not final yet, in words; none if it is."""
        found = []
        if not self.steps > ENOUGH * float(self.tau.max()):
            found.append(
                f"the chain has {self.steps} steps, {self.steps / float(self.tau.max()):.0f} autocorrelation times of "
                f"{ENOUGH:.0f} that are needed"
            )
        if not self.stable:
            found.append("the autocorrelation time still changes")
        if not float(self.rhat.max()) < _MIXED:
            found.append(f"independent ensembles disagree (R-hat {float(self.rhat.max()):.3f})")
        return tuple(found)

    @property
    def share_done(self) -> float:
        """How much of the steps needed are there, 0 to 1."""
        return min(1.0, self.steps / (ENOUGH * float(self.tau.max())))


def judge(chains: np.ndarray, before: tuple[float, ...]) -> Convergence:
    """Judge ensembles (E, steps, walkers, p).

    **Arguments:** `before`: the largest τ at the last checks, the latest last; three agreeing values are stable.
    """
    burned = _burn_in(chains)
    kept = chains[:, burned:]
    ensembles, steps, walkers, p = kept.shape
    tau = np.mean([autocorrelation_time(e) for e in kept], axis=0)
    ess = ensembles * steps * walkers / tau
    flat = kept.reshape(ensembles, steps * walkers, p)
    rhat = np.array([rank_rhat(flat[..., k]) for k in range(p)])
    spread = kept.reshape(-1, p).std(axis=0)
    recent = [*before[-2:], float(tau.max())]
    stable = len(recent) == 3 and max(recent) - min(recent) < _STABLE * max(recent)
    return Convergence(tau, ess, rhat, spread / np.sqrt(ess), steps, burned, stable)


def _burn_in(chains: np.ndarray) -> int:
    """Steps to leave out: five autocorrelation times, at most half of what there is; walkers start near the answer."""
    rough = max(float(np.max(autocorrelation_time(e))) for e in chains)
    return int(min(np.ceil(5 * rough), chains.shape[1] // 2))


def autocorrelation_time(chain: np.ndarray) -> np.ndarray:
    """Integrated autocorrelation time (p,) of an ensemble (steps, walkers, p), in steps; at least one.

    The window closes where it is five times the sum so far (A. Sokal, Monte Carlo methods in statistical mechanics,
    1989, §3).
    """
    steps = len(chain)
    size = 2 ** int(np.ceil(np.log2(2 * max(steps, 2))))
    off = chain - chain.mean(axis=(0, 1))
    spectrum = np.fft.rfft(off, size, axis=0)
    correlation = np.fft.irfft((spectrum * spectrum.conj()).real.mean(axis=1), size, axis=0)[:steps]
    start = np.where(correlation[0] > 0, correlation[0], 1.0)
    sums = 2.0 * np.cumsum(correlation / start, axis=0) - 1.0
    closed = np.arange(steps)[:, None] >= 5.0 * sums
    window = np.where(closed.any(axis=0), closed.argmax(axis=0), steps - 1)
    return np.maximum(sums[window, np.arange(chain.shape[2])], 1.0)


def rank_rhat(chains: np.ndarray) -> float:
    """Rank-normalised split R̂ of one parameter, (ensembles, draws): the larger of location and scale."""
    half = chains.shape[1] // 2
    split = np.concatenate([chains[:, :half], chains[:, half : 2 * half]])
    folded = np.abs(split - np.median(split))
    return max(_rhat(_normal_ranks(split)), _rhat(_normal_ranks(folded)))


def _normal_ranks(values: np.ndarray) -> np.ndarray:
    ranks = rankdata(values).reshape(values.shape)
    return norm.ppf((ranks - 0.375) / (values.size + 0.25))


def _rhat(chains: np.ndarray) -> float:
    n = chains.shape[1]
    within = float(np.mean(np.var(chains, axis=1, ddof=1)))
    between = float(np.var(np.mean(chains, axis=1), ddof=1))
    return float(np.sqrt((n - 1) / n + between / within)) if within > 0 else np.inf
