"""Steps that are divided where the motion meets the kink of a law: where friction turns, or a stop is hit.

What a step can miss at a kink is told by the forces of the laws that have one, at the four states of the method: where
these change, or bend, the step is tried whole and as two halves. If their ends differ by more than is allowed, a half
is tried in the same way, and so on until a part is short enough; the next part is tried twice as long. So a kink is
closed in by halving, and away from its kinks a law costs what a smooth one does. Steps in which friction sticks are all
tried so, for of those no state of the method tells anything.

Where friction sticks the motion creeps over a slope so steep that the method is not stable in any step that is worth
taking: the velocity would tremble, unseen, and its derivatives grow without bound. There it is stepped implicitly.

Source: E. Hairer, S. P. Nørsett, G. Wanner, Solving Ordinary Differential Equations I, 1993, §II.4 (step doubling) and
§II.6 (discontinuities); E. Hairer, G. Wanner, the same II, 1996, §IV.2 (stability) and §IV.7 (linearly implicit Euler).
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any

import jax
import jax.numpy as jnp
from jax import Array, lax

from .lane import Numbers
from .runge_kutta import runge_kutta
from .system import System, accelerated, derivative

SHORTEST = 1 / 256
"""Part of a step: ten thousand in a period of the resonance, if the step is one of `model.COARSE`."""


STIFF = 2.5  # of velocity, in a step: the method is stable to 2.78
SHARP = 0.03  # of a change of force, by which slopes may miss it: else the stages are too far apart
_BEYOND = 1.2  # of a step: it ends where Euler's only nearly does
_HALVINGS = 20  # of what a step changes the velocity: the turn of a friction is no steeper than a millionth of that


def _alone(system: System, slots: tuple[slice | None, ...], z: Any) -> tuple[System, tuple[slice | None, ...]]:
    """The effects with kinks, and nothing else but the mass that moves at a displacement."""
    own = [i for i, effect in enumerate(system.effects) if effect.has_kink]
    alone = system._replace(effects=tuple(system.effects[i] for i in own), damping=0.0, stiffness=0.0)
    # A base that does not move takes the push of the drive away, and leaves the gain to laws that need it.
    alone = alone._replace(mass=system.moved(z), base=0.0 if system.base is None else system.base)
    return alone, tuple(slots[i] for i in own)


def sticks(system: System, slots: tuple[slice | None, ...], y: tuple[Array, ...], at: tuple[Any, ...], h: Any) -> Array:
    """Whether the forces with kinks hold the velocity of the state `y` so hard that a step `h` is not stable."""
    alone, places = _alone(system, slots, y[0])
    by_velocity = lambda v: accelerated(alone, places, (y[0], v, *y[2:]), at[:3])
    return -h * _with_slope(by_velocity, y[1])[1] > STIFF


def _with_slope(f: Callable[[Array], Array], x: Array) -> tuple[Array, Array]:
    return jax.jvp(f, (x,), (jnp.ones_like(x),))


def _standstill(
    system: System, slots: tuple[slice | None, ...], y: tuple[Array, ...], at: tuple[Any, ...], h: Any, pushed: Any
) -> Array:
    """The velocity from which to look whether friction sticks: that of the state, or, where the forces with kinks turn
    on the way to the end of the step and turn the motion back, that of the implicit Euler step between the two.

    v' = v + h (a + k(v') − k(v)), with k the acceleration by the forces with kinks; `pushed` a, that by all, at v. An
    explicit step beyond a turn that is steeper than it is long would fall back, and tremble ever after.
    """
    alone, places = _alone(system, slots, y[0])
    kinked = lambda v: accelerated(alone, places, (y[0], v, *y[2:]), at[:3])
    own = kinked(y[1])
    end = y[1] + h * pushed
    back = jnp.abs(kinked(end) - own) > jnp.abs(pushed)

    def between_them() -> Array:
        def halve(_: Any, ends: tuple[Array, Array]) -> tuple[Array, Array]:
            near, far = ends
            middle = 0.5 * (near + far)
            ahead = (y[1] + h * (pushed + kinked(middle) - own) - middle) * (end - y[1]) > 0
            return jnp.where(ahead, middle, near), jnp.where(ahead, far, middle)

        near, far = lax.fori_loop(0, _HALVINGS, halve, (y[1], end))
        return 0.5 * (near + far)

    return lax.cond(back, between_them, lambda: y[1])


def advanced(
    system: System, slots: tuple[slice | None, ...], y: tuple[Array, ...], at: list[tuple[Any, ...]], h: Any,
    can_stick: bool, told_apart: bool = True,
) -> tuple[Array, ...]:  # fmt: skip
    """The state after a step `h` with the inputs `at` its beginning, middle and end; without `told_apart` its
    derivatives are not those of a turn.

    Where friction sticks the velocity goes by a linearly implicit step to where forces balance, and all else moves with
    that. It is one method whose velocity is held or not, so that the laws are compiled once.
    """
    slope = jax.jit(partial(derivative, system, slots))  # traced once instead of four times
    if not can_stick:
        return runge_kutta(slope, y, at, h)
    acceleration = slope(y, at[2])[1]
    here = lax.stop_gradient(_standstill(system, slots, y, at[2], h, acceleration))
    steep = lambda v: sticks(system, slots, (y[0], v, *y[2:]), at[2], h)
    held = steep(here)

    def balanced() -> Array:
        by_velocity = lambda v: slope((y[0], v, *y[2:]), at[2])[1]
        acceleration, steep = _with_slope(by_velocity, here)
        return here + (y[1] - here + h * acceleration) / (1.0 - h * steep)

    v = lax.cond(held, balanced, lambda: y[1])
    still = held & steep(lax.stop_gradient(v))  # else it is passing by
    v = jnp.where(still, v, y[1])
    turn = _Turn(system, slots, y, at, h, slope(y, at[0])[1])
    turns = ~still & turn.unseen if told_apart else None

    def moved(s: tuple[Array, ...], u: tuple[Any, ...]) -> tuple[Array, ...]:
        pace = jnp.where(still, v, s[1])
        _, acceleration, *rates = slope((s[0], pace, *s[2:]), u)
        if turns is not None:
            acceleration = acceleration + jnp.where(turns, turn.nothing((s[0], pace, *s[2:]), u), 0.0)
        return pace, jnp.where(still, 0.0, acceleration), *rates

    z, after, *rest = runge_kutta(moved, (y[0], v, *y[2:]), at, h)
    return z, after if turns is None else turn.told(after, turns), *rest


class _Turn:
    """What a friction that turns within a step does to derivatives: no state of the method sees it, or one does, many
    times too steep.

    What two motions differ by before, v₀, they differ by after as the accelerations are, a₊/a₋ = 1 + Δk/a₋, for the
    one that comes later turns later: the factor of saltation (R. I. Leine, H. Nijmeijer, Dynamics and Bifurcations of
    Non-Smooth Mechanical Systems, 2004, §7.3), which holds for a turn of any steepness, as dv₁/dv₀ = a(v₁)/a(v₀) along
    any v̇ = a(v). All velocities are those against what carries the stage.
    """

    def __init__(
        self, system: System, slots: tuple[slice | None, ...], y: tuple[Array, ...], at: Any, h: Any, acceleration: Any
    ):
        self.alone, self.places = _alone(system, slots, y[0])
        self.standing = self.alone._replace(base=lax.stop_gradient(self.alone.base))
        self.h, self.y = h, y
        first, self.middle, last = (one[:3] for one in at)
        self.base = 0.0 if system.base is None else system.base
        self.before, self.end = y[1] - self.base * first[1], last[1]
        self.pushed = acceleration - self.base * (last[1] - first[1]) / h

    def _at(self, pace: Array) -> Array:
        """Acceleration by the forces with kinks at a velocity in the middle of the step."""
        v = pace + lax.stop_gradient(self.base) * self.middle[1]
        return accelerated(self.standing, self.places, (self.y[0], v, *self.y[2:]), self.middle)

    @property
    def unseen(self) -> Array:
        """Whether a force turns on the way to the end of the step, or a little beyond, more sharply than its slopes at
        both ends and between them tell, by Simpson's rule: as the stages weigh them."""
        change = _BEYOND * jnp.asarray(self.pushed * self.h, float)
        (first, rise), (last, fall) = (_with_slope(self._at, self.before + far * change) for far in (0.0, 1.0))
        between = _with_slope(self._at, self.before + 0.5 * change)[1]
        missed = last - first - (rise + 4 * between + fall) / 6 * change
        return jnp.abs(missed) > SHARP * jnp.abs(last - first)

    def nothing(self, s: tuple[Array, ...], u: tuple[Any, ...]) -> Array:
        """Zero, whose derivatives take those of the turn away."""
        z, v, *hidden = s
        without = accelerated(self.standing, self.places, (z, lax.stop_gradient(v), *hidden), u[:3])
        return without - accelerated(self.alone, self.places, s, u[:3])

    def told(self, after: Array, turns: Array) -> Array:
        """The velocity `after` the step, its derivatives those of the turn."""
        fixed, end = lax.stop_gradient, after - self.base * self.end
        jump = self._at(end) - self._at(self.before)
        factor = jnp.clip(jump / jnp.where(turns, self.pushed, 1.0), -1.0, 1.0)  # friction turns no motion round
        share = jnp.clip(self.before / jnp.where(self.before == end, 1.0, self.before - end), 0.0, 1.0)
        at_turn = self.before + fixed(share) * (end - self.before)
        return after + fixed(jnp.where(turns, factor, 0.0)) * (at_turn - fixed(at_turn))


