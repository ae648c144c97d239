"""Stiffness, damping and contact: each law against SciPy with the formula written anew."""

from __future__ import annotations

import numpy as np
import pytest

from ident.effects.effect import Drive, State
from tests.effects.harness import (
    DAMPING,
    DURATION,
    GAIN,
    STIFFNESS,
    Physics,
    assert_agrees,
    make,
    measured,
    voltage,
)

K, C = STIFFNESS, DAMPING
STRING = 8e-6  # m, at which a spring levels off
SMOOTH, KINKED = 1e-5, 2e-3  # of the effect's own size, with 4 steps per sample

SMOOTH_LAWS = {
    "cubic-stiffness": (dict(k3=0.1 * K / 25e-12), lambda t, z, v, h: -0.1 * K * z * (z / 5e-6) ** 2),
    "quintic-stiffness": (dict(k5=0.1 * K / 625e-24), lambda t, z, v, h: -0.1 * K * z * (z / 5e-6) ** 4),
    "quadratic-stiffness": (dict(k2=0.1 * K / 5e-6), lambda t, z, v, h: -0.1 * K * z * z / 5e-6),
    "cogging": (
        dict(sine=0.05 * K * 5e-6, cosine=-0.02 * K * 5e-6, pitch=3e-6),
        lambda t, z, v, h: (
            -0.05 * K * 5e-6 * np.sin(2 * np.pi * z / 3e-6) + 0.04 * K * 5e-6 * np.sin(np.pi * z / 3e-6) ** 2
        ),
    ),
    "static-force": (dict(force0=0.1 * K * 5e-6), lambda t, z, v, h: 0.1 * K * 5e-6),
    "voltage-stiffness": (
        dict(per_volt=0.01 * K, per_volt2=-0.002 * K),
        lambda t, z, v, h: -K * z * (0.01 * voltage(t) - 0.002 * voltage(t) ** 2),
    ),
    "stiffness-drift": (
        dict(rate0=-0.1 * K / 0.005, time=0.005),
        lambda t, z, v, h: 0.1 * K * (1 - np.exp(-t / 0.005)) * z,
    ),
    "damping-drift": (
        dict(rate0=C / DURATION, time=1e3 * DURATION),  # so slow that it is linear in time
        lambda t, z, v, h: -C * t / DURATION * (1 - t / DURATION / 2e3) * v,
    ),
    "cubic-damping": (
        dict(c3=2 * C / 4e-4, c_z=0.5 * C / 25e-12),
        lambda t, z, v, h: -2 * C * v**3 / 4e-4 - 0.5 * C * z * z * v / 25e-12,
    ),
    "eddy-current-brake": (
        dict(damping=0.5 * C, critical=2e-2),
        lambda t, z, v, h: 0.5 * C * v - 0.5 * C * v / (1 + (v / 2e-2) ** 2),
    ),
    "squeeze-film-damping": (
        dict(damping=0.5 * C, gap=-12e-6),
        lambda t, z, v, h: -0.5 * C * v * ((1 + z / 12e-6) ** -3 - 1),
    ),
    "electrostatic-force": (
        dict(attraction=1e-3 * K * 1e-6, gap=-12e-6),
        lambda t, z, v, h: -1e-9 * K * voltage(t) ** 2 / (1 + z / 12e-6) ** 2,
    ),
}

