"""Effective draws per second: this sampler's moves against emcee's default stretch move, in one run.

    python -m experiments.posterior.speed

Both draw the same batched density from the same walkers; a sharp posterior (the paper's campaign as it is) and a weak
one (its noise twenty times larger). Effective draws are counted per evaluation, which no load of the machine can
change, and per second of the same run.

The third ratio is against what is written without `ident`: emcee's stretch move on SciPy's `solve_ivp`. Its likelihood
is timed in the same run, its effective draws per evaluation are those of the stretch move on the same posterior. And
`ident sample` is run whole on the paper's campaign, in a process of its own.
"""

from __future__ import annotations

import time
from dataclasses import replace
from pathlib import Path
from tempfile import TemporaryDirectory

import emcee
import numpy as np

from experiments.benchmarks import peers
from experiments.benchmarks.long_records import measure as timed
from experiments.make_campaigns import PAPER, PLANS
from experiments.simulator.signals import reference_rate
from ident.campaign import read_campaign
from ident.campaign.campaign import Campaign
from ident.fit.fit import fit
from ident.model import build_model
from ident.posterior.convergence import autocorrelation_time
from ident.posterior.density import make_density
from ident.posterior.evidence import learned
from ident.posterior.laplace import find_peak
from ident.posterior.moves import moves
from ident.posterior.sampler import LIKE, propose_from

DATA = Path(__file__).resolve().parents[2] / "data"
WALKERS, STEPS = 32, {"stretch": 5000, "own": 1500}  # fifty autocorrelation times of each or nearly
SAMPLES = 800


def noisy(campaign: Campaign, factor: float) -> Campaign:
    """Two records, shortened, with white noise added until the floor is `factor` times as high."""
    random, records = np.random.default_rng(0), []
    for record in campaign.fitted[:2]:
        sigma = record.noise.sigma
        added = random.normal(0.0, sigma * np.sqrt(factor**2 - 1), SAMPLES) if factor > 1 else np.zeros(SAMPLES)
        floor = replace(record.noise, sigma=sigma * factor)
        records.append(
            replace(record, time=record.time[:SAMPLES], drive=record.drive[:SAMPLES],
                    response=record.response[:SAMPLES] + added, noise=floor)
        )  # fmt: skip
    return replace(campaign, records=tuple(records))


def measure(campaign: Campaign) -> dict[str, tuple[float, float]]:
    """Per sampler: effective draws of the slowest parameter per thousand evaluations, and per second."""
    laplace = find_peak(make_density(fit(build_model(campaign), campaign)))
    laplace.density.log_posterior(np.zeros((1, laplace.density.size)))  # compiles
    begun = time.perf_counter()
    target, found = propose_from(laplace, learned(laplace, LIKE)), {}
    print(f"what to propose from took {time.perf_counter() - begun:.1f} s, once", flush=True)
    start = target.draw(np.random.default_rng(1), WALKERS)
    for name, chosen in (("own", moves(target)), ("stretch", None)):
        sampler = emcee.EnsembleSampler(
            WALKERS, len(laplace.covariance), laplace.density.log_posterior, vectorize=True, moves=chosen
        )
        begun = time.perf_counter()
        sampler.run_mcmc(emcee.State(start, random_state=np.random.RandomState(0).get_state()), STEPS[name])
        seconds = time.perf_counter() - begun
        chain = sampler.get_chain()[STEPS[name] // 5 :]
        draws = chain.shape[0] * WALKERS / float(autocorrelation_time(chain).max())
        found[name] = (1000 * draws / (chain.shape[0] * WALKERS), draws / (0.8 * seconds))
    return found


def adaptive_seconds() -> float:
    """What one likelihood costs by SciPy's adaptive solver: the two records of `noisy`, s, the best of five."""
    best = np.inf
    theta = np.array([getattr(PAPER, name) for name in peers.NAMES])
    for _ in range(5):
        begun = time.perf_counter()
        for plan in PLANS["platform_317hz"][:2]:
            step = plan.time[1]
            fine = np.arange(2 * (SAMPLES - 1) + 1) * step / 2
            omega = reference_rate(plan.drive, plan.time)
            peers.simulate_adaptive(theta, plan.drive.value(fine), plan.drive.rate(fine), omega, step, 1, SAMPLES)
        best = min(best, time.perf_counter() - begun)
    return best


def whole() -> float:
    """Seconds of CPU of `ident sample` on the paper's campaign."""
    with TemporaryDirectory() as folder:
        run = str(Path(folder) / "run")
        timed("fit", str(DATA / "platform_317hz"), "-o", run)
        return timed("sample", run)[0]


def main() -> None:
    """Print the ratios and assert them."""
    adaptive = adaptive_seconds()
    campaign = read_campaign(DATA / "platform_317hz")
    for name, factor, least in (("sharp", 1.0, 8.0), ("weak", 20.0, 3.0)):
        found = measure(noisy(campaign, factor))
        ratio = found["own"][0] / found["stretch"][0]
        print(f"{name}: per 1000 evaluations {found['own'][0]:.0f} against {found['stretch'][0]:.1f} effective draws, "
              f"{ratio:.1f} times; per second {found['own'][1]:.0f} against {found['stretch'][1]:.0f}")  # fmt: skip
        faster = found["own"][1] / found["stretch"][1]
        assert ratio > least and faster > least, (name, ratio, faster)
        without = found["stretch"][0] / 1000 / adaptive
        print(f"{name}: emcee over solve_ivp draws {without:.3f} a second; {found['own'][1] / without:.0f} times")
        assert name == "weak" or found["own"][1] > 1000 * without, (name, without)
    seconds = whole()
    print(f"ident sample data/platform_317hz: {seconds:.0f} s of CPU")
    assert seconds < 60, seconds


if __name__ == "__main__":
    main()
