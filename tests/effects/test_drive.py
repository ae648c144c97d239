"""Laws of the drive against independent solutions, hysteresis against exact play operators."""

from __future__ import annotations

import jax.numpy as jnp
import numpy as np
import pytest
from scipy.integrate import solve_ivp

from ident.effects.effect import Drive
from ident.response.memory import Remembered, Seen, follows_drive_alone, forgotten, memory_along, remembered_force
from tests.effects.harness import (
    DURATION,
    GAIN,
    SAMPLES,
    TIME,
    TONES,
    Physics,
    assert_agrees,
    make,
    measured,
    reference,
    voltage,
    voltage_rate,
)

SMOOTH, KINKED = 1e-5, 2e-3


def plays(signal: np.ndarray, half_width: float) -> np.ndarray:
    """The exact play operator on a finely sampled signal, from rest."""
    follower = np.zeros_like(signal)
    for i in range(1, len(signal)):
        follower[i] = min(max(follower[i - 1], signal[i] - half_width), signal[i] + half_width)
    return follower


def of_time(values: np.ndarray, fine: np.ndarray):
    return lambda t: np.interp(t, fine, values)


def test_electrostriction():
    physics = Physics(lambda t, z, v, h: 0.02 * GAIN * voltage(t) ** 2)
    assert_agrees(make("electrostriction", share=0.02), physics, SMOOTH)


def test_polynomial_hysteresis_of_a_generic_oscillator():
    omega = TONES[0][1]
    physics = Physics(lambda t, z, v, h: -2e-3 * voltage(t) ** 3 + 3e-3 * (voltage_rate(t) / omega) ** 3)
    assert_agrees(make("pzt-hysteresis", eta=2e-3, zeta=3e-3), physics, SMOOTH)


def test_creep_is_three_late_followers_and_a_growth():
    times = (1e-3, 4e-3, 16e-3)
    physics = Physics(
        lambda t, z, v, h: GAIN * (0.3 * (h[0] + h[1] + h[2]) / 3 + 0.05 * voltage(t) * np.log(1 + t / 4e-3)),
        lambda t, z, v, h: [(voltage(t) - q) / time for q, time in zip(h, times, strict=True)],
        start=(0.0, 0.0, 0.0),
    )
    assert_agrees(make("creep", late=0.3, growth=0.05, time=4e-3, spread=4.0), physics, SMOOTH)


def test_creep_after_a_step_is_logarithmic_over_two_decades():
    # Jung & Gweon 2000: V (1 + γ log₁₀(t/t₀)); a sum of three exponentials, spread by 6, against the straight line.
    decades = np.linspace(-1.0, 1.0, 81)
    late = np.mean([1 - np.exp(-(10.0**decades) / 6.0**j) for j in (-1, 0, 1)], axis=0)
    slope, start = np.polyfit(decades, late, 1)
    assert np.max(np.abs(late - (start + slope * decades))) < 0.04
    assert slope == pytest.approx(1 / 2.6, rel=0.03)  # m = 2.6 γ


@pytest.mark.parametrize("time", [2e-6, 1e-5, 3e-5, 1e-4, 1e-3])
def test_drive_lag_is_an_exact_lag(time):
    physics = Physics(
        lambda t, z, v, h: GAIN * (h[0] - voltage(t)), lambda t, z, v, h: ((voltage(t) - h[0]) / time,), start=(0.0,)
    )
    assert_agrees(make("drive-lag", time=time), physics, 1e-4)


def test_a_negative_drive_lag_is_a_lead():
    shift = 3e-6
    physics = Physics(lambda t, z, v, h: GAIN * (voltage(t + shift) - voltage(t)))
    assert_agrees(make("drive-lag", time=-shift), physics, 2e-2)


