"""Every move that is used draws a known Gaussian and a banana; so does their mix."""

from __future__ import annotations

import emcee
import numpy as np
import pytest
from emcee.moves import DEMove
from scipy import stats

from ident.posterior.bent import fit_bent
from ident.posterior.convergence import autocorrelation_time
from ident.posterior.laplace import StudentT
from ident.posterior.mixture import fit_mixture
from ident.posterior.moves import IndependenceMove, moves

BEND = 0.5


def gaussian(d: int) -> np.ndarray:
    """A covariance whose variances span two decades, correlated throughout."""
    random = np.random.default_rng(d)
    axes, _ = np.linalg.qr(random.standard_normal((d, d)))
    return (axes * np.geomspace(0.1, 10.0, d)) @ axes.T


def banana(x: np.ndarray) -> np.ndarray:
    """x₁ ~ N(0, 1), x₂ − b (x₁² − 1) ~ N(0, 1): mean 0, variances 1 and 1 + 2 b²."""
    return -0.5 * x[:, 0] ** 2 - 0.5 * (x[:, 1] - BEND * (x[:, 0] ** 2 - 1)) ** 2


def draw(log_density, start, chosen, steps, seed=0) -> np.ndarray:
    walkers, d = start.shape
    sampler = emcee.EnsembleSampler(walkers, d, log_density, vectorize=True, moves=chosen)
    random = np.random.RandomState(seed).get_state()
    sampler.run_mcmc(emcee.State(start, random_state=random), steps, skip_initial_state_check=True)
    return sampler.get_chain()[steps // 10 :]


def off_target(covariance: np.ndarray) -> StudentT:
    """A proposal that is beside its target and 1.3 times too broad, as one from a fit may be."""
    centre = 0.3 * np.sqrt(np.diag(covariance))
    return StudentT(centre, 1.3 * np.linalg.cholesky(covariance))


@pytest.mark.parametrize("d", [3, 8, 15])
@pytest.mark.parametrize("kind", ["independence", "differential evolution", "both"])
def test_a_gaussian_keeps_its_variance_within_two_percent(kind, d):
    covariance = gaussian(d)
    precision = np.linalg.inv(covariance)
    target = off_target(covariance)
    chosen = {
        "independence": [(IndependenceMove(target), 1.0)],
        "differential evolution": [(DEMove(), 1.0)],
        "both": moves(target),
    }[kind]
    log_density = lambda x: -0.5 * np.einsum("ki,ij,kj->k", x, precision, x)
    start = np.random.default_rng(1).multivariate_normal(np.zeros(d), covariance, 64)
    steps = {"independence": 3000, "differential evolution": 2500 + 1000 * d, "both": 3000 + 300 * d}[kind]

    chain = draw(log_density, start, chosen, steps)

    white = chain @ np.linalg.inv(np.linalg.cholesky(covariance)).T
    variances = white.reshape(-1, d).var(axis=0)
    effective = white.shape[0] * white.shape[1] / autocorrelation_time(white)
    assert np.mean(variances) == pytest.approx(1.0, abs=0.02)
    assert np.all(np.abs(variances - 1) < 5 * np.sqrt(2 / effective))
    assert np.all(np.abs(white.mean(axis=(0, 1))) < 5 / np.sqrt(effective))


@pytest.mark.parametrize("kind", ["independence", "differential evolution", "both"])
def test_a_banana_keeps_its_moments(kind):
    target = StudentT(np.zeros(2), np.diag([1.0, np.sqrt(1 + 2 * BEND**2)]))
    chosen = {"independence": [(IndependenceMove(target), 1.0)], "differential evolution": [(DEMove(), 1.0)]}
    start = np.random.default_rng(2).standard_normal((64, 2))
    x = draw(banana, start, chosen.get(kind, moves(target)), 6000).reshape(-1, 2)
    assert x.mean(axis=0) == pytest.approx([0, 0], abs=0.04)
    assert x.var(axis=0) == pytest.approx([1.0, 1 + 2 * BEND**2], rel=0.03)
    # The third moment that a straight Gaussian does not have: E[x₁² x₂] = 2 b.
    assert np.mean(x[:, 0] ** 2 * x[:, 1]) == pytest.approx(2 * BEND, rel=0.06)


def test_a_proposal_follows_a_banana_into_its_tails():
    """Weights of draws against x₂ = b x₁² + noise, four times as bent as it is wide, in a turned frame."""
    random = np.random.default_rng(6)
    turn, _ = np.linalg.qr(random.standard_normal((3, 3)))
    widths = np.array([5.0, 0.5, 1.0])

    def log_density(x: np.ndarray) -> np.ndarray:
        u = x @ turn
        u[:, 1] -= 0.08 * (u[:, 0] ** 2 - widths[0] ** 2)
        return stats.norm.logpdf(u, scale=widths).sum(axis=1)

    draws = random.standard_normal((2000, 3)) * widths
    draws[:, 1] += 0.08 * (draws[:, 0] ** 2 - widths[0] ** 2)
    efficiency = {}
    for fitted in (fit_bent, fit_mixture):
        target = fitted(draws @ turn.T)
        x = target.draw(random, 20_000)
        weights = np.exp(log_density(x) - target.log_density(x))
        efficiency[fitted] = np.mean(weights) ** 2 / np.mean(weights**2)
        assert np.mean(weights) == pytest.approx(1.0, abs=5 * np.std(weights) / np.sqrt(len(x)))
    assert efficiency[fit_bent] > 0.75 > efficiency[fit_mixture]
