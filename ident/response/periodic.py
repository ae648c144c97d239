"""One period of a model under a sine: where the state ends, what the sensor shows, and how both change.

    V = U cos ωt,   y = (z, ż, hidden …),   y(T) = Φ(y(0); s, f, parameters),   T = 1/f

The hidden states of y are those that see the motion; what follows the drive alone has settled (`steady_memory`). The
force of the actuator acts with a share s of itself, one in the device.

A steady response is a fixed point of Φ. Everything that is asked about steady responses, their branches, their
stability and their derivatives, is asked through this one program; `look` runs it for many points side by side. Clocks
stand still at the switching-on: a drift has no steady response, and none is simulated.

Source: A. H. Nayfeh, B. Balachandran, Applied Nonlinear Dynamics, 1995, §3.2 (Floquet theory), §6.5 (shooting).
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jax import Array, lax

from ..effects.effect import AbstractEffect, State
from ..programs import Program, program
from .lane import Numbers
from .memory import Seen
from .runge_kutta import runge_kutta, stages, steps_of
from .steady_memory import driven_memory, steady_memory
from .system import Equation, System, assemble, derivative, reading, slices, tangents

SHARE, FREQUENCY = -2, -1  # places of s and f in the unknowns w = (y, s, f) of a point
POINTS = 32  # looked at side by side: one program for any number of them
_WIDTHS = (4, 8, 12, 16)  # directions of one look along values; along unknowns as many as a search takes
_STEPS = (64, 96, 128, 256)  # of the solver per period


def steps_per_period(finest: int, allowed: float) -> int:
    """Solver steps per period with which the method's error moves the response by less than `allowed` of itself.

    What `undispersed` leaves of it is θ⁴/40, whatever the quality and the nonlinearity; `finest`: what the sharpest
    effect of the model needs.
    """
    needed = max(2 * math.pi / (40 * allowed) ** 0.25, finest)
    return next((n for n in _STEPS if n >= needed), _STEPS[-1])


def batches(count: int) -> list[np.ndarray]:
    """Points as a program takes them, the last one again where there are too few."""
    return [np.minimum(np.arange(first, first + POINTS), count - 1) for first in range(0, count, POINTS)]


def joined(found: list[tuple], count: int) -> list[np.ndarray]:
    """What a program said of all batches, points last."""
    return [np.concatenate(part, axis=-1)[..., :count] for part in zip(*found, strict=True)]


class Seat(NamedTuple):
    """What a look needs to know of its points besides the unknowns: `level` (points,), V, `load` (points,), kg, and the
    `scale`, (points, n + 2), in which unknowns are counted."""

    level: np.ndarray
    load: np.ndarray
    scale: np.ndarray

    def some(self, rows: np.ndarray) -> Seat:
        """That of some points."""
        return Seat(*(part[rows] for part in self))


class Look(NamedTuple):
    """What one period says, per point.

    **Arguments:** `miss`: (points, n) Φ(y) − y; `tone`: (points,) complex fundamental of the reading, relative to the
    drive; `swing`: (points,) half its peak-to-peak value, m; and the same with a leading axis of directions, the
    derivatives along them.
    """

    miss: np.ndarray
    tone: np.ndarray
    swing: np.ndarray
    miss_slope: np.ndarray
    tone_slope: np.ndarray
    swing_slope: np.ndarray

    def moved(self, step: np.ndarray) -> Look:
        """What it shows after steps (points, d) along its directions, to first order."""
        tone = self.tone + np.einsum("pk,kp->p", step, self.tone_slope)
        return self._replace(tone=tone, swing=self.swing + np.einsum("pk,kp->p", step, self.swing_slope))

    def put(self, rows: np.ndarray, other: Look) -> None:
        """Take over some points from another look along the same directions."""
        for part, new in zip(self[:3], other[:3], strict=True):
            part[rows] = new
        for part, new in zip(self[3:], other[3:], strict=True):
            part[:, rows] = new


def empty_look(points: int, n: int, directions: int) -> Look:
    """A look that has seen nothing yet."""
    one, along = (points,), (directions, points)
    return Look(np.zeros((points, n)), np.zeros(one, complex), np.zeros(one),
                np.zeros((directions, points, n)), np.zeros(along, complex), np.zeros(along))  # fmt: skip


@dataclass(frozen=True, eq=False)
class Periodic:
    """A model with its values (m,) SI, ready to be looked at; `steps` of the solver per period."""

    equation: Equation
    values: np.ndarray
    steps: int

    @property
    def size(self) -> int:
        """Numbers in the state y."""
        return 2 + self.equation.stepped

    @property
    def circle(self) -> np.ndarray:
        """Cosine and sine of the phase on the half-step grid, (2, 2 steps + 1)."""
        return circle(self.steps)

    def look(self, unknowns: np.ndarray, seat: Seat, along: np.ndarray) -> Look:
        """One period from `unknowns` (points, n + 2), and how it changes along directions (d, n + 2) of them, in units
        of the seat's scale."""
        return self._seen(by_unknowns, unknowns, seat, along, (min(self.size + 1, _WIDTHS[-1]),))

    def look_by_values(self, unknowns: np.ndarray, seat: Seat, directions: np.ndarray) -> Look:
        """The same along directions (d, m) of the values."""
        return self._seen(by_values, unknowns, seat, directions, _WIDTHS)

    def _seen(
        self, program: Program, unknowns: np.ndarray, seat: Seat, along: np.ndarray, widths: tuple[int, ...]
    ) -> Look:
        d = len(along)
        width = next((w for w in widths if w >= d), widths[-1])
        if d > width:  # more directions than one program takes
            parts = [self._seen(program, unknowns, seat, part, widths) for part in (along[:width], along[width:])]
            return Look(*parts[0][:3], *(np.concatenate([part[k] for part in parts]) for k in range(3, 6)))
        along = np.concatenate([along, np.zeros((width - d, along.shape[1]))])
        found = []
        for rows in batches(len(unknowns)):
            arrays = (self.values, unknowns[rows], along, *seat.some(rows), self.circle)
            found.append(program(self.equation, self.equation.constants, *arrays))
        miss, slope, shown, shown_slope = joined(found, len(unknowns))
        tone, tone_slope = shown[0] + 1j * shown[1], shown_slope[0] + 1j * shown_slope[1]
        return Look(miss.T, tone, shown[2], np.moveaxis(slope, 0, 2)[:d], tone_slope[:d], shown_slope[2, :d])


