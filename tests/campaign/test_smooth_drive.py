"""A band-limited drive is met between its samples, also in the first intervals of a record."""

from __future__ import annotations

import numpy as np
import pytest

from ident.campaign.smooth_drive import smooth_drive
from ident.fit.linear.stretches import _dense

N = 300
INSIDE, FIRST = np.linspace(100.0, 200.0, 1001), np.linspace(0.0, 3.0, 31)


def noise(seed: int, highest: float):
    """A sum of sines up to so many cycles per sample, of unit rms, as a function of the place."""
    rng = np.random.default_rng(seed)
    lines, phases = rng.uniform(0, highest, 60), rng.uniform(0, 2 * np.pi, 60)
    return lambda x: np.sqrt(2 / 60) * np.sum(np.sin(2 * np.pi * np.multiply.outer(x, lines) + phases), axis=-1)


def missed(curve, truth, places) -> float:
    return float(np.sqrt(np.mean((curve(places) - truth(places)) ** 2)))


@pytest.mark.parametrize(("highest", "inside", "first"), [(0.1, 1e-6, 1e-6), (0.2, 1e-4, 1e-4), (0.3, 2e-3, 2e-3)])
@pytest.mark.parametrize("seed", range(5))
def test_noise_below_a_part_of_the_sampling_rate_is_met(seed, highest, inside, first):
    truth = noise(seed, highest)
    curve = smooth_drive(truth(np.arange(N)))
    assert missed(curve, truth, INSIDE) < inside
    assert missed(curve, truth, FIRST) < first
    assert missed(curve, truth, N - 1 - FIRST) < first


@pytest.mark.parametrize("period", [4.0, 6.0, 10.0, 40.0, 100.0])
def test_a_sine_is_met_where_the_record_begins(period):
    truth = lambda x: np.sin(2 * np.pi * x / period + 0.7)
    assert missed(smooth_drive(truth(np.arange(N))), truth, FIRST) < 5e-4


def test_what_is_constant_or_short_stays_what_it_is():
    np.testing.assert_allclose(smooth_drive(np.full(50, 3.0))(FIRST), 3.0, rtol=1e-9)
    for n in (2, 3, 5, 12):
        np.testing.assert_allclose(smooth_drive(np.full(n, 5.0))(np.linspace(0, n - 1, 7)), 5.0, rtol=1e-9)
        samples = np.sin(np.arange(n))
        np.testing.assert_allclose(smooth_drive(samples)(np.arange(n)), samples, atol=1e-9)


@pytest.mark.parametrize(("f", "parts"), [(0.1, 1), (0.2, 2), (0.3, 3)])
def test_the_linear_search_sees_the_same_curve(f, parts):
    """Its lines between denser samples have the amplitude of the curve, sharpened by what lines are low by."""
    dense, finer = _dense(np.cos(2 * np.pi * f * np.arange(N)), slice(0, N))
    assert finer == parts and len(dense) == (N - 1) * parts + 1
    inside = slice(60 * parts, -60 * parts)
    wave = np.cos(2 * np.pi * f * np.arange(len(dense)) / parts)[inside]
    amplitude = dense[inside] @ wave / (wave @ wave) * np.sinc(f / parts) ** 2
    assert amplitude == pytest.approx(1.0, abs=2e-3)


def test_a_part_of_a_drive_is_seen_as_in_the_whole_and_a_triangle_as_lines():
    drive = np.cos(1.3 * np.arange(N))
    whole, parts = _dense(drive, slice(0, N))
    part, _ = _dense(drive, slice(100, 200))
    np.testing.assert_allclose(part[parts:-parts], whole[100 * parts : 199 * parts + 1][parts:-parts], atol=1e-3)
    triangle = np.abs((np.arange(N) + 3.0) % 12 - 6)
    dense, parts = _dense(triangle, slice(0, N))
    assert parts == 1 and np.array_equal(dense, triangle)
