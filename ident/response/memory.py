"""Hidden states along a given motion; and the forces through the actuator whose memory is of the drive alone.

Such forces are integrated before the motion, of which they know nothing. In the loop of the motion each of their
states would carry a tangent for every unknown of the model; here it carries those of its own effect.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
from jax import Array, lax

from ..effects.effect import AbstractEffect, Drive, State
from .lane import Numbers
from .runge_kutta import by_steps, runge_kutta, stages

Hidden = tuple[Array, ...]


class Seen(NamedTuple):
    """What an effect sees in a block, (points,) on the half-step grid: `z`, `v`, `voltage`, `rate`, `time`; and what is
    constant there: the `step`, `omega`, `gain`, `moving`."""

    z: Numbers
    v: Numbers
    voltage: Numbers
    rate: Numbers
    time: Numbers
    step: Numbers
    omega: Numbers
    gain: Numbers
    moving: Numbers

    def drive(self, voltage: Numbers, rate: Numbers) -> Drive:
        """The drive as the effects see it."""
        return Drive(voltage, rate, self.omega, self.gain, self.moving)

    @property
    def first(self) -> Drive:
        """The drive at the first point."""
        return self.drive(self.voltage[0], self.rate[0])


def memory_along(effect: AbstractEffect, hidden: Hidden, seen: Seen) -> tuple[Hidden, Hidden]:
    """Hidden states of one effect along a given motion: those at the end, and each (points,) on the half-step grid.

    `hidden`: those at the first point. Between the steps of the method they follow the cubic that has their rates at
    both ends.
    """
    if not hidden:
        return (), ()
    # Adding a zero that depends on the parameters gives the carry the type it will have under differentiation.
    nothing = 0.0 * seen.gain + 0.0 * sum(effect.values.values())
    hidden = tuple(h + nothing for h in hidden)
    if effect.overrides("follow"):
        return _followed(effect, hidden, seen)

    def rate(hidden: Hidden, at: tuple[Array, ...]) -> Hidden:
        z, v, voltage, slope, t = at
        return effect.rate(State(z, v, hidden), seen.drive(voltage, slope), t)

    def advance(hidden: Hidden, x: tuple[tuple[Array, ...], ...]) -> tuple[Hidden, Hidden]:
        hidden = runge_kutta(rate, hidden, stages(x), seen.step)
        return hidden, hidden

    grids = (seen.z, seen.v, seen.voltage, seen.rate, seen.time)
    end, path = lax.scan(advance, hidden, by_steps(grids))
    at_steps = tuple(jnp.concatenate([a[None], b]) for a, b in zip(hidden, path, strict=True))
    rates = jax.vmap(rate)(at_steps, tuple(jnp.asarray(grid)[::2] for grid in grids))
    return end, tuple(_with_midpoints(h, r, seen.step) for h, r in zip(at_steps, rates, strict=True))


def _followed(effect: AbstractEffect, hidden: Hidden, seen: Seen) -> tuple[Hidden, Hidden]:
    def advance(hidden: Hidden, at: tuple[Array, ...]) -> tuple[Hidden, Hidden]:
        # A padded block has no step, and nothing happens in it.
        step = jnp.where(seen.step > 0, 0.5 * seen.step, 1.0)
        hidden = effect.follow(hidden, seen.drive(*at[:2]), seen.drive(*at[2:]), step)
        return hidden, hidden

    voltage, rate = jnp.asarray(seen.voltage), jnp.asarray(seen.rate)
    end, path = lax.scan(advance, hidden, (voltage[:-1], rate[:-1], voltage[1:], rate[1:]))
    return end, tuple(jnp.concatenate([a[None], b]) for a, b in zip(hidden, path, strict=True))


def _with_midpoints(x: Array, rate: Array, step: Numbers) -> Array:
    middle = (x[:-1] + x[1:]) / 2 + step / 8 * (rate[:-1] - rate[1:])
    return jnp.concatenate([jnp.stack([x[:-1], middle], axis=1).ravel(), x[-1:]])


def follows_drive_alone(effect: AbstractEffect) -> bool:
    """Whether an effect acts through the actuator only, with a memory that sees nothing of the motion."""
    if effect.needs or not effect.state0() or effect.overrides("force") or effect.overrides("sensor"):
        return False
    return _can_remember(effect, State(None, None, effect.state0()))


def _can_remember(effect: AbstractEffect, state: State, **absent: None) -> bool:
    """Whether the memory of an effect needs nothing of what is None, be it a state or a number that is `absent`."""
    drive = Drive(1.0, 1.0, 1.0, 1.0)
    begun, rate = lambda: effect.begun(drive), lambda: effect.rate(state, drive, 0.0)
    followed = lambda: effect.follow(state.hidden, drive, drive, 1.0)
    try:
        effect = effect.with_values(**absent) if absent else effect
        for asked in (begun, followed, rate):
            jax.eval_shape(asked)  # nothing is computed
    except (TypeError, ValueError, AttributeError):
        return False
    return True


def shaping(effect: AbstractEffect) -> tuple[str, ...]:
    """Names of the parameters on which the memory of an effect depends."""
    state = State(0.0, 0.0, effect.state0())
    return tuple(name for name in effect.values if not _can_remember(effect, state, **{name: None}))


class Remembered(NamedTuple):
    """Memory of one effect between blocks: `hidden` states, (h,), and their derivatives `slopes`, (q, h), by the
    parameters on which they depend and by the history."""

    hidden: Array
    slopes: Array


def remembered_force(
    effect: AbstractEffect, memory: Remembered, first: Numbers, seen: Seen, history: Numbers
) -> tuple[Remembered, Array, Array]:
    """Force of an effect that follows the drive alone: what it remembers at the end of the block; (points,) N on the
    half-step grid; and the derivatives, (values + 1 + p, points), by its own parameters, the gain and the history.

    `first`: whether the record begins here; `history`, (p,): what came before it added to the hidden states, (0,) if
    nothing did. The memory has tangents along those parameters that it depends on alone, and along the history.
    """
    names, bends = tuple(effect.values), shaping(effect)
    values = dict(effect.values)
    changed = lambda some: effect.with_values(**(values | dict(zip(bends, some, strict=True))))

    past = len(history)

    def begun(some: Array) -> Array:
        fresh = jnp.stack([jnp.asarray(h, float) for h in changed(some).begun(seen.first)])
        return fresh + history if past else fresh

    def along(some: Array, hidden: Array) -> tuple[Array, Array]:
        end, path = memory_along(changed(some), tuple(hidden), seen)
        return jnp.stack(end), jnp.stack(path)

    some = jnp.stack([jnp.asarray(values[name], float) for name in bends]) if bends else jnp.zeros(0)
    begin = begun(some)
    hidden = jnp.where(first > 0, begin, memory.hidden)
    axes = jnp.concatenate([jnp.eye(len(bends)), jnp.zeros((past, len(bends)))])
    if len(axes):
        by_value = [jax.jvp(begun, (some,), (axis,))[1] for axis in axes[: len(bends)]]
        bent = jnp.where(first > 0, jnp.stack([*by_value, *jnp.eye(past)]), memory.slopes)
        one = lambda axis, change: jax.jvp(along, (some, hidden), (axis, change))
        (end, path), (end_slopes, changes) = jax.vmap(one, out_axes=(None, 0))(axes, bent)
    else:
        (end, path), end_slopes, changes = along(some, hidden), memory.slopes, jnp.zeros((0, *hidden.shape))

    def acting(unknowns: Array, path: Array) -> Array:
        at = effect.with_values(**dict(zip(names, unknowns, strict=False)))
        drive = lambda u, r: Drive(u, r, seen.omega, unknowns[-1], seen.moving)
        one = lambda h, u, r, t: at.drive(tuple(h), drive(u, r), t)
        return jax.vmap(one, in_axes=(1, 0, 0, 0))(path, seen.voltage, seen.rate, seen.time)

    unknowns = jnp.stack([jnp.asarray(x, float) for x in (*values.values(), seen.gain)])
    slopes = []
    for i, axis in enumerate(jnp.eye(len(unknowns))):
        bend = names[i] if i < len(names) else ""
        change = changes[bends.index(bend)] if bend in bends else jnp.zeros_like(path)
        slopes.append(jax.jvp(acting, (unknowns, path), (axis, change))[1])
    still = jnp.zeros_like(unknowns)
    slopes += [jax.jvp(acting, (unknowns, path), (still, change))[1] for change in changes[len(bends) :]]
    return Remembered(end, end_slopes), acting(unknowns, path), jnp.stack(slopes)


def forgotten(effect: AbstractEffect, past: bool) -> tuple[Any, Any]:
    """Shapes of what an effect remembers: of `hidden` and of `slopes`; `past`, whether a history comes before."""
    size = len(effect.state0())
    return (size,), (len(shaping(effect)) + past * size, size)
