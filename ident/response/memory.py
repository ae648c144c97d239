"""Hidden states along a given motion; and the forces through the actuator whose memory is of the drive alone.

Such forces are integrated before the motion, of which they know nothing. In the loop of the motion each of their
states would carry a tangent for every unknown of the model; here it carries those of its own effect.
"""

from __future__ import annotations

from collections.abc import Callable

import jax
import jax.numpy as jnp
from jax import Array, lax

from ..effects.effect import AbstractEffect, Drive, State
from .lane import Lane, Numbers, half_step_time
from .runge_kutta import runge_kutta, stages, steps_of


def memory_along(
    effect: AbstractEffect, gain: Numbers, omega: Numbers, lane: Lane, z: Numbers, v: Numbers
) -> tuple[Array, ...]:
    """Hidden states of one effect along a given motion, each (2 n + 1,) on the half-step grid.

    `gain`, N/V, and `omega`, rad/s, of the drive; `z` and `v`, (2 n + 1,) m and m/s. Between the steps of the method
    the states follow the cubic that has their rates at both ends.
    """
    drive = lambda voltage, rate: Drive(voltage, rate, omega, gain, lane.moving)
    first = effect.begun(drive(jnp.asarray(lane.voltage)[0], jnp.asarray(lane.rate)[0]))
    if not first:
        return ()

    # Adding a zero that depends on the parameters gives the carry the type it will have under differentiation.
    nothing = 0.0 * gain + 0.0 * sum(effect.values.values())
    begin = tuple(jnp.asarray(h) + nothing for h in first)
    if effect.overrides("follow"):
        return _followed(effect, begin, drive, lane)

    def rate(hidden: tuple[Array, ...], at: tuple[Array, ...]) -> tuple[Array, ...]:
        z, v, voltage, slope, t = at
        return effect.rate(State(z, v, hidden), drive(voltage, slope), t)

    def advance(hidden: tuple[Array, ...], x: tuple[tuple[Array, ...], ...]) -> tuple[tuple[Array, ...], tuple]:
        hidden = runge_kutta(rate, hidden, stages(x), lane.step)
        return hidden, hidden

    grids = (z, v, lane.voltage, lane.rate, half_step_time(lane))
    _, path = lax.scan(advance, begin, steps_of(grids))
    at_steps = tuple(jnp.concatenate([a[None], b]) for a, b in zip(begin, path, strict=True))
    rates = jax.vmap(rate)(at_steps, tuple(jnp.asarray(grid)[::2] for grid in grids))
    return tuple(_with_midpoints(h, r, lane.step) for h, r in zip(at_steps, rates, strict=True))


def _followed(
    effect: AbstractEffect, begin: tuple[Array, ...], drive: Callable[[Array, Array], Drive], lane: Lane
) -> tuple[Array, ...]:
    def advance(hidden: tuple[Array, ...], at: tuple[Array, ...]) -> tuple[tuple[Array, ...], tuple[Array, ...]]:
        hidden = effect.follow(hidden, drive(*at[:2]), drive(*at[2:]), 0.5 * lane.step)
        return hidden, hidden

    voltage, rate = jnp.asarray(lane.voltage), jnp.asarray(lane.rate)
    _, path = lax.scan(advance, begin, (voltage[:-1], rate[:-1], voltage[1:], rate[1:]))
    return tuple(jnp.concatenate([a[None], b]) for a, b in zip(begin, path, strict=True))


def _with_midpoints(x: Array, rate: Array, step: Numbers) -> Array:
    middle = (x[:-1] + x[1:]) / 2 + step / 8 * (rate[:-1] - rate[1:])
    return jnp.concatenate([jnp.stack([x[:-1], middle], axis=1).ravel(), x[-1:]])


def follows_drive_alone(effect: AbstractEffect) -> bool:
    """Whether an effect acts through the actuator only, with a memory that sees nothing of the motion."""
    if effect.needs or not effect.state0() or effect.overrides("force") or effect.overrides("sensor"):
        return False
    return _can_remember(effect, State(None, None, effect.state0()))


def _can_remember(effect: AbstractEffect, state: State) -> bool:
    """Whether the memory of an effect needs nothing of what is None."""
    drive = Drive(1.0, 1.0, 1.0, 1.0)
    try:
        effect.begun(drive)
        effect.follow(state.hidden, drive, drive, 1.0)
        effect.rate(state, drive, 0.0)
    except (TypeError, ValueError, AttributeError):
        return False
    return True


def remembered_force(effect: AbstractEffect, gain: Numbers, omega: Numbers, lane: Lane) -> Array:
    """Force of an effect that follows the drive alone, (2 n + 1,) N on the half-step grid; arguments as above.

    Its memory has tangents along those parameters that it depends on, its force along all of the effect's and the gain.
    """
    names = tuple(effect.values)
    state = State(0.0, 0.0, effect.state0())
    shaping = [i for i, name in enumerate(names) if not _can_remember(effect.with_values(**{name: None}), state)]

    def memory(some: Array, unknowns: Array, omega: Array, lane: Lane) -> tuple[Array, ...]:
        values = dict(zip(names, unknowns, strict=False)) | {names[i]: x for i, x in zip(shaping, some, strict=True)}
        still = jnp.zeros_like(lane.voltage)
        return memory_along(effect.with_values(**values), unknowns[-1], omega, lane, still, still)

    def acting(unknowns: Array, hidden: tuple[Array, ...], omega: Array, lane: Lane) -> Array:
        at = effect.with_values(**dict(zip(names, unknowns, strict=False)))
        one = lambda h, u, r, t: at.drive(h, Drive(u, r, omega, unknowns[-1], lane.moving), t)
        return jax.vmap(one)(hidden, lane.voltage, lane.rate, half_step_time(lane))

    @jax.custom_jvp
    def force(unknowns: Array, omega: Array, lane: Lane) -> Array:
        return acting(unknowns, memory(unknowns[jnp.array(shaping, int)], unknowns, omega, lane), omega, lane)

    @force.defjvp
    def _(primals: tuple, tangents: tuple) -> tuple[Array, Array]:
        unknowns, *given = primals
        some, axes = unknowns[jnp.array(shaping, int)], jnp.eye(len(unknowns))
        along = lambda axis: jax.jvp(lambda x: memory(x, unknowns, *given), (some,), (axis,))
        hidden, changes = jax.vmap(along, out_axes=(None, 0))(jnp.eye(len(shaping)))
        slopes = []
        for i, axis in enumerate(axes):
            change = [c[shaping.index(i)] for c in changes] if i in shaping else [jnp.zeros_like(h) for h in hidden]
            slopes.append(jax.jvp(lambda x, h: acting(x, h, *given), (unknowns, hidden), (axis, tuple(change)))[1])
        return acting(unknowns, hidden, *given), tangents[0] @ jnp.stack(slopes)

    return force(jnp.stack([jnp.asarray(x, float) for x in (*effect.values.values(), gain)]), omega, lane)
