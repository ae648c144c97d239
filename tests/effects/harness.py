"""Every effect against an independent solution: the package's own simulation, and SciPy with the formula written anew.

The device is an oscillator of unit mass at 500 Hz with Q = 20, driven from rest by two tones; z is some µm, as on the
platform. `measured` runs the package; `reference` integrates what the test says about the same physics.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.integrate import solve_ivp

from ident.campaign.device import Oscillator
from ident.effects.effect import AbstractEffect
from ident.effects.registry import built_in
from ident.model import Model
from ident.response import Equation, respond
from ident.response.lane import Lane
from ident.response.tape import lay

FREQUENCY, QUALITY, GAIN = 500.0, 20.0, 2.0
OMEGA0 = 2 * np.pi * FREQUENCY
STIFFNESS, DAMPING = OMEGA0**2, OMEGA0 / QUALITY
DURATION, SAMPLES = 0.016, 800
TIME = np.linspace(0.0, DURATION, SAMPLES + 1)
TONES = ((5.0, 2 * np.pi * 430.0, 0.0), (2.0, 2 * np.pi * 910.0, 0.4))
OFFSET = -2.0 * np.sin(0.4)  # the drive starts at zero volts


def voltage(t):
    """The drive, V: two tones from zero."""
    return OFFSET + sum(a * np.sin(w * t + phase) for a, w, phase in TONES)


def voltage_rate(t):
    """Its time derivative, V/s."""
    return sum(a * w * np.cos(w * t + phase) for a, w, phase in TONES)


def make(name: str, settings: dict[str, str] | None = None, **values: float) -> AbstractEffect:
    """A library effect for the oscillator."""
    return built_in()[name](Oscillator(), settings, **values)


def measured(*effects: AbstractEffect, substeps: int = 1) -> np.ndarray:
    """Reading at TIME by the package, `substeps` Runge-Kutta steps per sample, (n,) m; what an effect builds on stands
    beside it, switched off."""
    below = [effect.needs for effect in effects if effect.needs]
    for name in below:
        below += [built_in()[name].needs] if built_in()[name].needs else []
    model = Model(Oscillator(), (*(make(name) for name in reversed(below)), *effects))
    half = np.linspace(0.0, DURATION, 2 * SAMPLES * substeps + 1)
    lane = Lane(DURATION / (SAMPLES * substeps), voltage(half), voltage_rate(half), TONES[0][1])
    own = [value for effect in model.effects for value in effect.values.values()]
    values = np.array([FREQUENCY, QUALITY, GAIN, *own])
    return respond(Equation(model), lay([lane], [substeps]), values, np.zeros((1, 2))).readings


@dataclass(frozen=True)
class Physics:
    """What a test says: every function takes (t, z, v, hidden) and returns N, the hidden rates, or m."""

    force: Callable[..., float] = lambda t, z, v, h: 0.0
    rates: Callable[..., Sequence[float]] = lambda t, z, v, h: ()
    sensor: Callable[..., np.ndarray | float] = lambda t, z, v, h: 0.0
    start: tuple[float, ...] = ()


def reference(physics: Physics) -> np.ndarray:
    """Reading at TIME by SciPy's DOP853, (n,) m."""

    def rate(t, y):
        z, v, *h = y
        force = GAIN * voltage(t) - DAMPING * v - STIFFNESS * z + physics.force(t, z, v, h)
        return [v, force, *physics.rates(t, z, v, h)]

    start = [0.0, 0.0, *physics.start]
    found = solve_ivp(rate, (0.0, DURATION), start, "DOP853", TIME, rtol=1e-9, atol=1e-14, max_step=DURATION / 800)
    z, v, *h = found.y
    return z + physics.sensor(TIME, z, v, h)


def assert_agrees(effect: AbstractEffect, physics: Physics, accuracy: float, substeps: int = 4) -> None:
    """The package's reading is within `accuracy` of the reference, as a share of what the effect changes in it."""
    plain, truth = reference(Physics()), reference(physics)
    change = np.max(np.abs(truth - plain))
    assert change > 1e-3 * np.max(np.abs(plain)), "the effect is too small to be tested"
    error = np.max(np.abs(measured(effect, substeps=substeps) - truth)) / change
    assert error < accuracy, f"{effect.name}: {error:.1e} of the effect's own size"
