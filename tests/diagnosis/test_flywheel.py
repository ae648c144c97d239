"""A flywheel whose speed is read, and a brake on it that fades: no spring calls it back, however slowly it turns."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import ident
from ident.campaign import Channel, NoiseFloor, Trace
from ident.campaign.campaign import Campaign
from ident.campaign.device import Oscillator
from ident.diagnosis.diagnose import discover
from ident.diagnosis.linearised.regression import prepare
from ident.diagnosis.unknown.coordinates import set_stage
from ident.diagnosis.unknown.find import find_unknown
from ident.fit import Fit

GAIN, LOSS, BRAKE, CRITICAL = 25.0, 0.29, 2.46, 42.0  # rad/s² per A, 1/s, 1/s, rad/s
AMPERE, SPEED = Channel("A", 1.0), Channel("rad/s", 1.0)
NOISE = 0.15


def speed(drive, t: np.ndarray) -> np.ndarray:
    brake = lambda v: v * (LOSS + BRAKE / (1.0 + (v / CRITICAL) ** 2))
    rate = lambda at, y: (GAIN * float(drive(at)) - brake(y[0]),)
    return solve_ivp(rate, (0, t[-1]), (0.0,), "LSODA", t, rtol=1e-9, atol=1e-9, max_step=0.02).y[0]


def pulses(*levels: float):
    """A few seconds at each level, reached within a tenth of a second."""
    at = lambda t, k: 0.5 * (1.0 + np.tanh((t - 4.0 * k - 0.5) / 0.05))
    steps = np.diff([0.0, *levels])
    return lambda t: sum(step * at(t, k) for k, step in enumerate(steps))


DRIVES = (
    pulses(1.0, 3.0, 0.0, -1.5, -2.8),
    pulses(3.1, 0.0, 2.0, 0.0, 0.0),
    lambda t: 0.7 * np.tanh(t) + 0.8 * np.sin(1.9 * t) + 0.6 * np.sin(5.1 * t + 1.0),
    lambda t: 1.6 * np.sin(0.7 * t) * np.tanh(t),
)


@pytest.fixture(scope="module")
def records() -> tuple[Trace, ...]:
    rng, found = np.random.default_rng(7), []
    for k, drive in enumerate(DRIVES):
        t = np.arange(2000) / 100.0
        read = speed(drive, t) + NOISE * rng.normal(size=len(t))
        told = np.array([float(drive(at)) for at in t])
        found.append(Trace(f"run{k}", t, told, read, AMPERE, SPEED, NoiseFloor(NOISE), start="rest",
                           measures="velocity"))  # fmt: skip
    return tuple(found)


@pytest.fixture(scope="module")
def linear(records: tuple[Trace, ...]) -> Fit:
    return ident.fit(Campaign("flywheel", records, Oscillator("rad", "A"), linear="no-spring"), effects=())


def test_its_speed_is_the_one_that_was_read(linear: Fit) -> None:
    """What was slower than a few periods of a resonance that it has not was taken out of it, three rad/s of mean."""
    assert linear.fitted.error_over_noise > 10
    for place, drive in zip(set_stage(prepare(linear)).moved, DRIVES, strict=True):
        true = speed(drive, place["t"][0])  # on samples and between them
        assert np.sqrt(np.mean((place["v"][0] - true) ** 2)) < NOISE
        assert abs(np.mean(place["v"][0] - true)) < 0.2 * NOISE


def test_what_it_lacks_depends_on_the_speed_alone(linear: Fit) -> None:
    found = find_unknown(prepare(linear))
    assert (found.side, found.coordinates) == ("force", ("v",))
    assert found.share > 0.999 and found.chi2_after < 1.3


def test_the_brake_is_named(linear: Fit) -> None:
    found = discover(linear.campaign)
    assert [step.added for step in found.discovery.steps] == ["eddy-current-brake"]
    assert found.final.fitted.error_over_noise < 1.05
    assert found.final.value("eddy-current-brake.damping") == pytest.approx(BRAKE, rel=0.01)
    assert found.final.value("eddy-current-brake.critical") == pytest.approx(CRITICAL, rel=0.01)
