"""One criterion where noise is left and where laws differ."""

from __future__ import annotations

import numpy as np

from ident.diagnosis.evidence.criterion import Left, behind, criteria
from ident.fit.linear.independent import independent_samples

N = 20_000
NOISE = np.random.default_rng(5).normal(size=N)
SLOW = 100 * np.sqrt(2) * np.sin(2 * np.pi * 40 * np.arange(N) / N)


def test_white_noise_counts_every_sample_and_a_line_four() -> None:
    assert 0.95 * N < independent_samples(NOISE) <= N
    assert np.isclose(independent_samples(SLOW), 4.0, rtol=1e-3)


def test_at_the_noise_floor_it_is_chi2_plus_ln_n_per_number() -> None:
    simple, wide = Left(NOISE, 3), Left(NOISE * np.sqrt(1 - 300 / N), 6)
    least = float(NOISE @ NOISE) / N
    assert np.isclose(behind(simple, wide), 300 / least - 3 * np.log(N), rtol=0.05)


def test_far_above_the_floor_shape_numbers_buy_nothing() -> None:
    simple, wide = Left(SLOW + NOISE, 1), Left(0.9 * SLOW + NOISE, 4)  # a fifth less χ², millions of it
    assert behind(simple, wide) < 0
    assert behind(simple, Left(0.1 * SLOW + NOISE, 4)) > 0


def test_a_motion_without_bound_comes_last() -> None:
    assert np.argmin(criteria([Left(np.full(N, np.inf), 1), Left(SLOW, 9)])) == 1
