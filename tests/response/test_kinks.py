"""Steps that meet a kink are divided: against SciPy, which goes from kink to kink."""

import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from ident.campaign.device import Oscillator
from ident.campaign.record import Channel, NoiseFloor, Trace
from ident.effects.registry import built_in
from ident.model import COARSE, Model
from ident.response import Equation, divided, lay_out, respond

OMEGA, QUALITY, DRIVE = 2 * np.pi * 10.0, 30.0, 40.0
VALUES = {"oscillator.frequency": 10.0, "oscillator.quality": QUALITY, "oscillator.gain": 1.0}
FRICTION = {"coulomb-friction.friction": 9.0, "coulomb-friction.velocity": 3e-4}
STOP = {"end-stop.above": 50 * OMEGA**2, "end-stop.below": 0.0, "end-stop.gap": 0.1,
        "end-stop.exponent": 1.0, "end-stop.asymmetry": 1.0}  # fmt: skip


def record(sigma: float, measures: str = "displacement") -> Trace:
    time = np.arange(2401) / 400.0  # 40 samples in a period of the resonance
    drive, channel = DRIVE * np.sin(0.93 * OMEGA * time), Channel("V", 1.0)
    return Trace("sine.csv", time, drive, 0.3 * drive / DRIVE, channel, channel, noise=NoiseFloor(sigma), start="rest",
                 measures=measures)  # fmt: skip


def model(effect: str) -> tuple[Model, np.ndarray]:
    found = Model(Oscillator(), (built_in()[effect](),))
    return found, np.array([(VALUES | FRICTION | STOP)[p.name] for p in found.parameters])


def exact(force, switch, time: np.ndarray, begun: float = 0.0) -> np.ndarray:
    """Displacement, zero until `begun`, under a force of (z, v, side) that changes its side where `switch` of (z, v) is
    zero."""
    side, y, found = 0, np.zeros(2), np.zeros_like(time)

    def rates(t, y, side):
        pushed = DRIVE * math.sin(0.93 * OMEGA * t) + force(*y, side)
        return y[1], pushed - OMEGA / QUALITY * y[1] - OMEGA**2 * y[0]

    def met(t, y, side):
        return switch(*y) if t > begun + 1e-9 else switch(*(y + 1e-9 * np.array(rates(t, y, side))))

    met.terminal = True
    while begun < time[-1]:
        ahead = y + 1e-9 * np.array(rates(begun, y, side))
        side = 1 if switch(*ahead) > 0 else -1
        there = time[(time >= begun) & (time <= time[-1])]
        run = solve_ivp(rates, (begun, time[-1]), y, args=(side,), events=met, method="DOP853", rtol=1e-11, atol=1e-14,
                        dense_output=True)  # fmt: skip
        inside = there[there <= run.t[-1]]
        found[np.isin(time, inside)] = run.sol(inside)[0]
        begun, y = float(run.t[-1]), run.y[:, -1]
    return found


def friction(time: np.ndarray) -> np.ndarray:
    loose = math.asin(9.0 / DRIVE) / (0.93 * OMEGA) + 1e-6  # until then it sticks
    return exact(lambda z, v, side: -9.0 * side, lambda z, v: v, time, loose)


def stop(time: np.ndarray) -> np.ndarray:
    pushed = lambda z, v, side: -50 * OMEGA**2 * (z - 0.1) if side > 0 else 0.0
    return exact(pushed, lambda z, v: z - 0.1, time)


@pytest.mark.parametrize(("effect", "truth", "gain"), [("coulomb-friction", friction, 8), ("end-stop", stop, 3)])
def test_it_follows_a_kink_within_a_fifth_of_the_noise(effect, truth, gain):
    trace = record(1e-4)
    system, values = model(effect)
    tape = lay_out([trace], 10.0, QUALITY, system)
    found = respond(Equation(system), tape, values, np.zeros((1, 2))).readings
    wanted = truth(trace.time)
    missed = np.max(np.abs(found - wanted))
    assert missed < 0.2 * 1e-4  # the friction turns over a little velocity, not at once
    whole = divided([trace], [tape.spans[0].substeps], np.inf)
    undivided = respond(Equation(system), whole, values, np.zeros((1, 2))).readings
    assert np.max(np.abs(undivided - wanted)) > gain * missed


@pytest.mark.parametrize("effect", ["coulomb-friction", "end-stop"])
def test_no_more_steps_than_a_smooth_law_needs(effect):
    trace = record(3e-3)
    pair = Model(Oscillator()), model(effect)[0]
    plain, steps = (lay_out([trace], 10.0, QUALITY, one).spans[0].substeps for one in pair)
    assert steps == max(plain, math.ceil(COARSE / 40))


@pytest.mark.parametrize("effect", ["coulomb-friction", "end-stop"])
def test_derivatives_go_with_the_divided_steps(effect):
    trace = record(1e-4)
    system, values = model(effect)
    if effect == "coulomb-friction":
        values[4] = 0.02  # a sign that turns within a few steps has a derivative that they can follow
    tape, still = lay_out([trace], 10.0, QUALITY, system), np.zeros((1, 2))
    count = 4
    directions = 1e-3 * np.diag(values)[:count]
    slopes = respond(Equation(system), tape, values, still, directions, np.zeros((count, 1, 2))).slopes
    for along, slope in zip(directions, slopes, strict=True):
        ahead, behind = (respond(Equation(system), tape, values + s * along, still).readings for s in (1, -1))
        apart = slope - (ahead - behind) / 2
        assert np.max(np.abs(apart)) < 0.06 * np.max(np.abs(slope))


def test_a_reading_of_the_velocity_divides_by_its_own_noise():
    system, values = model("coulomb-friction")
    found = []
    for measures, sigma in (("displacement", 1e-4), ("velocity", 1e-4 * OMEGA)):
        trace = record(sigma, measures)
        tape = lay_out([trace], 10.0, QUALITY, system)
        found.append(respond(Equation(system), tape, values, np.zeros((1, 2))).z)
    np.testing.assert_allclose(found[0], found[1], atol=3e-5)
