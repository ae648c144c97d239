"""The likelihood of coloured and doubtful noise, against SciPy's multivariate distributions."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy import stats
from scipy.linalg import toeplitz

from ident.posterior.noise_model import log_likelihood, precision, record_noise, whiten
from tests.posterior.records import record

N = 40


def loglik(trace, residual: np.ndarray, sigma="known") -> float:
    noise = record_noise(trace, sigma)
    white = whiten(noise, residual / trace.noise.sigma)
    return float(log_likelihood(noise, np.sum(white**2)))


@pytest.fixture(scope="module")
def trace():
    full = record(1, samples=N)
    return replace(full, noise=replace(full.noise, sigma=0.3))


def test_white_noise_is_gaussian(trace):
    r = np.random.default_rng(0).normal(0, 0.3, N)
    assert loglik(trace, r) == pytest.approx(stats.norm.logpdf(r, 0, 0.3).sum())


def test_coloured_noise_is_the_gaussian_given_its_first_samples(trace):
    ar = (0.7, -0.2)
    coloured = replace(trace, noise=replace(trace.noise, ar=ar))
    rho = [1.0, ar[0] / (1 - ar[1])]
    for _ in range(N - 2):
        rho.append(ar[0] * rho[-1] + ar[1] * rho[-2])
    covariance = 0.09 * toeplitz(rho)
    r = np.random.default_rng(1).multivariate_normal(np.zeros(N), covariance)
    whole = stats.multivariate_normal(np.zeros(N), covariance).logpdf(r)
    first = stats.multivariate_normal(np.zeros(2), covariance[:2, :2]).logpdf(r[:2])
    assert loglik(coloured, r) == pytest.approx(whole - first)


def test_a_doubtful_floor_is_a_student_t_and_a_precise_one_the_gaussian(trace):
    r = np.random.default_rng(2).normal(0, 0.3, N)
    doubtful = replace(trace, noise=replace(trace.noise, relative_error=0.2))
    nu = 1 / (2 * 0.2**2)
    exact = stats.multivariate_t(np.zeros(N), 0.09 * np.eye(N), df=nu).logpdf(r)
    assert loglik(doubtful, r) == pytest.approx(exact)
    sharp = replace(trace, noise=replace(trace.noise, relative_error=1e-4))
    assert loglik(sharp, r) == pytest.approx(loglik(trace, r), abs=1e-3)


def test_with_scaled_error_bars_a_wrong_floor_costs_nothing_but_its_size(trace):
    """Twice the floor: what counts is how the residuals compare with one another."""
    r = np.random.default_rng(3).normal(0, 0.6, N)
    gain = [loglik(trace, r, s) - loglik(trace, 1.1 * r, s) for s in ("known", "scaled")]
    assert gain[0] > 3 * gain[1]
    noise = record_noise(trace, "scaled")
    chi2 = float(np.sum((r / 0.3) ** 2))
    assert precision(noise, chi2) == pytest.approx((1 + N) / (1 + chi2))
