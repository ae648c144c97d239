"""What every effect of the library promises, whatever its physics."""

from __future__ import annotations

import itertools

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ident.campaign.device import Oscillator, Platform
from ident.effects.dimensions import check_units
from ident.effects.effect import AbstractEffect, Drive, State
from ident.effects.registry import built_in
from tests.effects.harness import STIFFNESS, make, measured

INTERFACE = (
    "residual-stress, arch-force, cubic-stiffness, quadratic-stiffness, voltage-stiffness, stiffness-drift, end-stop, "
    "quintic-stiffness, power-law-stiffness, power-law-damping, third-mode, fourth-mode, fifth-mode, sixth-mode, "
    "static-force, second-mode, viscoelastic-support, coulomb-friction, quadratic-damping, cubic-damping, "
    "squeeze-film-damping, damping-drift, bouc-wen, pzt-hysteresis, prandtl-ishlinskii, bouc-wen-drive, "
    "electrostriction, electrostatic-force, creep, drive-lag, sensor-nonlinearity, sensor-lag, sensor-crosstalk, "
    "sensor-drift, sensor-offset, ac-coupling, stribeck-friction, bilinear-stiffness, attached-mass, "
    "stiffness-heating, damping-heating, drive-heating, "
    "coil-heating, force-factor, variable-inertia, contact-loss, presliding-friction, slew-limit, drive-saturation, "
    "backlash, cogging, asymmetric-damping, eddy-current-brake"
)  # what outside programs rely on
NAMES = sorted(built_in())
GENERAL = [name for name in NAMES if not built_in()[name].platform_only]

# Shapes sized for the records of the harness: z some µm, v some cm/s, V some volts, 2 ms periods, 16 ms long.
SCALES = {"displacement": 5e-6, "velocity": 2e-2, "voltage": 7.0, "period": 2e-3, "duration": 0.016,
          "induction": 350.0, "nearness": 2e5, "squared_nearness": 4e10, "slowness": 7e-5,
          "per_squared_velocity": 2.5e3, "one": 1.0}  # fmt: skip


def sized(effect: type[AbstractEffect], share: int = 0) -> dict[str, float]:
    """Shape parameters at the `share`-th value of their grids, in SI."""
    return {p.name: p.grid[share % len(p.grid)] * SCALES[p.scale] for p in effect.parameters if p.kind == "shape"}


def absent(effect: type[AbstractEffect]) -> dict[str, float]:
    """All amplitudes zero."""
    return {p.name: 0.0 for p in effect.parameters if p.kind == "amplitude"}


def every_setting(effect: type[AbstractEffect]) -> list[dict[str, str]]:
    """Every combination of the effect's choices."""
    names = [choice.name for choice in effect.choices]
    return [dict(zip(names, words, strict=True)) for words in itertools.product(*(c.words for c in effect.choices))]


def beside_partner(effect: AbstractEffect) -> AbstractEffect:
    """The effect with the partner that it needs, where it needs one, and that acts."""
    if not effect.needs:
        return effect
    partner = built_in()[effect.needs]
    here = sized(partner) if isinstance(effect.device, Oscillator) else {}
    acts = dict.fromkeys(absent(partner), 1.0) if here else {}
    return effect.beside(partner(effect.device, **here, **acts))


def formulas(effect: AbstractEffect, state: State, drive: Drive, t: float) -> list:
    """Everything that an effect computes at one instant."""
    return [
        effect.force(state, drive, t),
        effect.drive(state.hidden, drive, t),
        effect.sensor(state, drive, t),
        *effect.rate(state, drive, t),
        *effect.follow(state.hidden, drive, drive, 1e-4),
    ]


def test_the_library_has_the_names_of_the_interface():
    assert sorted(INTERFACE.split(", ")) == NAMES


@pytest.mark.parametrize("name", NAMES)
def test_units_are_right(name):
    check_units(built_in()[name], built_in())


@pytest.mark.parametrize("name", NAMES)
def test_every_effect_explains_itself(name):
    effect = built_in()[name]
    assert effect.equation and effect.source and (effect.__doc__ or "").strip()
    assert all(p.doc for p in effect.parameters)
    assert any(p.kind == "amplitude" for p in effect.parameters)
    for other in effect.mistaken_for:
        assert name in built_in()[other].mistaken_for, f"{other} does not know that it is mistaken for {name}"


@pytest.mark.parametrize("name", NAMES)
def test_hidden_states_have_a_unit_a_start_and_a_rate(name):
    effect = beside_partner(built_in()[name](Platform()))
    state = State(1e-6, 1e-2, effect.state0())
    drive = Drive(1.0, 1.0, 1.0, 1.0)
    count = len(
        effect.follow(state.hidden, drive, drive, 1.0) if effect.overrides("follow") else effect.rate(state, drive, 0.0)
    )
    assert count == len(effect.state0()) == len(effect.hidden_units)
    assert all(value == 0.0 for value in effect.state0()), "a record that starts at rest has no memory"


