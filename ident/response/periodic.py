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

from ..effects.effect import State
from ..programs import program
from .lane import Numbers
from .memory import Seen
from .one_period import Driven, bound, carried, circle, driven, from_the_start, given_force, march, step_by_step, tones
from .steady_memory import driven_memory, steady_memory
from .system import Equation, slices, tangents
from .transient import filled

SHARE, FREQUENCY = -2, -1  # places of s and f in the unknowns w = (y, s, f) of a point
BY_SHARE, BY_FREQUENCY = (1.0, 0.0), (0.0, 1.0)  # ways in the plane of s and f
POINTS = 32  # looked at side by side: one program for any number of them
_WIDTHS = (4, 8, 12, 16)  # directions of one look along values
_STEPS = (48, 64, 96, 128, 256)  # of the solver per period


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

    def beside(self, other: Look) -> Look:
        """The same with the directions of another look at the same points after its own."""
        slopes = (np.concatenate(both) for both in zip(self[3:], other[3:], strict=True))
        return Look(*self[:3], *slopes)

    def along(self, directions: slice) -> Look:
        """The same along some of its directions."""
        return Look(*self[:3], *(part[directions] for part in self[3:]))

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

    def overtones(
        self, orders: tuple[int, ...], unknowns: np.ndarray, seat: Seat, directions: np.ndarray | None = None
    ) -> tuple[np.ndarray, np.ndarray]:
        """Harmonics of the reading, (orders, points) complex relative to the drive, and how they change by each number
        of the state and by the share, in units of the seat's scale, and then along `directions` (q, m) of the values,
        (orders, d, points)."""
        q, n = 0 if directions is None else len(directions), self.size
        angle = 2 * np.pi * np.outer(orders, np.arange(self.steps)) / self.steps
        waves = 2.0 / self.steps * np.concatenate([np.cos(angle), -np.sin(angle)])
        width = next((w for w in _WIDTHS if w >= q), q)
        given = None if directions is None else filled(directions, width)
        found = []
        for rows in batches(len(unknowns)):
            arrays = (self.values, unknowns[rows], np.array(BY_SHARE), given, *seat.some(rows), self.circle, waves)
            found.append(one_look_of_overtones(self.equation, self.equation.constants, *arrays))
        heard, slopes = joined(found, len(unknowns))
        k = len(orders)
        return heard[:k] + 1j * heard[k:], (slopes[:k] + 1j * slopes[k:])[:, : n + 1 + q]

    def look(
        self, unknowns: np.ndarray, seat: Seat, way: tuple[float, float], directions: np.ndarray | None = None
    ) -> Look:
        """One period from `unknowns` (points, n + 2), and how it changes by each number of the state, along a `way` in
        the plane of s and f, all in units of the seat's scale, and then, if they are given, along `directions` (q, m)
        of the values."""
        q, n, given = 0, self.size, None
        if directions is not None:
            q = min(len(directions), _WIDTHS[-1])
            given = filled(directions[:q], next(w for w in _WIDTHS if w >= q))
        found = []
        for rows in batches(len(unknowns)):
            arrays = (self.values, unknowns[rows], np.array(way), given, *seat.some(rows), self.circle)
            found.append(one_look(self.equation, self.equation.constants, *arrays))
        miss, slope, shown, shown_slope = joined(found, len(unknowns))
        tone, tone_slope = shown[0] + 1j * shown[1], shown_slope[0] + 1j * shown_slope[1]
        own = Look(miss.T, tone, shown[2], np.swapaxes(slope, 1, 2), tone_slope, shown_slope[2])
        own = own.along(slice(n + 1 + q))
        if directions is None or q == len(directions):
            return own
        return own.beside(self.look(unknowns, seat, way, directions[q:]).along(slice(n + 1, None)))


@program
def one_look(
    equation: Equation, constants: Numbers, values: Numbers, unknowns: Numbers, way: Numbers,
    directions: Numbers | None, level: Numbers, load: Numbers, scale: Numbers, circle: Numbers,
) -> tuple:  # fmt: skip
    """`Periodic.look` of one set of points, points last."""
    start, path, slope, readings = _period(
        equation, constants, values, unknowns, way, directions, level, load, scale, circle
    )
    return path.end - start, slope, *tones(path.shown, readings, circle)


@program
def one_look_of_overtones(
    equation: Equation, constants: Numbers, values: Numbers, unknowns: Numbers, way: Numbers,
    directions: Numbers | None, level: Numbers, load: Numbers, scale: Numbers, circle: Numbers, waves: Numbers,
) -> tuple:  # fmt: skip
    """Projections of the reading on `waves`, (k, steps), (k, points), and their derivatives as `Periodic.look` has
    them, (k, d, points)."""
    _, path, _, readings = _period(equation, constants, values, unknowns, way, directions, level, load, scale, circle)
    return jnp.tensordot(waves, path.shown, 1), jnp.tensordot(waves, readings, 1)


def _period(
    equation: Equation, constants: Numbers, values: Numbers, unknowns: Numbers, way: Numbers,
    directions: Numbers | None, level: Numbers, load: Numbers, scale: Numbers, circle: Numbers,
) -> tuple:  # fmt: skip
    """The beginning of a period, what it is step by step, and how its end and the readings change. Points are the last
    axis of everything, tangents too: so they fill the processor's vector units."""
    points, units = jnp.asarray(unknowns).T, jnp.asarray(scale).T
    each = lambda function, *parts: jax.vmap(function, in_axes=-1, out_axes=-1)(*parts)
    start, rest = points[:SHARE], points[SHARE:]

    def there(values: Any, rest: Any, level: Any, load: Any) -> Driven:
        return driven(equation, constants, values, level, load, rest[0], rest[1], circle)

    go = lambda y, rest, u, m: march(equation, there(values, rest, u, m), y, u, circle)
    path = each(go, start, rest, level, load)

    def moving(rest: Any, values: Any) -> tuple:
        one = lambda y, rest, u, m: step_by_step(equation, there(values, rest, u, m), y, u, circle)
        return each(one, path.state, rest, level, load)

    changes = [tangents(lambda rest: moving(rest, values), (rest,), (way[None, :, None] * units[None, SHARE:],))[1]]
    if directions is not None:
        changes.append(tangents(lambda values: moving(rest, values), (values,), (directions,))[1])
    own, told = from_the_start(path, units[:SHARE])
    by_rest, seen = carried(path, *(jnp.concatenate(parts) for parts in zip(*changes, strict=True)))
    slope = jnp.concatenate([own - jnp.eye(len(start))[..., None] * units[:SHARE], by_rest])
    readings = jnp.concatenate([told, seen], axis=1)
    return start, path, slope, readings


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
                given = given + given_force(
                    effect, system, driven_memory(effect, system.gain, level, frequency, circle), voltage, rate
                )
                continue
            path = steady_memory(effect, lambda _: seen, jnp.zeros(0))
            hidden += list(path[:, 0])
            if effect.overrides("drive"):
                given = given + given_force(effect, system, path, voltage, rate)
            if effect.overrides("force"):
                off = system.drive(0.0, 0.0)
                one = lambda z, v, h, effect=effect, off=off: effect.force(State(z, v, tuple(h)), off, 0.0)
                acting = acting + jax.vmap(one, in_axes=(0, 0, 1 if len(path) else None))(z, v, path)
            if effect.overrides("inertia"):
                acting = acting + effect.inertia(z) * omega**2 * z
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