KINKED_LAWS = {
    "bilinear-stiffness": (
        dict(stiffness=0.1 * K, width=5e-8),
        lambda t, z, v, h: -0.1 * K * (np.hypot(z, 5e-8) - 5e-8),
    ),
    "asymmetric-damping": (
        dict(damping=0.3 * C, width=2e-4),
        lambda t, z, v, h: -0.3 * C * (np.hypot(v, 2e-4) - 2e-4),
    ),
    "quadratic-damping": (dict(c2=C / 2e-2), lambda t, z, v, h: -C * v * abs(v) / 2e-2),
    "quadratic-damping in a stream": (
        dict(c2=C / 2e-2, stream=6e-3),
        lambda t, z, v, h: -C * ((v - 6e-3) * abs(v - 6e-3) + 6e-3**2) / 2e-2,
    ),
    "power-law-stiffness": (
        dict(stiffness=0.1 * K, exponent=2.2, displacement=5e-6),
        lambda t, z, v, h: -0.1 * K * z * (abs(z / 5e-6) ** 1.2 - 1) / 1.2,
    ),
    "power-law-damping": (
        dict(damping=0.4 * C, exponent=1.4, velocity=2e-2),
        lambda t, z, v, h: -C * v * (abs(v / 2e-2) ** 0.4 - 1),
    ),
    "stribeck-friction": (
        dict(friction=0.2 * C * 2e-2, sliding=0.4, fall=4e-3, velocity=2e-3),
        lambda t, z, v, h: -0.2 * C * 2e-2 * (0.4 + 0.6 * np.exp(-((v / 4e-3) ** 2))) * np.tanh(v / 2e-3),
    ),
    "coulomb-friction": (
        dict(friction=0.05 * C * 2e-2, velocity=4e-4),
        lambda t, z, v, h: -0.05 * C * 2e-2 * np.tanh(v / 4e-4),
    ),
}


@pytest.mark.parametrize("name", SMOOTH_LAWS)
def test_smooth_law(name):
    values, force = SMOOTH_LAWS[name]
    assert_agrees(make(name, **values), Physics(force), SMOOTH)


@pytest.mark.parametrize("name", KINKED_LAWS)
def test_law_with_a_kink(name):
    values, force = KINKED_LAWS[name]
    assert_agrees(make(name.partition(" ")[0], **values), Physics(force), KINKED)


@pytest.mark.parametrize("exponent", [1.0, 1.5])
@pytest.mark.parametrize(("above", "below"), [(3.0, 0.0), (0.0, 3.0), (2.0, 5.0)])
def test_end_stop_is_a_bumper_or_a_hertzian_contact_on_either_side(exponent, above, below):
    gap, lower = 2.5e-6, 2e-6

    def force(t, z, v, h):
        if z > gap:
            return -above * K / gap ** (exponent - 1) * (z - gap) ** exponent
        if z < -lower:
            return below * K / gap ** (exponent - 1) * (-z - lower) ** exponent
        return 0.0

    stop = make("end-stop", above=above * K, below=below * K, gap=gap, exponent=exponent, asymmetry=lower / gap)
    assert_agrees(stop, Physics(force), KINKED)


def test_a_contact_loses_energy_on_the_side_where_a_stop_stands():
    gap, power, damping = 2.5e-6, 1.5, 6 * C
    stop = make("end-stop", above=3.0 * K, below=0.0, gap=gap, exponent=1.5, asymmetry=0.9)
    loss = make("contact-loss", damping=damping, exponent=power).beside(stop)
    z, v = np.linspace(-6e-6, 6e-6, 49), np.linspace(-2e-2, 3e-2, 49)
    found = np.array(loss.force(State(z, v), Drive(0.0, 0.0, 1.0, 1.0), 0.0))
    np.testing.assert_allclose(found, -damping * (np.maximum(z - gap, 0.0) / gap) ** power * v, atol=1e-18)
    both = loss.beside(make("end-stop", above=K, below=2 * K, gap=gap, exponent=1.0, asymmetry=0.9))
    found = np.array(both.force(State(z, v), Drive(0.0, 0.0, 1.0, 1.0), 0.0))
    deep = np.maximum(z - gap, 0.0) + np.maximum(-z - 0.9 * gap, 0.0)
    np.testing.assert_allclose(found, -damping * (deep / gap) ** power * v, atol=1e-18)


@pytest.mark.parametrize(
    ("law", "k3", "s", "accuracy"),
    [
        (lambda x: np.tanh(x), -1 / 3, 0.4, 5e-3),
        (lambda x: np.sin(x), -1 / 6, 0.05, 5e-3),
        (lambda x: 2 * x - x / np.sqrt(1 + x * x), 0.476, 0.64, 1e-2),
    ],
)
def test_a_cubic_spring_that_levels_off_is_many_others(law, k3, s, accuracy):
    """A saturating spring, a pendulum, a stretched string: what is left of each without its straight part."""
    x = np.linspace(-1.3, 1.3, 41)
    spring = make("cubic-stiffness", k3=k3 / STRING**3, levelling=s / STRING**2)
    found = -np.array(spring.force(State(STRING * x, 0 * x, ()), Drive(0.0, 0.0, 1.0, 1.0), 0.0))
    np.testing.assert_allclose(found, law(x) - x, atol=accuracy * np.max(np.abs(law(x) - x)))
    steep = make("cubic-stiffness", k3=k3, levelling=-0.25)
    assert float(steep.force(State(1.0, 0.0, ()), Drive(0.0, 0.0, 1.0, 1.0), 0.0)) == pytest.approx(-k3 / 0.75)