def bend(system: System, slots: tuple[slice | None, ...], states: Any, inputs: Any, h: Numbers) -> Array:
    """Change of velocity, m/s, by which a step `h` may be wrong: that by what the forces with kinks, at the four
    `states` and inputs, say beyond a straight line."""
    alone, places = _alone(system, slots, states[0][0])
    a, b, c, d = (accelerated(alone, places, y, at[:3]) for y, at in zip(states, inputs, strict=True))
    return h / 6 * jnp.abs(a - b - c + d)


def turned(system: System, slots: tuple[slice | None, ...], states: Any, inputs: Any, h: Numbers, least: Any) -> Array:
    """Whether the forces with kinks turn within a step as the velocity does, by more than the `least` change of that,
    or by more than it changes, as of `bend`: they may turn it back, and where it turns in the middle of the step, or
    goes to and fro over a turn, the bends cancel."""
    alone, places = _alone(system, slots, states[0][0])
    first, last = (accelerated(alone, places, states[i], inputs[i][:3]) for i in (0, 3))
    before, after = (system.apart(*states[i][:2], *inputs[i][:2])[1] for i in (0, 3))
    jump = h * jnp.abs(last - first)
    return (jump > jnp.abs(after - before)) | ((before * after < 0) & (jump > least))


def limits_of(system: System, allowed: Any) -> tuple[Array, Array]:
    """The rate, 1/s, that makes of a change of velocity the one of displacement to which it leads, and the change of
    displacement, m, that is `allowed` of what is measured."""
    rate = jnp.sqrt(jnp.abs(system.stiffness) / system.mass) + jnp.abs(system.damping) / system.mass
    return rate, allowed / rate**system.order