@pytest.mark.parametrize("name", NAMES)
def test_zero_amplitude_is_exactly_no_effect(name):
    effect = built_in()[name]
    for settings in every_setting(effect):
        off = beside_partner(effect(Platform(), settings, **sized(effect), **absent(effect)))
        hidden = tuple(0.3 for _ in effect.hidden_units)
        for sign in (1.0, -1.0):
            state, drive = State(sign * 4e-6, sign * 1e-2, hidden), Drive(sign * 5.0, 3e3, 2e3, 1e-4)
            assert float(off.force(state, drive, 1e-3)) == 0.0
            assert float(off.drive(hidden, drive, 1e-3)) == 0.0
            assert float(off.sensor(state, drive, 1e-3)) == 0.0


@pytest.mark.parametrize("name", GENERAL)
def test_zero_amplitude_leaves_the_reading_as_it_was(name):
    effect = built_in()[name]
    off = make(name, **sized(effect), **absent(effect))
    np.testing.assert_allclose(measured(off), measured(), rtol=0, atol=1e-18)


@pytest.mark.parametrize("name", GENERAL)
def test_each_amplitude_shows_at_first_order_from_zero(name):
    # The score of an absent effect is its derivative by the amplitude at zero: it must be finite, and show something.
    effect = built_in()[name]
    shapes, off = sized(effect), absent(effect)
    for amplitude in off:

        def one(a, amplitude=amplitude):
            return measured_by(name, {**shapes, **off, amplitude: a})

        slope = np.asarray(jax.jvp(one, (0.0,), (1.0,))[1])
        assert np.all(np.isfinite(slope)) and np.max(np.abs(slope)) > 0.0, amplitude


def measured_by(name: str, values: dict) -> jax.Array:
    """What the effect computes along a made-up motion, one number per formula and instant, differentiable."""
    effect = beside_partner(make(name, **values))
    t = jnp.linspace(0.0, 0.016, 60)
    z, v = 5e-6 * jnp.sin(3e3 * t), 1.5e-2 * jnp.cos(3e3 * t)
    drive = Drive(7 * jnp.sin(2e3 * t), 1.4e4 * jnp.cos(2e3 * t), 2e3, 2.0)
    hidden = tuple(0.3 * jnp.sin(2.5e3 * t) for _ in effect.hidden_units)
    state = State(z, v, hidden)
    found = [effect.force(state, drive, t), effect.drive(hidden, drive, t), effect.sensor(state, drive, t)]
    return jnp.concatenate([jnp.broadcast_to(jnp.asarray(f, float), t.shape) for f in found])


def finite(largest: float) -> st.SearchStrategy[float]:
    return st.floats(-largest, largest, allow_nan=False)


# Every law has a power of at most five, so these stay far from overflow: a fit can try no wilder state than that.
@pytest.mark.parametrize("name", NAMES)
@given(
    z=finite(1e3), v=finite(1e6), volts=finite(1e6), rate=finite(1e12), hidden=finite(1e6),
    t=st.floats(0.0, 1e6), share=st.integers(0, 5), strength=finite(1e6),
)  # fmt: skip
def test_every_formula_is_finite_in_any_finite_state(name, z, v, volts, rate, hidden, t, share, strength):
    kind = built_in()[name]
    device = Platform() if kind.platform_only else Oscillator()
    effect = beside_partner(kind(device, None, **sized(kind, share), **dict.fromkeys(absent(kind), strength)))
    state = State(z, v, tuple(hidden for _ in kind.hidden_units))
    values = formulas(effect, state, Drive(volts, rate, 2e3, 1e-4), t)
    assert np.all(np.isfinite(np.array([float(value) for value in values])))


@pytest.mark.parametrize("name", GENERAL)
def test_derivatives_by_every_parameter_are_finite_at_rest(name):
    # At the first sample everything is zero, where powers and square roots lose their derivatives.
    kind = built_in()[name]
    names = [p.name for p in kind.parameters]
    values = {**sized(kind), **dict.fromkeys(absent(kind), 0.1 * STIFFNESS)}

    def at_rest(*numbers):
        effect = beside_partner(make(name, **dict(zip(names, numbers, strict=True))))
        state = State(0.0, 0.0, effect.state0())
        return jnp.stack([jnp.asarray(f, float) for f in formulas(effect, state, Drive(0.0, 0.0, 2e3, 2.0), 0.0)])

    slopes = jax.jacfwd(at_rest, argnums=tuple(range(len(names))))(*(float(values[n]) for n in names))
    assert np.all(np.isfinite(np.array(slopes)))