def bound(equation: Equation, constants: Numbers, values: Numbers, load: Any, frequency: Any) -> System:
    """The system of a model under a sine of a frequency, Hz."""
    system = assemble(equation, constants, values)
    return system._replace(mass=system.mass + load, omega=2 * math.pi * frequency)


def undispersed(system: System, step: Any) -> System:
    """The system that the solver, in steps h, integrates as the given one: what steps of fourth order do to an
    oscillation of frequency ω, θ = ωh, is to slow it by θ⁴/120 and to damp it by ω θ⁵/144, and is taken off."""
    theta = system.omega * step
    mass = system.mass / (1 + theta**4 / 60)
    return system._replace(mass=mass, damping=system.damping - mass * system.omega * theta**5 / 72)


def circle(steps: int) -> np.ndarray:
    """Cosine and sine of a phase on the half-step grid of a period, (2, 2 steps + 1). They are given to the programs:
    XLA would compute them for every point again."""
    angle = np.pi / steps * np.arange(2 * steps + 1)
    return np.stack([np.cos(angle), np.sin(angle)])


def one_period(equation: Equation, system: System, y: Any, level: Any, frequency: Any, circle: Any) -> tuple[Any, Any]:
    """The state after a period, (n,), and the readings at the beginning of each step, (steps,).

    A memory of the drive alone has settled before the motion begins: it is part of the force.
    """
    parts = slices(equation)
    step = 2.0 / (frequency * (circle.shape[1] - 1))
    system = undispersed(system, step)
    forces = []
    for effect, own in zip(system.effects, parts, strict=True):
        if own is None:
            path = driven_memory(effect, system.gain, level, frequency, circle)
            forces.append(_given(effect, system, path, level * circle[0], -level * system.omega * circle[1]))
    # Cosine and sine are those of all points: only a remembered force has to be kept for each.
    grids = (circle[0], circle[1], *((sum(forces),) if forces else ()))

    def advance(state: tuple, x: Any) -> tuple:
        at = [(level * cosine, -level * system.omega * sine, 0.0, *push) for cosine, sine, *push in stages(x)]
        slope = jax.jit(lambda y, now: derivative(system, parts, y, now))  # traced once instead of four times
        shown = reading(system, parts, state, at[0][:3], slope(state, at[0])[1])
        return runge_kutta(slope, state, at, step), shown

    after, shown = lax.scan(advance, tuple(y), steps_of(grids))
    return jnp.stack(after), shown


