"""A further mode of the start model beside an effect: one that mimics what is missing goes, one that rings stays."""

from __future__ import annotations

from functools import partial

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from ident.campaign import Channel, NoiseFloor, Trace
from ident.campaign.campaign import Campaign
from ident.campaign.device import Oscillator
from ident.diagnosis.diagnose import discover
from ident.fit.linear.start_model import start_model

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


def steps(seed: int, t: np.ndarray) -> np.ndarray:
    """A trapezoid with rounded corners, as an amplifier makes it."""
    return 2.0 * np.tanh(6.0 * np.sin(2 * np.pi * 0.8 * t))


def chirp(seed: int, t: np.ndarray) -> np.ndarray:
    return 3.0 * np.sin(2 * np.pi * (2.0 * t + 4.75 * t**2))


def tones(seed: int, t: np.ndarray, size: float = 3.0) -> np.ndarray:
    """Sines between 1 and 45 Hz, faded in."""
    phases = np.random.default_rng(seed).uniform(0, 2 * np.pi, 40)
    sines = np.sin(2 * np.pi * np.multiply.outer(t, np.linspace(1.0, 45.0, 40)) + phases).sum(axis=-1)
    return size * sines / np.sqrt(20) * np.tanh(20 * t)


def record(seed: int, drive, rates, states: int, of) -> Trace:
    """From rest, four seconds."""
    t = np.arange(2000) / 500.0
    there = lambda at, y: rates(at, y, float(drive(seed, at)))
    motion = solve_ivp(there, (0, t[-1]), np.zeros(states), "RK45", t, rtol=1e-8, atol=1e-11, max_step=0.01).y
    z = of(motion)
    noise = 0.005 * float(np.std(z))
    z = z + noise * np.random.default_rng(seed + 100).normal(size=len(t))
    return Trace(f"{seed}.csv", t, drive(seed, t), z, VOLT, METRE, NoiseFloor(noise), start="rest")


@pytest.mark.parametrize(
    ("drives", "rates", "states", "of", "named", "modes"),
    [
        ((steps, chirp, tones), relaxing, 3, lambda y: y[0], ["viscoelastic-support"], 0),
        (tuple(partial(tones, size=size) for size in (20.0, 40.0, 60.0)),
         ringing, 4, lambda y: y[0] + y[2], ["cubic-stiffness"], 1),
    ],
)  # fmt: skip
def test_a_mode_is_kept_only_where_no_effect_stands_for_it(drives, rates, states, of, named, modes):
    records = [record(seed, drive, rates, states, of) for seed, drive in enumerate(drives)]
    campaign = Campaign("stage", tuple(records), Oscillator("m", "V"))
    assert "second-mode" in start_model(campaign).names
    found = discover(campaign)
    assert [step.added for step in found.discovery.steps] == named
    assert sum(name == "second-mode" for name in found.final.model.names) == modes
