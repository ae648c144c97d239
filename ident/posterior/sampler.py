"""Drawing the posterior with emcee: several ensembles side by side, in blocks, until their sample can be trusted.

Everything that decides the chain is in the chain: blocks have a fixed length, and the rule that stops looks at the
draws alone. So a run that was killed and resumed is the run that was left in peace, bit by bit.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

import emcee
import numpy as np

from .bent import Bent, fit_bent
from .chain_file import Chain, read_chain, write_chain
from .convergence import Convergence, judge
from .density import BATCH, Density
from .evidence import learned
from .laplace import Laplace, StudentT, find_peak, proposal
from .moves import moves

ENSEMBLES = 4  # that must agree
BLOCK = 50
"""Steps between two looks at the chain."""
_LEAST_STEPS = 150  # before the first look: fewer say nothing of τ
_MOST_STEPS = 200_000  # of each walker: what has not converged by then will not
_EVERY = 2.0  # s between two writings of the chain; what a kill can cost
_MOST_REDRAWS = 200  # of walkers that would begin where the posterior is zero
LIKE = 2000  # draws to which a mixture is fitted
_LEARNS, _OFTEN = 300, 3  # steps after which draws may tell better what to propose, doubled each time; how many times
_LEARNED_FROM = 8000  # draws; of 2000 a tail of a hundredth of the mass has too few


class Progress(NamedTuple):
    """Where a run stands: `steps` of each ensemble, smallest effective size, largest R̂, seconds that are left (None if
    that cannot be said)."""

    steps: int
    ess: float
    rhat: float
    seconds_left: float | None


class Sampled(NamedTuple):
    """What sampling left: the `laplace` that it started from, the `chain`, how it is judged, and `stopped`: "" if the
    rule was met, else what ended it."""

    laplace: Laplace
    chain: Chain
    convergence: Convergence
    stopped: str

    @property
    def kept(self) -> np.ndarray:
        """(E, steps, walkers, p) after burn-in."""
        return self.chain.positions[:, self.convergence.burned :]

    def draws(self, count: int) -> np.ndarray:
        """(count, p) draws spread evenly over ensembles and steps, the same each time."""
        return spread_evenly(self.kept, count)


def spread_evenly(kept: np.ndarray, count: int) -> np.ndarray:
    """(count, p) of draws (E, steps, walkers, p), spread evenly over ensembles and steps, the same each time."""
    flat = np.moveaxis(kept, 0, 2).reshape(-1, kept.shape[-1])
    return flat[np.linspace(0, len(flat) - 1, min(count, len(flat))).astype(int)]


def sample(
    density: Density,
    path: Path | None,
    key: str,
    *,
    resume: bool = False,
    seed: int = 0,
    seconds: float | None = None,
    report: Callable[[Progress], None] = lambda _: None,
) -> Sampled:
    """Draw until N > 50 τ with τ stable and R̂ < 1.01, or until time is up; Ctrl-C ends it with what there is.

    **Arguments:** `path`: the chain's file, None to keep it in memory; `key`: what it belongs to; `resume`: go on with
    the file that is there.

    **Raises:** UserError if there is no chain to resume, or it is damaged or another run's.
    """
    if resume and path is not None:
        chain = read_chain(path, key)
        density = density.framed(chain.frame)
        laplace = Laplace(density, float(chain.frame["peak"]), chain.frame["covariance"])
    else:
        laplace = find_peak(density)
        density = laplace.density
        chain = _begin(laplace, key, seed)
    target = propose_from(laplace, chain.frame["like"])
    begun = since = time.monotonic()
    written, first = 0.0, chain.positions.shape[1]
    samplers = [_sampler(density, target, chain.positions.shape[2]) for _ in range(ENSEMBLES)]
    found: Convergence | None = None
    stopped = ""
    try:
        while True:
            steps = chain.positions.shape[1]
            if steps >= _LEAST_STEPS:
                fresh = len(chain.taus) < _looks(steps)
                # A resumed chain may hold the τ of this look already, and is judged by those before, as it was then.
                found = judge(chain.positions, chain.taus if fresh else chain.taus[:-1])
                if fresh:
                    chain = chain._replace(taus=(*chain.taus, float(found.tau.max())))
                report(_progress(found, steps, steps - first, time.monotonic() - since))
                if not found.reasons:
                    break
                if (better := _begun_anew(chain, found)) is not None:
                    chain, found, first, since = better, None, 1, time.monotonic()
                    target = propose_from(laplace, chain.frame["like"])
                    samplers = [_sampler(density, target, chain.positions.shape[2]) for _ in range(ENSEMBLES)]
            if seconds is not None and time.monotonic() - begun > seconds:
                stopped = "time ran out"
                break
            if steps >= _MOST_STEPS:
                stopped = f"{_MOST_STEPS} steps were not enough"
                break
            if path is not None and time.monotonic() - written > _EVERY:
                write_chain(path, chain)
                written = time.monotonic()
            chain = _block(samplers, chain)
    except KeyboardInterrupt:
        stopped = "it was interrupted"
    if path is not None:
        write_chain(path, chain)
    return Sampled(laplace, chain, found or judge(chain.positions, chain.taus), stopped)


def _begun_anew(chain: Chain, found: Convergence) -> Chain | None:
    """A chain that is far from its end, begun again where it is, with proposals like what it has drawn.

    The weights of importance draws may say that these serve, and they miss a tail: where a stress acts by a restraint
    that is about zero, it had a hundredth of the mass, and walkers stayed there for 470 steps. What was drawn with
    other proposals is left out, for a chain that goes on adapting need not keep the posterior.
    """
    steps, times = chain.positions.shape[1], int(chain.frame.get("learned", 0))
    if steps != _LEARNS * 2**times or times >= _OFTEN or found.share_done > 0.5:
        return None
    like = spread_evenly(chain.positions[:, found.burned :], _LEARNED_FROM)
    return chain._replace(
        positions=chain.positions[:, -1:],
        log_probability=chain.log_probability[:, -1:],
        accepted=np.zeros_like(chain.accepted),
        taus=(),
        frame={**chain.frame, "like": like, "learned": np.asarray(times + 1)},
    )


def _looks(steps: int) -> int:
    return (steps - _LEAST_STEPS) // BLOCK + 1


def _begin(laplace: Laplace, key: str, seed: int) -> Chain:
    """Walkers from the peak's Student t, redrawn until they are inside the support."""
    p = laplace.density.size
    walkers = 2 * BATCH * -(-p // BATCH)  # each half of an ensemble fills its batches; emcee asks for two per dimension
    like = learned(laplace, LIKE, seed)
    target, positions, values, states = propose_from(laplace, like), [], [], []
    for e in range(ENSEMBLES):
        random = np.random.RandomState(np.random.MT19937(np.random.SeedSequence([seed, e])))
        x = target.draw(random, walkers)
        inside = laplace.density.log_posterior(x)
        for _ in range(_MOST_REDRAWS):
            out = ~np.isfinite(inside)
            if not out.any():
                break
            x[out] = target.draw(random, int(out.sum()))
            inside[out] = laplace.density.log_posterior(x[out])
        positions.append(x)
        values.append(inside)
        states.append(random.get_state(legacy=True))
    frame = {**laplace.density.frame(), "covariance": laplace.covariance, "peak": np.asarray(laplace.peak)}
    frame["like"] = like
    accepted = np.zeros((ENSEMBLES, walkers))
    return Chain(np.array(positions)[:, None], np.array(values)[:, None], accepted, tuple(states), (), frame, key)


def propose_from(laplace: Laplace, like: np.ndarray) -> StudentT | Bent:
    """What to propose from: Student's t on the peak, or a mixture fitted to draws."""
    return fit_bent(like) if len(like) else proposal(laplace)


def _sampler(density: Density, target: StudentT | Bent, walkers: int) -> emcee.EnsembleSampler:
    return emcee.EnsembleSampler(walkers, density.size, density.log_posterior, vectorize=True, moves=moves(target))


def _block(samplers: list[emcee.EnsembleSampler], chain: Chain) -> Chain:
    """One block more of every ensemble; all of it or, where it is interrupted, nothing."""
    # The first block is a step shorter: the start is the first of a whole number of blocks.
    count = BLOCK - chain.positions.shape[1] % BLOCK
    positions, values, accepted, states = [], [], [], []
    for e, sampler in enumerate(samplers):
        sampler.reset()
        state = emcee.State(
            chain.positions[e, -1], log_prob=chain.log_probability[e, -1], random_state=chain.generators[e], copy=True
        )
        sampler.run_mcmc(state, count, skip_initial_state_check=True)
        positions.append(sampler.get_chain())
        values.append(sampler.get_log_prob())
        accepted.append(sampler.backend.accepted)
        states.append(sampler.random_state)
    return chain._replace(
        positions=np.concatenate([chain.positions, np.array(positions)], axis=1),
        log_probability=np.concatenate([chain.log_probability, np.array(values)], axis=1),
        accepted=chain.accepted + np.array(accepted),
        generators=tuple(states),
    )


def _progress(found: Convergence, steps: int, fresh: int, elapsed: float) -> Progress:
    left = None
    if fresh > 0 and found.share_done > 0:
        left = elapsed / fresh * max(found.burned + found.steps / found.share_done - steps, 0)
    return Progress(steps, float(found.ess.min()), float(found.rhat.max()), left)