@pytest.mark.parametrize("time", [2e-6, 3e-5])
@pytest.mark.parametrize("fastest", [9e3, 1.6e4])  # V/s, where the drive needs 24,000
def test_an_amplifier_follows_no_faster_than_it_can(fastest, time):
    def rates(t, z, v, h):
        return (np.clip((voltage(t) - h[0]) / time, -fastest, fastest),)

    physics = Physics(lambda t, z, v, h: GAIN * 0.8 * (h[0] - voltage(t)), rates, start=(0.0,))
    effect = make("slew-limit", share=0.8, slowness=1 / fastest, time=time)
    assert_agrees(effect, physics, KINKED)


@pytest.mark.parametrize("late", [1e-6, 0.126])  # of a radian
@pytest.mark.parametrize("limit", [0.2, 0.5, 0.56, 0.8, 1.3])  # of the fastest change of the sine
def test_an_amplifier_that_has_long_been_driven_too_fast(limit, late):
    """A straight ramp from where the sine became too fast, or a triangle."""
    t = np.linspace(0.0, 30 * np.pi, 200_001)
    w = np.zeros_like(t)
    for k in range(1, len(t)):  # each step as far as it may go
        most, share = 3 * limit * (t[k] - t[k - 1]), 1 - np.exp((t[k - 1] - t[k]) / late)
        w[k] = w[k - 1] + np.clip(share * (3 * np.sin(t[k]) - w[k - 1]), -most, most)
    last = slice(-13_000, None, 37)
    drive = Drive(3 * np.sin(t[last]), 3 * np.cos(t[last]), 1.0, 1.0)
    found = make("slew-limit", slowness=1 / (3 * limit), time=late).settled(3.0, drive)[0]
    np.testing.assert_allclose(found, w[last], atol=3 * (1e-3 + 0.32 * late))


def test_a_drive_levels_off_as_a_tanh_does():
    physics = Physics(lambda t, z, v, h: GAIN * (6.0 * np.tanh(voltage(t) / 6.0) - voltage(t)))
    assert_agrees(make("drive-saturation", cubic=1 / (3 * 36), levelling=1.2), physics, 0.01)


@pytest.mark.parametrize("sharpness", [1.0, 2.0])
@pytest.mark.parametrize("travel", [0.8, 3.0])
def test_bouc_wen_drive_in_its_textbook_form(sharpness, travel):
    def rates(t, z, v, h):
        rate = voltage_rate(t)
        bend = 0.5 * (abs(rate) * abs(h[0]) ** (sharpness - 1) * h[0] + rate * abs(h[0]) ** sharpness)
        return ((rate - bend) / travel,)

    physics = Physics(lambda t, z, v, h: -GAIN * 0.4 * h[0], rates, start=(0.0,))
    assert_agrees(make("bouc-wen-drive", loop=0.4, travel=travel, sharpness=sharpness), physics, KINKED)


def test_prandtl_ishlinskii_is_a_sum_of_exact_plays():
    reach, weight, tilt = 6.0, 0.3, 0.1
    fine = np.linspace(0.0, DURATION, 40 * SAMPLES + 1)
    volts = voltage(fine)
    behind = np.zeros_like(fine)
    for j in range(6):
        behind += (weight + tilt * (2 * j / 5 - 1)) * (volts - plays(volts, reach * (j + 0.5) / 6)) / 6
    force = of_time(-GAIN * behind, fine)
    effect = make("prandtl-ishlinskii", weight=weight, tilt=tilt, reach=reach)
    assert_agrees(effect, Physics(lambda t, z, v, h: force(t)), 5e-3)


@pytest.mark.parametrize("width", [0.6, 2.5])
def test_backlash_is_one_exact_play(width):
    fine = np.linspace(0.0, DURATION, 40 * SAMPLES + 1)
    force = of_time(-GAIN * 0.8 * (voltage(fine) - plays(voltage(fine), width)), fine)
    effect = make("backlash", share=0.8, width=width, edge=150.0)
    assert_agrees(effect, Physics(lambda t, z, v, h: force(t)), 5e-3)


