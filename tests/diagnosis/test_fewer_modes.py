"""A further mode of the start model beside an effect: one that mimics what is missing goes, one that rings stays."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from ident.campaign import Channel, NoiseFloor, Trace
from ident.campaign.campaign import Campaign
from ident.campaign.device import Oscillator
from ident.diagnosis.diagnose import discover

OMEGA = 2 * np.pi * 12.0
VOLT, METRE = Channel("V", 1.0), Channel("m", 1.0)


def relaxing(t: float, y: np.ndarray, push: float) -> tuple[float, ...]:
    """A mass on a Zener solid, one relaxation of 30 ms with 0.8 of the spring."""
    z, v, q = y
    return v, push - 3.8 * v - OMEGA**2 * (z + 0.8 * (z - q)), (z - q) / 0.03


def ringing(t: float, y: np.ndarray, push: float) -> tuple[float, ...]:
    """A mass on a cubic spring, and a second mode of the linear structure at 2.6 times its frequency."""
    z, v, s, w = y
    other = 2.6 * OMEGA
    return (
        v, push - OMEGA / 30 * v - OMEGA**2 * z * (1 + 8.0 * z * z),
        w, 2.0 * push - other / 60 * w - other**2 * s,
    )  # fmt: skip


def record(seed: int, size: float, rates, states: int, of) -> Trace:
    """From rest, driven by a sum of sines between 1 and 45 Hz."""
    t, rng = np.arange(2000) / 500.0, np.random.default_rng(seed)
    tones = np.linspace(1.0, 45.0, 40)
    phases = rng.uniform(0, 2 * np.pi, len(tones))
    drive = lambda at: size * np.sin(2 * np.pi * np.multiply.outer(at, tones) + phases).sum(axis=-1) / np.sqrt(20)
    rates_at = lambda at, y: rates(at, y, float(drive(at)) * np.tanh(20 * at))
    motion = solve_ivp(rates_at, (0, t[-1]), np.zeros(states), "DOP853", t, rtol=1e-9, atol=1e-12).y
    z = of(motion)
    noise = 0.005 * float(np.std(z))
    z = z + noise * rng.normal(size=len(t))
    return Trace(f"{seed}.csv", t, drive(t) * np.tanh(20 * t), z, VOLT, METRE, NoiseFloor(noise), start="rest")


@pytest.mark.parametrize(
    ("rates", "states", "of", "named", "modes"),
    [
        (relaxing, 3, lambda y: y[0], ["viscoelastic-support"], 0),
        (ringing, 4, lambda y: y[0] + y[2], ["cubic-stiffness"], 1),
    ],
)
def test_a_mode_is_kept_only_where_no_effect_stands_for_it(rates, states, of, named, modes):
    records = [record(seed, size, rates, states, of) for seed, size in enumerate((20.0, 40.0, 60.0))]
    found = discover(Campaign("stage", tuple(records), Oscillator("m", "V")))
    assert [step.added for step in found.discovery.steps] == named
    assert sum(name == "second-mode" for name in found.final.model.names) == modes
