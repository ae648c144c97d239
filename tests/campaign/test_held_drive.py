"""Drives that jump: what the solver gets of them, and how they are told."""

from __future__ import annotations

import numpy as np
import pytest

from ident.campaign.held_drive import beside_edge, held_drive, jumps


@pytest.mark.parametrize("substeps", [1, 2, 3])
@pytest.mark.parametrize("edge", [-1.0, -0.37, 0.0, 0.2, 1.0, 1.6])
def test_an_edge_has_its_impulse_and_its_time_wherever_it_lies(substeps, edge):
    """∫V and ∫t V of one jump by Simpson's rule, as Runge-Kutta steps take them, and ∫V̇ by both rules."""
    samples = np.where(np.arange(40) < 20, 1.0, 3.0)
    voltage, slope = held_drive(samples, substeps, edge)
    at, step = np.arange(len(voltage)) / (2 * substeps), 1 / substeps
    simpson = lambda x: step / 6 * float(np.sum(x[:-1:2] + 4 * x[1::2] + x[2::2]))
    on, end = 20 + edge, 39.0
    assert simpson(slope) == pytest.approx(2.0) and np.sum(slope) * step / 2 == pytest.approx(2.0)
    assert simpson(slope * at) == pytest.approx(2.0 * on)
    assert simpson(voltage) == pytest.approx(on + 3 * (end - on))
    blurred = step**2 / 6  # second moment of the edge
    exact = (on**2 + 3 * (end**2 - on**2)) / 2
    assert abs(simpson(voltage * at) - exact) < 2 * blurred


@pytest.mark.parametrize("substeps", [1, 2, 3])
@pytest.mark.parametrize("edge", [-1.0, -0.9, -0.5, -0.2, 0.0, 0.1])
def test_what_an_edge_adds_too_early_is_known(substeps, edge):
    """At samples beside an edge ∫V, by Simpson's rule, is right once that is taken off; a velocity is such a sum."""
    voltage, slope = held_drive(np.where(np.arange(40) < 20, 1.0, 3.0), substeps, edge)
    step, at = 1 / substeps, np.arange(40)
    each = step / 6 * (voltage[:-1:2] + 4 * voltage[1::2] + voltage[2::2])
    told = np.concatenate([[0.0], np.cumsum(each)])[::substeps]
    exact = np.where(at < 20 + edge, at, 20 + edge + 3 * (at - 20 - edge))
    beside = slope[:: 2 * substeps] * step**2 * beside_edge(edge, substeps, 1)
    np.testing.assert_allclose(told + beside, exact, atol=1e-9 if edge % 1 in (0.0, 0.5) else 0.02 * 2 * step)
    assert edge % 1 > 0 or np.max(np.abs(told - exact)) == pytest.approx(2 * step / 6)


@pytest.mark.parametrize("substeps", [2, 3])
@pytest.mark.parametrize("edge", [-1.0, -0.9, -0.5, -0.2, 0.0, 0.1])
def test_a_sample_beside_an_edge_is_before_or_after_it(substeps, edge):
    voltage, slope = held_drive(np.where(np.arange(40) < 20, 1.0, 3.0), substeps, edge)
    beside = slope[:: 2 * substeps] / substeps * beside_edge(edge, substeps, 2)
    exact = np.where(np.arange(40) < 20 + edge, 1.0, 3.0)
    np.testing.assert_allclose(voltage[:: 2 * substeps] + beside, exact, atol=1e-9)


def test_a_hold_is_drawn_through_its_values():
    samples = np.random.default_rng(0).standard_normal(30)
    voltage, _ = held_drive(samples, 4, 0.0)
    np.testing.assert_allclose(voltage[4::8], samples[:-1])  # half-way between the edges


def test_what_jumps():
    k, rng = np.arange(4000), np.random.default_rng(1)
    assert jumps(np.where(k % 300 < 150, 1.0, 0.0)) and jumps(rng.standard_normal(4000))
    assert jumps(np.repeat(np.sin(k[:500] / 7), 8))
    assert not jumps(np.sin(k / 3)) and not jumps(np.sin(k / 40) + 1e-3 * rng.standard_normal(4000))
    assert not jumps(np.zeros(100))