def test_plays_stay_within_their_width_however_large_the_step():
    # With the sensor far from resonance the reading shows the force: compare levels, not shapes.
    effect = make("prandtl-ishlinskii", weight=0.3, reach=0.5)
    fine = measured(effect, substeps=8)
    coarse = measured(effect, substeps=1)
    assert np.max(np.abs(coarse - fine)) < 0.05 * np.max(np.abs(fine))


def test_the_loop_of_plays_does_not_depend_on_the_frequency():
    # Rate independence: the same voltages in the same order give the same followers, at any speed.
    effect = make("prandtl-ishlinskii", weight=0.3, reach=6.0)
    swing = 7 * np.sin(2 * np.pi * np.linspace(0, 2, 801))
    loops = [_remembered(effect, swing, duration) for duration in (1.0, 2.0**-10)]
    np.testing.assert_allclose(loops[0], loops[1], rtol=0, atol=1e-9)
    exact = np.array([plays(swing, 6.0 * (j + 0.5) / 6) for j in range(6)])
    assert np.sqrt(np.mean((loops[0] - exact) ** 2)) < 0.02 * np.std(swing)  # the edges are rounded


@pytest.mark.parametrize(
    ("ease", "left"), [(1.0, lambda x: 1 / (1 + x)), (-1.0, lambda x: 1 - x), (0.0, lambda x: np.exp(-x))]
)
@pytest.mark.parametrize("time", [1e-3, 5e-3])
def test_a_push_that_falls_with_the_warmth_of_the_drive(time, ease, left):
    physics = Physics(
        lambda t, z, v, h: -GAIN * voltage(t) * (1 - left(0.01 * h[0])),
        lambda t, z, v, h: ((voltage(t) ** 2 - h[0]) / time,),
        start=(0.0,),
    )
    assert_agrees(make("drive-heating", loss=0.01, ease=ease, time=time), physics, SMOOTH)


@pytest.mark.parametrize("time", [0.2, 5.0])
def test_the_warmth_of_a_sine_that_has_lasted_for_ever(time):
    t = 40 * time + np.linspace(0, 2 * np.pi, 9)
    exact = solve_ivp(lambda t, q: (9 * np.sin(t) ** 2 - q) / time, (0, t[-1]), [0.0], t_eval=t, rtol=1e-9, atol=1e-9)
    warm = make("drive-heating", time=time).settled(3.0, Drive(3 * np.sin(t), 3 * np.cos(t), 1.0, 1.0))
    np.testing.assert_allclose(warm[0], exact.y[0], atol=1e-6)


@pytest.mark.parametrize(
    "name", ["backlash", "bouc-wen-drive", "creep", "drive-heating", "drive-lag", "prandtl-ishlinskii", "slew-limit"]
)
def test_memories_of_the_drive_alone_are_told_and_have_the_tangents_of_a_difference(name):
    drive = _seen(voltage(TIME), voltage_rate(TIME), TIME[1])
    effect = make(name)
    assert follows_drive_alone(effect)
    at = {p.name: {"s": 1e-3, "s/V": 1e-4}.get(p.unit, 0.7) for p in effect.parameters}

    def force(values, gain):
        bound = effect.with_values(**dict(zip(at, values, strict=True)))
        return _force(bound, drive._replace(gain=gain))

    values = jnp.array(list(at.values()))
    _, slopes = force(values, 2.0)
    for i, value in enumerate(at.values()):
        step = jnp.zeros(len(at)).at[i].set(1e-5 * value)
        difference = (force(values + step, 2.0)[0] - force(values - step, 2.0)[0]) / 2
        tangent = 1e-5 * value * slopes[i]
        np.testing.assert_allclose(tangent, difference, rtol=0, atol=1e-3 * np.max(np.abs(difference)))
    np.testing.assert_allclose(2.0 * slopes[-1], force(values, 2.0)[0], rtol=1e-12)


def _seen(volts: np.ndarray, slope: np.ndarray, step: float) -> Seen:
    """A drive on the half-step grid, of frequency 1 rad/s and unit gain, without a motion."""
    still, time = jnp.zeros(len(volts)), 0.5 * step * np.arange(len(volts))
    return Seen(still, still, jnp.asarray(volts), jnp.asarray(slope), time, step, 1.0, 1.0, 0.0)