def _given(effect: AbstractEffect, system: System, path: Array, voltage: Any, rate: Any) -> Array:
    """(points,) N that an effect with hidden states (h, points) gives through the actuator."""
    acting = lambda h, u, r: effect.drive(tuple(h), system.drive(u, r), 0.0)
    return jax.vmap(acting, in_axes=(1 if effect.state0() else None, 0, 0))(path, voltage, rate)


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


@program
def by_unknowns(
    equation: Equation, constants: Numbers, values: Numbers, unknowns: Numbers, along: Numbers, level: Numbers,
    load: Numbers, scale: Numbers, circle: Numbers,
) -> tuple:  # fmt: skip
    """`Periodic.look` of one set of points, points last."""
    kicks = jnp.asarray(scale).T
    there = lambda w: _all_points(equation, constants, values, w, level, load, circle)
    points = jnp.asarray(unknowns).T
    ahead = lambda kick: jax.jvp(there, (points,), (kick[:, None] * kicks,))
    (end, shown), (slope, shown_slope) = jax.vmap(ahead, out_axes=(None, 1))(along)
    own = jnp.asarray(along)[:, :SHARE].T[..., None] * kicks[:SHARE, None]
    return end - points[:SHARE], slope - own, *tones(shown, shown_slope, circle)


@program
def by_values(
    equation: Equation, constants: Numbers, values: Numbers, unknowns: Numbers, directions: Numbers, level: Numbers,
    load: Numbers, scale: Numbers, circle: Numbers,
) -> tuple:  # fmt: skip
    """`Periodic.look_by_values` of one set of points, points last."""
    points = jnp.asarray(unknowns).T
    there = lambda values: _all_points(equation, constants, values, points, level, load, circle)
    ahead = lambda change: jax.jvp(there, (values,), (change,))
    (end, shown), (slope, shown_slope) = jax.vmap(ahead, out_axes=(None, 1))(directions)
    return end - points[:SHARE], slope, *tones(shown, shown_slope, circle)


def _all_points(
    equation: Equation, constants: Numbers, values: Any, unknowns: Any, level: Any, load: Any, circle: Any
) -> tuple:
    """State after a period and readings of points (n + 2, points). They are the last axis of everything, tangents too:
    so they fill the processor's vector units."""

    def one(w: Any, level: Any, load: Any) -> tuple:
        system = bound(equation, constants, values, load, w[FREQUENCY])._replace(share=w[SHARE])
        return one_period(equation, system, w[:SHARE], level, w[FREQUENCY], circle)

    return jax.vmap(one, in_axes=-1, out_axes=-1)(unknowns, level, load)


