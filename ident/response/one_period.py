"""One period of a model under a sine, and how it changes: by where it begins, and by any number in it.

    y_{i+1} = S_i(y_i),   A_i = ∂S_i/∂y_i,   ẏ = f(y, t; p),   b = ∂f/∂p δp

Along the start of the motion the solver's own steps are differentiated, a state's few directions at a time. What a
parameter changes is a force along the motion that is there already: it is asked for once a step, and not in each of the
four stages, and the A_i carry it on,

    x_{i+1} = A_i (x_i + h b_i),   δy_i = x_i + g_i,   g = ½ h b + h²/12 f_y b,   x_0 = −g_0

the trapezium rule with the first term of Euler's and Maclaurin's sum; the other one, −h²/12 ḃ, moves what b itself
drives, velocities and hidden states, by as much at the end of a period as at its beginning. Where the motion is smooth
that errs by h⁴, as the solver does, at the edges of a play by h². Parameters are many, states are few.

Source: A. H. Nayfeh, B. Balachandran, Applied Nonlinear Dynamics, 1995, §6.5; P. J. Davis, P. Rabinowitz, Methods of
Numerical Integration, 1984, §2.9 (the sum).
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jax import Array, lax

from ..effects.effect import AbstractEffect
from .lane import Numbers
from .runge_kutta import by_steps, runge_kutta, stages
from .steady_memory import driven_memory
from .system import Equation, System, assemble, derivative, reading, slices, tangents


def bound(equation: Equation, constants: Numbers, values: Numbers, load: Any, frequency: Any) -> System:
    """The system of a model under a sine of a frequency, Hz."""
    system = assemble(equation, constants, values)
    return system._replace(mass=system.mass + load, omega=2 * math.pi * frequency)


def circle(steps: int) -> np.ndarray:
    """Cosine and sine of a phase on the half-step grid of a period, (2, 2 steps + 1). They are given to the programs:
    XLA would compute them for every point again."""
    angle = np.pi / steps * np.arange(2 * steps + 1)
    return np.stack([np.cos(angle), np.sin(angle)])


def given_force(effect: AbstractEffect, system: System, path: Array, voltage: Any, rate: Any) -> Array:
    """(points,) N that an effect with hidden states (h, points) gives through the actuator."""
    acting = lambda h, u, r: effect.drive(tuple(h), system.drive(u, r), 0.0)
    return jax.vmap(acting, in_axes=(1 if effect.state0() else None, 0, 0))(path, voltage, rate)


class Driven(NamedTuple):
    """A model under U cos ωt: its `system`, in the solver's `step`, s; the `push`, (2 steps + 1,) N on the half-step
    grid, of the memories of the drive alone, which have settled before the motion begins; none where there are none."""

    system: System
    step: Any
    push: tuple[Any, ...]

    def slope(self, parts: tuple, y: tuple, at: tuple) -> tuple:
        """ẏ at `at` = (V, V̇, t, push)."""
        return derivative(self.system, parts, y, at)

    def inputs(self, level: Any, cosine: Any, sine: Any, push: tuple) -> tuple:
        """V, V̇, t and the push at a phase; clocks stand still at the switching-on."""
        return (level * cosine, -level * self.system.omega * sine, 0.0, *push)


def driven(
    equation: Equation, constants: Numbers, values: Any, level: Any, load: Any, share: Any, frequency: Any,
    circle: Numbers,
) -> Driven:  # fmt: skip
    """A model under a sine, of which the actuator gives a share."""
    step = 2.0 / (frequency * (circle.shape[1] - 1))
    system = bound(equation, constants, values, load, frequency).undispersed(step)._replace(share=share)
    forces = []
    for effect, own in zip(system.effects, slices(equation), strict=True):
        if own is None:
            path = driven_memory(effect, system.gain, level, frequency, circle)
            forces.append(given_force(effect, system, path, level * circle[0], -level * system.omega * circle[1]))
    return Driven(system, step, (sum(forces),) if forces else ())


class Path(NamedTuple):
    """A period, step by step: `state` (steps, n) and `shown` (steps,) at its beginning, the `end` (n,); `onward`
    (steps, n, n), what a step does to a change of the state; `seen` (steps, n), how the reading changes with it;
    `turn` (steps, n, n), how ẏ does, times the step."""

    state: Array
    shown: Array
    end: Array
    onward: Array
    seen: Array
    turn: Array


def march(equation: Equation, there: Driven, y: Array, level: Any, circle: Numbers) -> Path:
    """A period from the state `y`, (n,)."""
    parts, axes = slices(equation), jnp.eye(2 + equation.stepped)

    def ahead(y: tuple, x: tuple) -> tuple:
        at = [there.inputs(level, cosine, sine, tuple(push)) for cosine, sine, *push in stages(x)]
        slope = jax.jit(lambda y, now: there.slope(parts, y, now))  # traced once instead of four times
        first = slope(y, at[0])
        return runge_kutta(slope, y, at, there.step), reading(there.system, parts, y, at[0][:3], first[1]), first

    def advance(y: tuple, x: tuple) -> tuple:
        one = lambda axis: jax.jvp(lambda y: ahead(y, x), (y,), (tuple(axis),))
        (after, shown, _), (onward, seen, turn) = jax.vmap(one, out_axes=(None, 0))(axes)
        return after, (jnp.stack(y), shown, jnp.stack(onward), seen, there.step * jnp.stack(turn))

    # Cosine and sine are those of all points: only a remembered force has to be kept for each.
    inputs = by_steps((circle[0], circle[1], *there.push))
    end, (state, *slopes) = lax.scan(advance, tuple(y), inputs)
    shown, onward, seen, turn = slopes
    return Path(state, shown, jnp.stack(end), onward, seen, turn)


def step_by_step(equation: Equation, there: Driven, state: Array, level: Any, circle: Numbers) -> tuple[Array, Array]:
    """h ẏ, (steps, n), and readings, (steps,), of a motion `state`, (steps, n)."""
    parts = slices(equation)

    def at_step(y: Array, cosine: Any, sine: Any, *push: Any) -> tuple:
        at = there.inputs(level, cosine, sine, push)
        slope = there.slope(parts, tuple(y), at)
        return there.step * jnp.stack([jnp.asarray(k, float) for k in slope]), reading(
            there.system, parts, tuple(y), at[:3], slope[1]
        )

    return jax.vmap(at_step)(state, circle[0][:-1:2], circle[1][:-1:2], *(push[:-1:2] for push in there.push))


# Sums over the states as products of whole arrays: a contraction of so few numbers is a slow loop in XLA.
def _times(matrix: Array, x: Array) -> Array:
    return sum(matrix[:, j, None] * x[j] for j in range(len(x)))  # type: ignore[return-value]


def from_the_start(path: Path, units: Array) -> tuple[Array, Array]:
    """Changes of the end, (n, n, points), and of the readings, (steps, n, points), by the numbers of the state at the
    beginning, in `units` (n, points). The path has the points last, here and in `carried`."""

    def on(x: Array, now: tuple) -> tuple[Array, Array]:
        onward, seen = now
        return _times(onward, x), sum(seen[j] * x[j] for j in range(len(x)))  # type: ignore[return-value]

    end, readings = lax.scan(on, jnp.eye(len(units))[..., None] * units, (path.onward, path.seen))
    return jnp.swapaxes(end, 0, 1), readings


def carried(path: Path, push: Array, shown: Array) -> tuple[Array, Array]:
    """What changes of h ẏ, `push` (d, steps, n, points), and of the reading at a given motion, `shown` (d, steps,
    points), come to: changes of the end (d, n, points), and of the readings (steps, d, points)."""
    push, shown = jnp.moveaxis(push, (0, 2), (2, 1)), jnp.swapaxes(shown, 0, 1)  # (steps, n, d, points)
    after = lambda push, turn: 0.5 * push + _times(turn, push) / 12

    def on(x: Array, now: tuple) -> tuple[Array, Array]:
        onward, seen, turn, push, shown = now
        here = x + after(push, turn)
        return _times(onward, x + push), shown + sum(seen[j] * here[j] for j in range(len(x)))

    first = after(push[0], path.turn[0])
    end, readings = lax.scan(on, -first, (path.onward, path.seen, path.turn, push, shown))
    return jnp.swapaxes(end + first, 0, 1), readings


def tones(shown: Array, slopes: Array, circle: Any) -> tuple[Array, Array]:
    """Real and imaginary part of the fundamental relative to cos ωt, and half the peak-to-peak value, (3, points), of
    readings (steps, points); and their derivatives (3, d, points) by the readings' (steps, d, points)."""
    cosine, sine = circle[:, :-1:2]
    weights = 2.0 / len(cosine) * jnp.stack([cosine, -sine])
    (top, top_slope), (bottom, bottom_slope) = _peak(shown, slopes), _peak(-shown, -slopes)
    both = jnp.concatenate([jnp.tensordot(weights, shown, 1), 0.5 * (top + bottom)[None]])
    swing = 0.5 * (top_slope + bottom_slope)
    return both, jnp.concatenate([jnp.tensordot(weights, slopes, 1), swing[None]])


def _peak(shown: Array, slopes: Array) -> tuple[Array, Array]:
    """The highest points of periodic curves, by the parabola through the highest sample and its neighbours, (points,);
    and their derivatives (d, points)."""
    highest = jnp.argmax(shown, axis=0)
    rows = [(highest + i) % shown.shape[0] for i in (-1, 0, 1)]
    near = [jnp.take_along_axis(shown, row[None], 0)[0] for row in rows]
    near_slopes = [jnp.take_along_axis(slopes, row[None, None], 0)[0] for row in rows]
    return tangents(_vertex, tuple(near), tuple(near_slopes))


def _vertex(before: Any, here: Any, after: Any) -> Any:
    bend = before - 2 * here + after
    return here - (after - before) ** 2 / (8 * jnp.where(bend < 0, bend, -jnp.inf))
