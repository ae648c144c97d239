"""A carriage that sticks between its moves: neither its velocity nor its derivatives tremble."""

from __future__ import annotations

import numpy as np
from scipy.integrate import solve_ivp

from ident.campaign.campaign import Campaign
from ident.campaign.device import Oscillator
from ident.campaign.record import Channel, NoiseFloor, Trace
from ident.diagnosis.linearised.regression import prepare
from ident.effects.library.stribeck_friction import StribeckFriction
from ident.effects.registry import built_in
from ident.fit import fit
from ident.model import Model
from ident.response import Equation, respond
from ident.response.lane import Lane
from ident.response.tape import lay

ONE = Channel("V", 1.0)
BREAK, KEPT, FALL, DRAG, GAIN = 2.2, 0.7, 0.03, 4.9, 0.12  # m/s², share, m/s, 1/s, m/(N s²)
STEP, NOISE = 2e-3, 2e-4


def pushed(t: np.ndarray | float) -> np.ndarray | float:
    """A force (N) that lets go for a while after every move."""
    return 26.0 * np.sin(2 * np.pi * 1.1 * t) * np.clip(3 * np.sin(2 * np.pi * 0.31 * t), -1, 1)


def carriage() -> Trace:
    """Its velocity, m/s, by an event at every standstill: it sticks while the push is too small."""
    t = STEP * np.arange(4000)
    v, at, sign, now = np.zeros(len(t)), 0.0, 0.0, 0.0
    while at < t[-1]:
        if sign == 0.0:  # at rest, until the push is enough
            fine = np.arange(at, t[-1] + 1e-5, 1e-5)
            loose = np.flatnonzero(np.abs(GAIN * pushed(fine)) > BREAK)
            if not len(loose):
                break
            at, now = float(fine[loose[0]]), 0.0
            sign = float(np.sign(pushed(at)))
        law = lambda s, y, sign=sign: [
            GAIN * pushed(s) - DRAG * y[0] - sign * BREAK * (KEPT + (1 - KEPT) * np.exp(-((y[0] / FALL) ** 2)))
        ]
        stops = lambda s, y, sign=sign, begun=at: sign * y[0] if s > begun + 1e-4 else 1.0
        stops.terminal, stops.direction = True, -1
        found = solve_ivp(law, (at, t[-1]), [now + sign * 1e-9], "DOP853", rtol=1e-9, atol=1e-12, events=stops,
                          dense_output=True, max_step=1e-3)  # fmt: skip
        own = (t >= at) & (t <= found.t[-1])
        v[own] = found.sol(t[own])[0]
        at, now = float(found.t[-1]), 0.0
        sign = 0.0 if abs(GAIN * pushed(at)) <= BREAK else float(np.sign(pushed(at)))
    noisy = v + NOISE * np.random.default_rng(3).standard_normal(len(t))
    return Trace("axis", t, np.asarray(pushed(t)), noisy, ONE, ONE, NoiseFloor(NOISE), "rest", measures="velocity")


def test_the_law_is_found_with_error_bars_and_can_be_looked_at_for_more():
    record = carriage()
    assert np.mean(np.abs(record.response) < 5 * NOISE) > 0.2  # it does stick
    campaign = Campaign("axis", (record,), Oscillator("V", "V"), linear="no-spring")
    start = [1.0, 1 / DRAG, GAIN, 2.0, 0.6, 0.04, 1e-3]
    model = Model(campaign.device, form="no-spring") + StribeckFriction()
    found = fit(model, campaign, initial=np.array(start))
    assert found.fitted.error_over_noise < 1.2
    for name, true in {"friction": BREAK, "sliding": KEPT, "fall": FALL}.items():
        estimate = found[f"stribeck-friction.{name}"]
        assert estimate.standard_error is not None and 1e-6 < estimate.standard_error / true < 0.01
        assert abs(estimate.value / true - 1) < 0.02
    assert np.all(np.isfinite(prepare(found).absorbed))


def test_derivatives_stay_finite_where_friction_sticks_and_no_step_is_divided():
    """Lanes of sweeps allow any miss at a kink; where explicit steps are not stable they are not taken all the same."""
    step, n = 1 / (500.0 * 250), 2000
    drive = 2 * np.pi * 200.0
    half = np.arange(2 * n + 1) * step / 2
    lane = Lane(step, 5 * np.cos(drive * half), -5 * drive * np.sin(drive * half), drive, moving=1.0, sine=1.0)
    model = Model(Oscillator(), (built_in()["coulomb-friction"](Oscillator()),))
    values = np.array([500.0, 20.0, 2.0, 6.0, 1e-5])
    found = respond(
        Equation(model), lay([lane], [1]), values, np.zeros((1, 2)), np.diag(values), np.zeros((5, 1, 2))
    )  # fmt: skip
    apart = np.stack([readings(model, lane, values * (1 + 1e-4 * sign * np.eye(5)[3])) for sign in (1, -1)])
    by_friction = (apart[0] - apart[1]) / 2e-4
    assert np.max(np.abs(found.slopes[3] - by_friction)) < 0.05 * np.max(np.abs(by_friction))


def readings(model: Model, lane: Lane, values: np.ndarray) -> np.ndarray:
    return respond(Equation(model), lay([lane], [1]), values, np.zeros((1, 2))).readings


def test_what_stands_for_seconds_does_not_creep_and_a_step_over_standstill_ends_at_balance():
    """A block on a spring is let go beside the place where friction holds it: it moves once, and stands."""
    step, n = 0.01, 1500
    still = np.zeros(2 * n + 1)
    lane = Lane(step, still, still, 0.0, moving=1.0, allowed=1e-6)
    model = Model(Oscillator(), (built_in()["coulomb-friction"](Oscillator()),))
    w, friction = 2 * np.pi * 1.0, 0.7 * (2 * np.pi * 1.0) ** 2  # holds within 0.7 m of the rest of the spring
    mass = float(Equation(model).constants[0])
    values, start = np.array([1.0, 1e6, 0.0, friction * mass, 1e-6]), np.array([[1.0, 0.0]])
    z = respond(Equation(model), lay([lane], [1]), values, start).z
    half_period = int(round(np.pi / w / step))
    np.testing.assert_allclose(z[half_period + 2 :], 0.4, atol=1e-3)  # swings about 0.7 from 1.0 to 0.4
    assert abs(z[-1] - z[half_period + 2]) < 1e-4
