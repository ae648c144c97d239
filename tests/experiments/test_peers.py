"""The peers solve the same problem as the simulator, or a ratio against them would mean nothing."""

import numpy as np
import pytest

from experiments import make_campaigns as campaigns
from experiments.benchmarks import peers
from experiments.simulator.signals import sine
from experiments.simulator.stage import simulate
from experiments.simulator.stiffness import segment_stiffness

SAMPLES = 2000
STEP = 1 / (80 * 317)
THETA = np.array([getattr(campaigns.PAPER, name) for name in peers.NAMES])
REFERENCE = 2 * np.pi * 317


@pytest.fixture(scope="module")
def drive() -> tuple[np.ndarray, np.ndarray]:
    fine = np.arange(2 * (SAMPLES - 1) + 1) * (STEP / 2)
    return sine(8, 317).value(fine), sine(8, 317).rate(fine)


@pytest.fixture(scope="module")
def exact() -> np.ndarray:
    return simulate(campaigns.PAPER, sine(8, 317), np.arange(SAMPLES) * STEP)[0]


def test_numba_peer_agrees_with_the_simulator(drive, exact) -> None:
    z = peers.simulate(THETA, *drive, REFERENCE, STEP, 1, np.empty(SAMPLES))
    assert np.max(np.abs(z - exact)) < 1e-4 * np.std(exact)  # one step per sample: a hundredth of the noise


@pytest.mark.parametrize("x", [-9.9e-4, -1.1e-3, 2e-3, 5.0, -4.0])
def test_stiffness_of_the_peers(x: float) -> None:
    numerator, denominator = peers._fraction(x / 4, 0.4)
    assert 4 * numerator / denominator == pytest.approx(segment_stiffness(x, 0.4), rel=1e-12)
    assert peers._closed_form(x, 0.4) == pytest.approx(segment_stiffness(x, 0.4), rel=1e-9)


def test_adaptive_peer_agrees_with_the_simulator(drive, exact) -> None:
    z = peers.simulate_adaptive(THETA, *drive, REFERENCE, STEP, 1, 500, rtol=1e-9)
    assert np.max(np.abs(z - exact[:500])) < 1e-5 * np.std(exact)


def test_numba_fit_comes_back_to_the_truth() -> None:
    """At 9 V beside resonance the large motion tells the stress from the restraint; at 8 V, 317 Hz it does not."""
    drive, step, reference = sine(9, 510), 1 / (80 * 510), 2 * np.pi * 510
    fine = np.arange(2 * (SAMPLES - 1) + 1) * (step / 2)
    z = simulate(campaigns.PAPER, drive, np.arange(SAMPLES) * step)[0]
    noisy = z + 30e-9 * np.random.default_rng(1).standard_normal(SAMPLES)
    start = THETA * np.array([1.005, 0.9, 1.1, 0.8, 1.2, 0.9, 0.8, 1.2])
    found = peers.fit_numba(start, drive.value(fine), drive.rate(fine), reference, step, 1, noisy, 30e-9)
    assert 2 * found.cost / SAMPLES == pytest.approx(1.0, abs=0.1)
    np.testing.assert_allclose(found.x * peers.SCALE / THETA, 1, rtol=0, atol=0.1)