class Ride(NamedTuple):
    """Hidden states at the beginning of a period; complex fundamentals of the `force` that the stage needs to move
    along a given motion, of the force that the actuator has `given`, N, and of what the sensor has `added`, m, relative
    to the drive; per point."""

    hidden: np.ndarray
    force: np.ndarray
    given: np.ndarray
    added: np.ndarray


def ride(model: Periodic, level: np.ndarray, frequency: np.ndarray, load: np.ndarray, motion: np.ndarray) -> Ride:
    """What the model's memories are, and what force it needs, if the stage moves as Re(a e^{iωt}) under U cos ωt.

    **Arguments:** `motion`: (points,) complex a, m.

    **Returns:** hidden states at t = 0, (points, n − 2), as they have settled; and the fundamentals of M z̈ −
    F(z, ż, hidden) with the voltage at zero and of the actuator's force, N.
    """
    found = []
    for rows in batches(len(level)):
        arrays = (level[rows], frequency[rows], load[rows], np.real(motion)[rows], np.imag(motion)[rows], model.circle)
        found.append(along_motion(model.equation, model.equation.constants, model.values, *arrays))
    hidden, real, imaginary, push, turn, shown, across = joined(found, len(level))
    return Ride(hidden.T, real + 1j * imaginary, push + 1j * turn, shown + 1j * across)


@program
def along_motion(
    equation: Equation, constants: Numbers, values: Numbers, level: Numbers, frequency: Numbers, load: Numbers,
    real: Numbers, imaginary: Numbers, circle: Numbers,
) -> tuple:  # fmt: skip
    """`ride` of one set of points, points last."""

    def point(level: Any, frequency: Any, load: Any, real: Any, imaginary: Any) -> tuple:
        system = bound(equation, constants, values, load, frequency)
        step = 2.0 / (frequency * (circle.shape[1] - 1))
        omega, (cosine, sine) = system.omega, circle
        z = real * cosine - imaginary * sine
        v = -omega * (real * sine + imaginary * cosine)
        voltage, rate, still = level * cosine, -level * omega * sine, 0.0 * cosine
        seen = Seen(z, v, voltage, rate, still, step, omega, system.gain, 0.0)
        hidden, acting, given, added = [], 0.0 * z, system.gain * voltage, 0.0 * z
        for effect, own in zip(system.effects, slices(equation), strict=True):
            if own is None:
                given = given + _given(
                    effect, system, driven_memory(effect, system.gain, level, frequency, circle), voltage, rate
                )
                continue
            path = steady_memory(effect, lambda _: seen, jnp.zeros(0))
            hidden += list(path[:, 0])
            if effect.overrides("drive"):
                given = given + _given(effect, system, path, voltage, rate)
            if effect.overrides("force"):
                off = system.drive(0.0, 0.0)
                one = lambda z, v, h, effect=effect, off=off: effect.force(State(z, v, tuple(h)), off, 0.0)
                acting = acting + jax.vmap(one, in_axes=(0, 0, 1 if len(path) else None))(z, v, path)
            if effect.overrides("sensor"):
                shown = lambda z, v, h, u, r, effect=effect: effect.sensor(
                    State(z, v, tuple(h)), system.drive(u, r), 0.0
                )
                axes = (0, 0, 1 if len(path) else None, 0, 0)
                added = added + jax.vmap(shown, in_axes=axes)(z, v, path, voltage, rate)
        n = circle.shape[1] - 1
        line = lambda x: (2 / n * jnp.sum(x * cosine[:-1]), -2 / n * jnp.sum(x * sine[:-1]))
        (push, turn), spring = line(acting[:-1]), system.stiffness - system.mass * omega**2
        needed = (spring * real - omega * system.damping * imaginary - push,
                  spring * imaginary + omega * system.damping * real - turn)  # fmt: skip
        return jnp.stack(hidden) if hidden else jnp.zeros(0), *needed, *line(given[:-1]), *line(added[:-1])

    return jax.vmap(point, out_axes=-1)(level, frequency, load, real, imaginary)