Stepped = Callable[[tuple[Array, ...], list[tuple[Any, ...]], Any], tuple[Array, ...]]
"""The state after a step from one, with the inputs at its beginning, middle and end, and its length."""


def halved(
    stepped: Stepped, y: tuple[Array, ...], grids: tuple[Any, ...], h: Numbers, first: Any, length: Any, limits: Any
) -> Any:
    """A part of a step `h` that is short enough, in lengths of it: the given one, or a half of it, or a quarter …

    **Arguments:** `y`, the state at its beginning `first`; `grids`, the inputs at beginning, middle and end of the
    step; `limits`, as of `limits_of`.
    """
    rate, allowed = limits

    def misses(length: Any) -> Any:
        def attempt(k: Any, ends: tuple[tuple[Array, ...], tuple[Array, ...]]) -> Any:
            whole, halves = ends
            begun, share = jnp.where(k == 2, 0.5, 0.0), jnp.where(k == 0, 1.0, 0.5)
            begin = tuple(jnp.where(k == 2, b, a) for a, b in zip(y, halves, strict=True))
            end = stepped(begin, between(grids, first + begun * length, share * length), h * share * length)
            kept = lambda old, now: tuple(jnp.where(now, a, b) for a, b in zip(end, old, strict=True))
            return kept(whole, k == 0), kept(halves, k > 0)

        whole, halves = lax.fori_loop(0, 3, attempt, (y, y))  # a loop, so that the laws are compiled once
        missed = jnp.maximum(jnp.abs(whole[0] - halves[0]), jnp.abs(whole[1] - halves[1]) / rate)
        return ~(missed <= allowed)  # also where it is no number

    def half(state: tuple[Any, Any]) -> tuple[Any, Any]:
        length, _ = state
        length = jnp.where(misses(length), 0.5 * length, length)
        return length, (length < state[0]) & (length > SHORTEST)

    return lax.while_loop(lambda state: state[1], half, (length, length > SHORTEST))[0]


def between(grids: tuple[Any, ...], first: Any, length: Any) -> list[tuple[Any, ...]]:
    """Inputs at beginning, middle and end of a part of a step, in lengths of it, by parabolas through the step's."""
    return [tuple(_parabola(grid, first + share * length) for grid in grids) for share in (0.0, 0.5, 1.0)]


def _parabola(grid: tuple[Any, Any, Any], s: Any) -> Any:
    a, b, c = grid
    return a * (1 - s) * (1 - 2 * s) + 4 * b * s * (1 - s) + c * s * (2 * s - 1)