def _force(effect, seen: Seen) -> tuple[np.ndarray, np.ndarray]:
    """Force of an effect that follows the drive alone from the beginning of a record, and its derivatives."""
    hidden, slopes = (jnp.zeros(shape) for shape in forgotten(effect, past=False))
    return remembered_force(effect, Remembered(hidden, slopes), 1.0, seen, history=jnp.zeros(0))[1:]


@pytest.mark.parametrize("name", ["bouc-wen", "viscoelastic-support", "second-mode", "sensor-lag", "electrostriction"])
def test_memories_of_the_motion_and_effects_without_memory_stay_in_the_loop(name):
    assert not follows_drive_alone(make(name))


@pytest.mark.parametrize("level", [-90.0, -3.0, 0.0, 20.0])
def test_plays_of_a_record_under_voltage_are_where_the_voltage_has_taken_them(level):
    effect = make("prandtl-ishlinskii", weight=0.3, reach=24.0)
    rise = np.linspace(0.0, level, 4001)
    exact = [plays(rise, 24.0 * (j + 0.5) / 6)[-1] for j in range(6)]
    np.testing.assert_allclose(effect.begun(Drive(level, 0.0, 1.0, 1.0)), exact, rtol=0, atol=1e-9)


@pytest.mark.parametrize("reach", [1.5, 3.0, 9.0])
def test_tangents_of_narrow_plays_are_those_of_a_difference(reach):
    swing = 9 * np.sin(2 * np.pi * np.linspace(0, 3, 2881))
    drive = _seen(swing, np.gradient(swing), 2.0)

    def held(width):
        effect = make("prandtl-ishlinskii", weight=1.0).with_values(weight=1.0, tilt=0.0, reach=width)
        return _force(effect, drive)

    tangent = held(reach)[1][list(make("prandtl-ishlinskii").values).index("reach")]
    difference = (held(reach * 1.0001)[0] - held(reach * 0.9999)[0]) / (0.0002 * reach)
    np.testing.assert_allclose(tangent, difference, rtol=0, atol=1e-3 * np.max(np.abs(difference)))


def test_a_play_does_not_depend_on_the_number_of_points():
    # … and is at a turn between two points where a fine grid takes it.
    effect = make("prandtl-ishlinskii", weight=0.3, reach=6.0)
    way = lambda points: np.linspace(0, 4 * np.pi, points)
    coarse, fine = (
        np.array(memory_along(effect, (jnp.zeros(()),) * 6, _seen(9 * np.sin(s), 9 * np.cos(s), 2 * s[1]))[1])
        for s in (way(101), way(10001))
    )
    assert np.max(np.abs(coarse - fine[:, ::100])) < 2e-3


@pytest.mark.parametrize("level", [-9.0, 0.5, 4.0])
def test_a_yielding_element_under_voltage_is_loaded_by_it(level):
    effect = make("bouc-wen-drive", loop=1.0, travel=3.0, sharpness=2.0)
    loaded = solve_ivp(lambda u, h: [(1 - h[0] ** 2) / 3.0], (0.0, abs(level)), [0.0], rtol=1e-9, atol=1e-12).y[0, -1]
    assert float(effect.begun(Drive(level, 0.0, 1.0, 1.0))[0]) == pytest.approx(np.sign(level) * loaded, rel=1e-6)


def _remembered(effect, volts: np.ndarray, duration: float) -> np.ndarray:
    step = 2 * duration / (len(volts) - 1)
    seen = _seen(volts, np.gradient(volts, step / 2), step)
    begin = tuple(jnp.asarray(h, float) for h in effect.begun(seen.first))
    return np.array(memory_along(effect, begin, seen)[1])


def test_the_reading_without_effects_is_the_reference():
    truth = reference(Physics())
    assert np.max(np.abs(measured(substeps=4) - truth)) < 1e-7 * np.max(np.abs(truth))
    assert len(truth) == len(TIME)
