"""The same posterior by other means: a random walk and NUTS, which share no move with the sampler; nested sampling.

    python -m experiments.posterior.peers            # the two densities of `speed`: a sharp posterior and a weak one

- Sixteen chains of Metropolis' random walk, proposals from the peak's covariance times 2.38²/p, against the chain that
  `ident sample` draws: means within 0.05 sd, standard deviations within 5 %.
- NUTS, which follows the gradient of the same density, where `blackjax` is installed: within the same.
- Nested sampling over the box of eight standard deviations around the peak, where it is installed, against
  `log_evidence`: within 0.1 nat and its own error, at a hundred times its speed on the sharp posterior.

The peers are no dependencies of the package: `pip install dynesty nautilus-sampler blackjax`.

Sources: G. O. Roberts, A. Gelman, W. R. Gilks, Ann. Appl. Probab. 7 (1997) 110 (random walk); J. S. Speagle, Mon. Not.
R. Astron. Soc. 493 (2020) 3132 (dynesty); J. U. Lange, ibid. 525 (2023) 3181 (nautilus); M. D. Hoffman, A. Gelman,
J. Mach. Learn. Res. 15 (2014) 1593 (NUTS).
"""

from __future__ import annotations

import argparse
import importlib.util
import time
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

from ident.campaign import read_campaign
from ident.fit.fit import fit
from ident.model import build_model
from ident.posterior.convergence import autocorrelation_time
from ident.posterior.density import BATCH, make_density
from ident.posterior.evidence import log_evidence
from ident.posterior.laplace import Laplace, find_peak
from ident.posterior.sampler import sample

from .speed import DATA, noisy

NOISES = {"sharp": 1.0, "weak": 20.0}  # times that of the campaign
_BOX = 8.0  # standard deviations to each side
_LIVE = 400


def random_walk(peak: Laplace, steps: int, seed: int = 0) -> np.ndarray:
    """(steps, chains, p) of Metropolis' random walk."""
    random, p = np.random.default_rng(seed), len(peak.covariance)
    factor = np.linalg.cholesky(peak.covariance)
    x = random.standard_normal((BATCH, p)) @ factor.T
    value, chain = peak.density.log_posterior(x), np.empty((steps, BATCH, p))
    for i in range(steps):
        tried = x + 2.38 / np.sqrt(p) * random.standard_normal((BATCH, p)) @ factor.T
        there = peak.density.log_posterior(tried)
        taken = np.log(random.random(BATCH)) < there - value
        x, value = np.where(taken[:, None], tried, x), np.where(taken, there, value)
        chain[i] = x
    return chain


def nuts(peak: Laplace, draws: int, seed: int = 0) -> np.ndarray:
    """(draws, 1, p) of blackjax' NUTS in coordinates in which the peak's covariance is the unit matrix.

    The density is no JAX function as a whole, so that NUTS calls it, with its gradient by the sensitivities of the
    motion; a gradient by differences of the prior is no harm, for what is accepted depends on the density alone.
    """
    import blackjax
    import jax
    import jax.numpy as jnp

    factor, p = np.linalg.cholesky(peak.covariance), len(peak.covariance)

    def both(u: np.ndarray) -> tuple[np.float64, np.ndarray]:
        x = factor @ np.asarray(u)
        there = peak.density.moved(x)
        value = float(there.log_posterior(np.zeros((1, p)))[0])
        slope = -factor.T @ (there.linearise().gradient + there.prior_slope()[0])
        # Where there is no finite motion there is no gradient either: a divergence, which NUTS turns back from.
        fine = np.isfinite(value) and np.all(np.isfinite(slope))
        return np.float64(value if fine else peak.peak - 1e10), np.asarray(slope if fine else np.zeros(p))

    shapes = (jax.ShapeDtypeStruct((), float), jax.ShapeDtypeStruct((p,), float))

    @jax.custom_vjp
    def log_density(u: jax.Array) -> jax.Array:
        return jax.pure_callback(both, shapes, u)[0]

    log_density.defvjp(lambda u: jax.pure_callback(both, shapes, u), lambda slope, g: (g * slope,))
    kernel = blackjax.nuts(log_density, step_size=0.5, inverse_mass_matrix=jnp.ones(p))
    step, keys = jax.jit(kernel.step), jax.random.split(jax.random.PRNGKey(seed), draws)
    state, found = kernel.init(jnp.zeros(p), keys[0]), np.empty((draws, 1, p))
    for i, key in enumerate(keys):
        state, _ = step(key, state)
        found[i, 0] = factor @ np.asarray(state.position)
    return found


