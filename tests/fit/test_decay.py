"""Free decays: what is read off them, and the fit of their models."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from ident.campaign.campaign import Campaign
from ident.campaign.device import Oscillator
from ident.campaign.record import Channel, NoiseFloor, Trace
from ident.effects.registry import built_in
from ident.fit import fit
from ident.fit.linear.decay import read_ringing
from ident.fit.linear.decay_curve import decay_curves
from ident.fit.linear.guess import guess_linear
from ident.model import Model

ONE = Channel("V", 1.0)


def decay(f: float, q: float, n: int, step: float, noise: float = 0.01) -> np.ndarray:
    """The closed form, amplitude 1, with white noise."""
    t, omega = step * np.arange(n), 2 * np.pi * f
    ringing = omega * np.sqrt(1 - 1 / (4 * q * q))
    return np.exp(-omega / (2 * q) * t) * np.cos(ringing * t + 0.7) + noise * np.random.default_rng(0).normal(size=n)


def trace(response: np.ndarray, step: float, sigma: float) -> Trace:
    t = step * np.arange(len(response))
    return Trace("decay.csv", t, np.zeros(len(t)), response, ONE, ONE, NoiseFloor(sigma), "unknown")


@pytest.mark.parametrize(
    ("f", "q", "n", "step"), [(1.24, 40, 2400, 0.033), (500, 1000, 20_000, 4e-5), (500, 30, 20_000, 4e-5)]
)
def test_frequency_and_quality_are_read_off_the_decay(f, q, n, step):
    found = read_ringing(decay(f, q, n, step), step)
    assert found is not None
    assert found.frequency == pytest.approx(f, rel=1e-3)
    assert found.quality == pytest.approx(q, rel=0.03)


def test_what_does_not_ring_has_no_line():
    assert read_ringing(decay(500, 0.6, 2000, 4e-5), 4e-5) is None


@pytest.mark.parametrize(("f", "q"), [(500.0, 2.0), (500.0, 5.0), (480.0, 400.0)])
def test_the_guess_finds_decays_of_any_quality(f, q):
    found = guess_linear([trace(decay(f, q, 4000, 4e-5, 1e-3), 4e-5, 1e-3)])
    np.testing.assert_allclose([found.frequency, found.quality], [f, q], rtol=0.01)
    assert found.gain == 0.0


def test_a_decay_is_fitted_without_a_gain_and_gives_back_its_cubic_spring():
    f, q, k3, step, sigma = 1.25, 60.0, -12.0, 0.03, 1e-3
    omega = 2 * np.pi * f
    records = []
    for seed, start in enumerate((1.0, 0.7)):
        t = step * np.arange(1200)
        pull = lambda _, y: [y[1], -omega / q * y[1] - omega**2 * y[0] - k3 * y[0] ** 3]
        clean = solve_ivp(pull, (0, t[-1]), [start, 0.0], "DOP853", t, rtol=1e-10, atol=1e-12).y[0]
        records.append(trace(clean + sigma * np.random.default_rng(seed).normal(size=len(t)), step, sigma))
    campaign = Campaign("decays", tuple(records), Oscillator())
    linear = fit(Model(Oscillator()), campaign)
    assert linear.value("oscillator.gain") == 0.0 and "held" in linear.estimates[2].flags
    assert linear.fitted.error_over_signal > 0.1
    found = fit(Model(Oscillator()) + built_in()["cubic-stiffness"](), campaign)
    assert found.fitted.error_over_noise == pytest.approx(1.0, abs=0.05)
    for name, truth in (("oscillator.frequency", f), ("oscillator.quality", q), ("cubic-stiffness.k3", k3)):
        error = next(e.standard_error for e in found.estimates if e.name == name)
        assert abs(found.value(name) - truth) < 4 * error


def test_a_linear_decay_has_one_frequency_and_one_rate_at_every_amplitude():
    response = decay(40, 80, 8000, 1e-3, 1e-4)
    seen, model = decay_curves(response, decay(41, 80, 8000, 1e-3, 0.0), 1e-3, 1e-4)
    assert len(seen.amplitude) > 10
    assert seen.amplitude[0] / seen.amplitude[-1] > 50
    assert np.allclose(seen.frequency, 40, rtol=2e-3)
    assert np.allclose(seen.rate, np.pi * 40 / 80, rtol=0.1)
    assert np.allclose(model.frequency, 41, rtol=2e-3)


def test_a_cubic_spring_shows_in_the_frequency_and_drag_in_the_rate():
    omega, cubic, drag = 2 * np.pi * 10, 0.2, 0.02
    pull = lambda t, y: [y[1], -(omega**2) * (y[0] + cubic * y[0] ** 3) - omega / 400 * y[1] - drag * abs(y[1]) * y[1]]
    t = 2e-3 * np.arange(6000)
    response = solve_ivp(pull, (0, t[-1]), [1.0, 0.0], t_eval=t, rtol=1e-9, atol=1e-11).y[0]
    seen, _ = decay_curves(response, response, 2e-3, 1e-4)
    a = seen.amplitude
    assert np.allclose(seen.frequency[1:], 10 * (1 + 3 / 8 * cubic * a[1:] ** 2), rtol=1e-3)
    assert np.allclose(seen.rate[1:], omega / 800 + 4 / (3 * np.pi) * drag * omega * a[1:], rtol=0.05)


def test_what_does_not_ring_has_no_curves():
    assert decay_curves(np.exp(-np.arange(500) / 50), np.zeros(500), 1e-3, 1e-3) == ()
