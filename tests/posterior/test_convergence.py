"""Autocorrelation time and R̂ on chains whose answers are known."""

from __future__ import annotations

import numpy as np
import pytest

from ident.posterior.convergence import autocorrelation_time, judge, rank_rhat


def autoregressive(memory: float, shape: tuple[int, int, int], seed: int = 0) -> np.ndarray:
    random = np.random.default_rng(seed)
    x = np.empty(shape)
    x[0] = random.standard_normal(shape[1:])
    for k in range(1, shape[0]):
        x[k] = memory * x[k - 1] + np.sqrt(1 - memory**2) * random.standard_normal(shape[1:])
    return x


@pytest.mark.parametrize("memory", [0.0, 0.5, 0.9])
def test_time_of_an_autoregression_is_the_known_one(memory):
    found = autocorrelation_time(autoregressive(memory, (4000, 32, 2)))
    assert found == pytest.approx(np.full(2, (1 + memory) / (1 - memory)), rel=0.1)


def test_ensembles_that_agree_are_mixed_and_one_apart_is_seen_in_place_and_in_width():
    x = np.random.default_rng(1).standard_normal((4, 4000))
    assert rank_rhat(x) < 1.005
    assert rank_rhat(x + np.array([0.5, 0, 0, 0])[:, None]) > 1.02
    assert rank_rhat(x * np.array([2.0, 1, 1, 1])[:, None]) > 1.02
    # Of a Cauchy distribution means and variances do not exist; ranks do.
    assert rank_rhat(np.random.default_rng(2).standard_cauchy((4, 4000))) < 1.01


def test_a_chain_is_final_only_when_long_stable_and_mixed():
    chains = np.stack([autoregressive(0.5, (400, 32, 2), seed) for seed in range(4)])
    early = judge(chains[:, :100], ())
    assert any("autocorrelation times" in reason for reason in early.reasons)
    assert any("still changes" in reason for reason in early.reasons)
    tau = float(judge(chains, ()).tau.max())
    final = judge(chains, (tau, tau))
    assert final.reasons == () and final.ess.min() > 10_000
    apart = chains + np.array([1.0, 0, 0, 0])[:, None, None, None]
    assert any("disagree" in reason for reason in judge(apart, (tau, tau)).reasons)
    # Four ensembles with a standard error of sd/√ESS: their means scatter by no more than that says.
    assert np.abs(chains.mean(axis=(0, 1, 2))).max() < 5 * final.error.max()