def test_power_laws_contain_the_named_ones():
    z, v = np.linspace(-5e-6, 5e-6, 41), np.linspace(-2e-2, 2e-2, 41)
    largest = {"displacement": 5e-6}

    def push(name, **values):
        return np.array(make(name, **values).force(State(z, v), Drive(0.0, 0.0, 1.0, 1.0), 0.0))

    cubic = push("power-law-stiffness", stiffness=2.0, exponent=3.0, **largest)
    np.testing.assert_allclose(cubic, push("cubic-stiffness", k3=1 / 25e-12) + z, atol=2e-4 * 5e-6)
    for exponent in (1.0, 1.0 + 1e-9, 1.0 + 1e-5):
        near = push("power-law-stiffness", stiffness=2.0, exponent=exponent, **largest)
        np.testing.assert_allclose(near, -z * np.log((z / 5e-6) ** 2 + 1e-10), atol=1e-4 * 5e-6)
        near = push("power-law-damping", damping=2.0, exponent=exponent, velocity=2e-2)
        np.testing.assert_allclose(near, -v * np.log((v / 2e-2) ** 2 + 1e-10), atol=1e-4 * 2e-2)
    for exponent, part in ((2.0, dict(c2=1 / 4e-4)), (3.0, dict(c3=1 / 8e-6))):
        name = {2.0: "quadratic-damping", 3.0: "cubic-damping"}[exponent]
        found = push("power-law-damping", damping=exponent - 1, exponent=exponent, velocity=2e-2)
        np.testing.assert_allclose(found, 2e-2 * push(name, **part) + v, atol=2e-4 * 2e-2)


def test_second_mode_is_a_second_oscillator_under_the_same_voltage():
    travel, f2, q2 = 5e-8, 1300.0, 15.0
    w2 = 2 * np.pi * f2
    physics = Physics(
        rates=lambda t, z, v, h: (h[1], w2**2 * (travel * voltage(t) - h[0]) - w2 / q2 * h[1]),
        sensor=lambda t, z, v, h: h[0],
        start=(0.0, 0.0),
    )
    assert_agrees(make("second-mode", travel=travel, period=1 / f2, quality=q2), physics, SMOOTH)


def test_a_presliding_contact_is_a_spring_with_a_damper_until_it_slides():
    # Written with the deflection of the bristles in metres and the numbers of the LuGre law.
    breaks, slides, fall = 0.2 * C * 2e-2, 0.12 * C * 2e-2, 4e-3
    stiff, damped = breaks / 2e-6, 0.1 * C
    level = lambda v: (slides + (breaks - slides) * np.exp(-((v / fall) ** 2))) / stiff
    bends = lambda t, z, v, h: (v - abs(v) * h[0] / level(v),)
    physics = Physics(
        lambda t, z, v, h: -stiff * h[0] - damped * bends(t, z, v, h)[0],
        rates=bends,
        start=(0.0,),
    )
    effect = make("presliding-friction", friction=breaks, travel=2e-6, sliding=0.6, fall=fall, damping=damped / stiff)
    assert_agrees(effect, physics, KINKED)


def test_a_presliding_contact_without_a_fall_is_the_fullest_loop():
    contact = make("presliding-friction", friction=1e-3, travel=2e-6, sliding=1.0, fall=4e-3, damping=0.0)
    loop = make("bouc-wen", friction=1e-3, travel=2e-6, sharpness=1.0, fullness=1.0)
    for h, v in ((0.4, 3e-3), (0.4, -3e-3), (-0.9, 1e-2), (-0.9, -1e-2)):
        at = (State(1e-6, v, (h,)), Drive(0.0, 0.0, 0.0, 0.0), 0.0)
        assert float(contact.rate(*at)[0]) == pytest.approx(float(loop.rate(*at)[0]))
        assert float(contact.force(*at)) == pytest.approx(float(loop.force(*at)))


