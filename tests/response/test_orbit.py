"""The periodic orbit against what a motion comes to that is left to itself, for every effect whose laws stand still.

The drive is no sine, and its period no whole number of samples.
"""

from __future__ import annotations

import numpy as np
import pytest

from ident.campaign.device import Oscillator
from ident.effects.dependence import runs_by_a_clock
from ident.effects.effect import AbstractEffect, amplitude
from ident.effects.registry import built_in
from ident.model import Model
from ident.response import Equation, respond
from ident.response.lane import Lane
from ident.response.orbit import Orbit, find_orbit, prelude_of
from ident.response.tape import Tape, lay
from tests.effects.harness import GAIN, STIFFNESS

FREQUENCY, QUALITY, HERTZ, STEP, SIZE = 500.0, 12.0, 430.0, 1.0 / 50_000, 6e-6
OMEGA = 2 * np.pi * HERTZ
FORCE = STIFFNESS * SIZE


class Relaxing(AbstractEffect):
    """Of a user: a spring that gives way."""

    name = "relaxing"
    equation = "F = −c (z − q), q' = (z − q)/T"
    hidden_units = ("m",)
    c = amplitude("N/m", "stiffness")

    def force(self, state, drive, t):
        return -self.c * (state.z - state.hidden[0])

    def state0(self):
        return (0.0,)

    def rate(self, state, drive, t):
        return ((state.z - state.hidden[0]) / 1e-3,)


SOME = {
    "cubic-stiffness": {"k3": 0.3 * FORCE / SIZE**3},
    "coulomb-friction": {"friction": 0.05 * FORCE},
    "end-stop": {"above": 2 * STIFFNESS, "gap": 0.6 * SIZE, "exponent": 1.2},
    "electrostriction": {"share": 0.05},
    "sensor-nonlinearity": {"quadratic": 2e3, "saturation": 0.02},
    "sensor-lag": {"time": 5e-5},
    "viscoelastic-support": {"stiffness": 0.2 * STIFFNESS, "time": 5e-4, "spread": 2.0},
    "bouc-wen": {"friction": 0.1 * FORCE, "travel": 0.4 * SIZE},
    "second-mode": {"travel": 0.02, "period": 7e-4},
    "drive-lag": {"time": 1e-4},
    "bouc-wen-drive": {"loop": 0.4, "travel": 1.0},
    "prandtl-ishlinskii": {"weight": 0.3, "tilt": 0.1, "reach": 4.0},
}


def effect(name: str) -> AbstractEffect:
    if name == "relaxing":
        return Relaxing(Oscillator(), c=0.3 * STIFFNESS)
    kind = built_in()[name]
    return kind(Oscillator(), **SOME[name])


def driven(periods: float) -> Lane:
    time = 0.5 * STEP * np.arange(2 * int(periods / HERTZ / STEP) + 1)
    voltage = 0.5 + 5.0 * np.cos(OMEGA * time + 0.7) + 2.0 * np.sin(2 * OMEGA * time)
    rate = OMEGA * (-5.0 * np.sin(OMEGA * time + 0.7) + 4.0 * np.cos(2 * OMEGA * time))
    return Lane(STEP, voltage, rate, OMEGA, moving=1.0)


def made(name: str) -> tuple[Equation, np.ndarray, Tape, np.ndarray]:
    acting = effect(name)
    equation = Equation(Model(Oscillator(), (acting,)))
    values = np.array([FREQUENCY, QUALITY, GAIN, *acting.values.values()])
    unit = np.concatenate([[SIZE, SIZE * OMEGA], np.where(np.array(equation.history_units) == "m", SIZE, 1.0)])
    return equation, values, prelude_of(driven(3), 1 / HERTZ), unit


def at(name: str, values: np.ndarray | None = None, directions: np.ndarray | None = None) -> Orbit:
    equation, usual, prelude, unit = made(name)
    values = usual if values is None else values
    along = np.zeros((0, len(values))) if directions is None else directions
    first = find_orbit(equation, prelude, values, along, np.zeros(len(unit)), unit)
    again = find_orbit(equation, prelude, values, along, first.start, unit)  # Newton's last step once more
    assert first.stable and again.stable
    assert np.max(np.abs(again.start - first.start) / unit) < 1e-5
    return again


NAMES = [*SOME, "relaxing"]


@pytest.mark.parametrize("name", NAMES)
def test_a_motion_left_to_itself_comes_to_the_orbit(name: str) -> None:
    equation, values, _, _ = made(name)
    orbit = at(name)
    periods, samples = 150, round(3 / HERTZ / STEP)
    short = respond(equation, lay([driven(3)], [1]), values, orbit.start[None]).readings[:samples]
    long = respond(equation, lay([driven(periods + 3)], [1]), values, np.zeros((1, len(orbit.start)))).readings
    # Samples do not meet the same phases again: the long motion is read between its samples.
    from scipy.interpolate import CubicSpline

    later = CubicSpline(STEP * np.arange(len(long)), long)(periods / HERTZ + STEP * np.arange(samples))
    assert np.max(np.abs(short - later)) < 3e-4 * np.ptp(later)


@pytest.mark.parametrize("name", NAMES)
def test_its_derivatives_are_those_of_differences(name: str) -> None:
    _, values, _, unit = made(name)
    directions = np.diag(np.where(values == 0, 1.0, values))
    slopes = at(name, directions=directions).slopes
    for way, slope in zip(directions, slopes, strict=True):
        up, down = (at(name, values + side * way).start for side in (1e-5, -1e-5))
        change = (up - down) / 2e-5
        assert np.max(np.abs(slope - change) / unit) < 2e-3 * max(np.max(np.abs(change) / unit), 1e-2)


def test_an_orbit_to_which_nothing_comes_back_is_not_stable() -> None:
    """Of the three motions of a Duffing oscillator beyond its fold, the middle one."""
    kind = built_in()["cubic-stiffness"]
    equation = Equation(Model(Oscillator(), (kind(Oscillator()),)))
    values = np.array([FREQUENCY, 20.0, GAIN, 1.2 * STIFFNESS / SIZE**2, 0.0])
    time = 0.5 * STEP * np.arange(2 * int(3 / 560.0 / STEP) + 1)
    omega = 2 * np.pi * 560.0
    lane = Lane(STEP, 1.5 * np.cos(omega * time), -1.5 * omega * np.sin(omega * time), omega)
    prelude, unit = prelude_of(lane, 1 / 560.0), SIZE * np.array([1.0, omega])
    found: list[Orbit] = []
    for a in np.linspace(-1, 1, 13):
        for b in np.linspace(-1, 1, 13):
            one = find_orbit(equation, prelude, values, np.zeros((0, 5)), unit * np.array([a, b]), unit)
            if one.found and all(np.max(np.abs(one.start - other.start) / unit) > 1e-3 for other in found):
                found.append(one)
    assert sorted(orbit.stable for orbit in found) == [False, True, True]


@pytest.mark.parametrize("name", sorted(built_in()))
def test_effects_that_change_with_time_are_known(name: str) -> None:
    kind = built_in()[name]
    one = kind()
    if kind.needs:
        one = one.beside(built_in()[kind.needs]())
    assert runs_by_a_clock(one) == (name in {"creep", "damping-drift", "sensor-drift", "stiffness-drift"})