def own_draws(peak: Laplace) -> np.ndarray:
    """(k, free) physical values that `ident sample` draws."""
    with TemporaryDirectory() as folder:
        drawn = sample(peak.density, Path(folder) / "chain.h5", "peers")
    density = drawn.laplace.density
    return density.values(drawn.kept.reshape(-1, density.size))[:, list(density.static.free)]


def same_posterior(own: np.ndarray, peak: Laplace, chain: np.ndarray) -> tuple[float, float, float]:
    """Largest difference of a mean in sd and of an sd in shares of it, physical values, and the least effective size of
    the other `chain` (steps, chains, p), whose first fifth is left out."""
    chain = chain[len(chain) // 5 :]
    other = peak.density.values(chain.reshape(-1, chain.shape[-1]))[:, list(peak.density.static.free)]
    apart = np.abs(own.mean(axis=0) - other.mean(axis=0)) / other.std(axis=0)
    wider = np.abs(own.std(axis=0) / other.std(axis=0) - 1)
    effective = chain.shape[0] * chain.shape[1] / float(np.max(autocorrelation_time(chain)))
    return float(apart.max()), float(wider.max()), effective


def nested(peak: Laplace, name: str) -> tuple[float, float, float]:
    """ln Z over the box, its error, seconds."""
    half = _BOX * np.sqrt(np.diag(peak.covariance))
    volume = float(np.sum(np.log(2 * half)))
    place = lambda u: (2 * np.asarray(u) - 1) * half
    # A point where the model has no finite motion is as unlikely as can be told to a sampler of finite numbers.
    value = lambda x: np.maximum(peak.density.log_posterior(np.atleast_2d(x)), peak.peak - 1e6)
    begun = time.perf_counter()
    if name == "dynesty":
        from dynesty import NestedSampler

        found = NestedSampler(
            lambda x: float(value(x)[0]), place, len(half), nlive=_LIVE, rstate=np.random.default_rng(0)
        )
        found.run_nested(print_progress=False, dlogz=0.05)
        result = found.results
        return float(result.logz[-1]) + volume, float(result.logzerr[-1]), time.perf_counter() - begun
    from nautilus import Sampler

    sampler = Sampler(place, value, n_dim=len(half), vectorized=True, pass_dict=False, seed=0, n_live=1000)
    sampler.run()
    return float(sampler.log_z) + volume, float(1 / np.sqrt(sampler.n_eff)), time.perf_counter() - begun


def main() -> None:
    """Print and assert all comparisons."""
    parser = argparse.ArgumentParser()
    parser.add_argument("--steps", type=int, default=12000)
    parser.add_argument("--draws", type=int, default=4000, help="of NUTS")
    parser.add_argument("--only", choices=tuple(NOISES))
    told = parser.parse_args()
    for name, factor in NOISES.items():
        if told.only not in (None, name):
            continue
        campaign = noisy(read_campaign(DATA / "platform_317hz"), factor)
        peak = find_peak(make_density(fit(build_model(campaign), campaign)))
        log_evidence(peak)  # compiles
        begun = time.perf_counter()
        evidence = log_evidence(peak)
        seconds = time.perf_counter() - begun
        print(f"{name}: {evidence.words}, {seconds:.2f} s", flush=True)
        for peer in ("dynesty", "nautilus"):
            if importlib.util.find_spec(peer) is None:
                print(f"  {peer}: not installed")
                continue
            value, error, took = nested(peak, peer)
            off = value - evidence.value
            print(f"  {peer}: {value:.2f} ± {error:.2f}, {off:+.2f}, {took / seconds:.0f} times as long", flush=True)
            assert abs(off) < 0.1 + 3 * error, (name, peer, off, error)
            assert name == "weak" or took > 100 * seconds, (peer, took, seconds)
        own, chains = own_draws(peak), {"random walk": random_walk(peak, told.steps)}
        if importlib.util.find_spec("blackjax") is not None:
            chains["NUTS"] = nuts(peak, told.draws)
        for peer, chain in chains.items():
            apart, wider, effective = same_posterior(own, peak, chain)
            print(f"  {peer}, {effective:.0f} draws: means {apart:.3f} sd apart, sds {100 * wider:.1f} %", flush=True)
            # The reference is itself a sample: its means are known to 1/√n, its deviations to 1/√2n.
            assert apart < 0.05 + 3 / np.sqrt(effective), (name, peer, apart, effective)
            assert wider < 0.05 + 3 / np.sqrt(2 * effective), (name, peer, wider, effective)


if __name__ == "__main__":
    main()