def test_an_attached_mass_is_moved_by_the_stage_and_moves_it():
    share, fa, qa = 0.15, 700.0, 12.0
    wa, k = 2 * np.pi * fa, 0.15 * K
    mass = k / wa**2
    # Written with the momentum of the part, which the spring and the damper between the two change.
    between = lambda z, v, h: k * (z - h[0]) + k / (wa * qa) * (v - h[1] / mass)
    physics = Physics(
        lambda t, z, v, h: -between(z, v, h),
        rates=lambda t, z, v, h: (h[1] / mass, between(z, v, h)),
        start=(0.0, 0.0),
    )
    assert_agrees(make("attached-mass", stiffness=share * K, period=1 / fa, quality=qa), physics, SMOOTH)


@pytest.mark.parametrize("spread", [1.0, 9.0])
@pytest.mark.parametrize("time", [1e-4, 3e-4, 5e-3])
def test_viscoelastic_support_is_two_springs_behind_dashpots(time, spread):
    # Written with the forces f of the Maxwell elements as the states: f' = k v − f/τ.
    times = (time / np.sqrt(spread), time * np.sqrt(spread))
    physics = Physics(
        lambda t, z, v, h: -h[0] - h[1],
        lambda t, z, v, h: tuple(0.1 * K * v - f / tau for f, tau in zip(h, times, strict=True)),
        start=(0.0, 0.0),
    )
    assert_agrees(make("viscoelastic-support", stiffness=0.2 * K, time=time, spread=spread), physics, SMOOTH)


@pytest.mark.parametrize("name", ["stiffness-heating", "damping-heating"])
def test_what_the_drive_and_the_motion_warm_changes_stiffness_or_damping(name):
    tau, drive, motion = 3e-3, 2e-3, -0.1 / 4e-4
    of = K if name == "stiffness-heating" else 5 * C

    def force(t, z, v, h):  # one warmth, in shares of what it changes
        return -of * h[0] * (z if name == "stiffness-heating" else v)

    physics = Physics(force, lambda t, z, v, h: ((drive * voltage(t) ** 2 + motion * v**2 - h[0]) / tau,), start=(0.0,))
    assert_agrees(make(name, by_drive=of * drive, by_motion=of * motion, time=tau), physics, SMOOTH)


def test_oil_that_thins_as_it_is_sheared():
    """Written with its temperature: viscosity falls exponentially with it, and it is warmed by what that dissipates."""
    tau, cold, kelvin = 3e-3, 5 * C, 30.0
    warmed = 25.0 / (cold * 4e-4)  # K/W: by some 25 K at 2 cm/s
    viscosity = lambda h: cold * np.exp(-h[0] / kelvin)
    physics = Physics(  # the linear part has the damping of cold oil already
        lambda t, z, v, h: (cold - viscosity(h)) * v,
        lambda t, z, v, h: ((warmed * viscosity(h) * v**2 - h[0]) / tau,),
        start=(0.0,),
    )
    effect = make("damping-heating", by_motion=-warmed * cold**2 / kelvin, time=tau, fading=warmed * cold / kelvin)
    assert_agrees(effect, physics, SMOOTH)


def test_a_warm_coil_takes_less_current():
    """Written with the resistance r = 1 + θ, the current in units of a cold coil's, and what warms it."""
    tau, rise, induced = 3e-3, 0.02, 0.6 * C / GAIN
    current = lambda t, v, h: (voltage(t) - induced * v) / (1 + h[0])
    physics = Physics(  # the linear part has the cold coil's push and damping already
        lambda t, z, v, h: GAIN * (current(t, v, h) - (voltage(t) - induced * v)),
        lambda t, z, v, h: ((rise * current(t, v, h) ** 2 * (1 + h[0]) - h[0]) / tau,),
        start=(0.0,),
    )
    assert_agrees(make("coil-heating", rise=rise, induced=induced, time=tau), physics, SMOOTH)


def test_a_coil_that_leaves_its_gap_pushes_and_brakes_less():
    """Written with the current of a coil under voltage, whose force is its force factor times that."""
    bend, induced = -3e9, 0.6 * C / GAIN
    factor = lambda z: 1 + bend * z**2
    physics = Physics(  # the linear part has the push and the damping at rest already
        lambda t, z, v, h: GAIN * (factor(z) * (voltage(t) - factor(z) * induced * v) - (voltage(t) - induced * v))
    )
    assert_agrees(make("force-factor", bend=bend, induced=induced), physics, SMOOTH)


def test_what_moves_along_with_the_stage_has_a_momentum_of_its_own():
    """Written with the kinetic energy (1 + m) ż²/2, from whose momentum Lagrange's equation takes the acceleration."""
    slope, curvature = 2e4, 6e9  # a tenth of the mass, and a sixth, at 5 µm
    more, change = lambda z: slope * z + curvature * z * z, lambda z: slope + 2 * curvature * z

    def force(t, z, v, h):  # on the unit mass of the stage alone
        outer = GAIN * voltage(t) - C * v - K * z
        return (outer - change(z) * v * v / 2) / (1 + more(z)) - outer

    assert_agrees(make("variable-inertia", slope=slope, curvature=curvature), Physics(force), SMOOTH)


@pytest.mark.parametrize("sharpness", [1.0, 2.0])
@pytest.mark.parametrize("travel", [4e-7, 3e-6])
@pytest.mark.parametrize("beta", [0.5, 0.8])
def test_bouc_wen_in_its_textbook_form(sharpness, travel, beta):
    friction = 0.3 * C * 2e-2

    def rates(t, z, v, h):  # F' = k [v − (β |v| |F|ⁿ⁻¹ F + γ v |F|ⁿ)/F_yⁿ] with β + γ = 1
        part = h[0] / friction
        bend = beta * abs(v) * abs(part) ** (sharpness - 1) * part + (1 - beta) * v * abs(part) ** sharpness
        return (friction / travel * (v - bend),)

    physics = Physics(lambda t, z, v, h: -h[0], rates, start=(0.0,))
    effect = make("bouc-wen", friction=friction, travel=travel, sharpness=sharpness, fullness=beta)
    assert_agrees(effect, physics, KINKED)


def test_bouc_wen_with_a_small_yield_is_coulomb_friction():
    friction = 0.2 * C * 2e-2
    slipping = measured(make("bouc-wen", friction=friction, travel=3e-8, sharpness=2.0), substeps=32)
    dry = measured(make("coulomb-friction", friction=friction, velocity=2e-5), substeps=8)
    assert np.max(np.abs(slipping - dry)) < 0.2 * np.max(np.abs(dry - measured()))


@pytest.mark.parametrize("travel", [1e-12, 1e-10, 1e-8])  # m, where one step of the solver moves up to 4e-7 m
def test_a_yield_far_below_the_step_still_bears_no_more_than_its_friction(travel):
    friction = 0.2 * C * 2e-2
    reading = measured(make("bouc-wen", friction=friction, travel=travel, sharpness=2.0))
    dry = measured(make("coulomb-friction", friction=friction, velocity=2e-5), substeps=8)
    assert np.max(np.abs(reading - dry)) < np.max(np.abs(dry - measured()))


@pytest.mark.parametrize("beta", [0.5, 2.7])
def test_a_bouc_wen_loop_may_stiffen(beta):
    """The other sign of β + γ, as in the hysteretic benchmark of Noël and Schoukens, 2016."""
    travel, start = 3e-6, 0.3 * K

    def rates(t, z, v, h):  # F' = k [v + (−β |v| F + (1 + β) v |F|)/F_y], k = F_y/|z_y|
        scale = start * travel
        return (start * (v - (beta * abs(v) * h[0] - (1 + beta) * v * abs(h[0])) / scale),)

    physics = Physics(lambda t, z, v, h: -h[0], rates, start=(0.0,))
    effect = make("bouc-wen", friction=start * travel, travel=-travel, sharpness=1.0, fullness=beta)
    assert_agrees(effect, physics, KINKED)
