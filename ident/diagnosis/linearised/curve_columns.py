"""What a small change of a model would do to the points of sweeps, on the motion that was measured there.

At a measured point the stage moves, to first order, as Re(a e^{iωt}) with the a that was measured. A force of which the
model knows nothing is one that the drive need not bring along, and what a sensor adds is no motion:

    Û → (Û − δF₁/G − (ε − 1) Û Re ρ)/(1 + δD₁/(G U) + s ρ),  ρ = δs₁/Y₁,  ε = d ln Û/d ln A

with the fundamentals of forces on the stage F₁, of what the actuator adds to the drive D₁ and of what the sensor adds
s₁, and the share s that the model needs. That holds however large an effect is; what a sensor adds, as long as the
stage is linear (ε = 1): it then reads s times the sum of what the drive does to stage and sensor.

The mean and the overtones of a force move the stage too, and on that motion the force has a further fundamental, which
grows with the square of its size. Of an even force (z², V z), which has no other, it is all that curves show; beside an
odd part it may be the greater (stressed beams that soften):

    δF₁ = ½ ∂²/∂x² [F(x, z + x δz)]₁,   δz = Σ_{k ≠ 1} Y(kω) [∂F/∂x]_k

with the linear part's answer Y. Of an effect with several amplitudes each pair has such a term: the mean of one moves
the stage to where another acts. Where harmonics were measured, Y(kω) F_k and what the sensor adds at kω
are what a candidate does to them. What acts on drive or reading has its square too: a lag τ turns them by −iωτ, which
no amplitude shows, and makes them smaller by −ω²τ². These are the leading terms; the refit knows the rest.

Source: as of `columns`; W. Krack, J. Gross, Harmonic Balance for Nonlinear Vibration Problems, 2019, §2.4; A. H.
Nayfeh, D. T. Mook, Nonlinear Oscillations, 1979, §2.3.1 (the frequency that a quadratic spring shifts).
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np

from ...effects.effect import AbstractEffect, State
from ...fit.curves import Curves
from ...fit.result import Solved
from ...model import GAIN
from ...programs import program
from ...response import Equation
from ...response.controlled import Controlled
from ...response.lane import Numbers
from ...response.memory import Seen, follows_drive_alone, shaping
from ...response.one_period import bound, circle
from ...response.periodic import batches, joined
from ...response.steady_memory import driven_memory, steady_memory

_STEPS = 128  # of a period
_ROUNDING = 1e-9  # of a force: a smaller fundamental is none
_ORDERS = (0, *range(2, 9))  # of the overtones that an even force is followed to
_ANGLE = np.pi / _STEPS * np.arange(2 * _STEPS + 1)


def curve_order(solved: Solved) -> np.ndarray:
    """The numbers of the sweeps one sweep after another, where a fit has all amplitudes before all phases."""
    curves = solved.data.curves
    assert curves is not None
    return np.concatenate([curves.places(own) for own in curves.slices])


_BENT = ("bends", "share_bends", "beside_bends")


class Moves(NamedTuple):
    """What units of some parameters do, complex: to the `drives` that are needed, (d, points) V, with `bends`, (d, q,
    points), what a product with each of the q amplitudes of the same effect does; to the `shares` of the drive that the
    actuator gives, with `share_bends`; `beside`, (d, 2, points), and `beside_bends`, (d, q, 2, points): as `drives` and
    `bends`, at amplitudes larger and smaller by the noise; to the harmonics that were measured, `heard` (d, orders,
    points) m."""

    drives: np.ndarray
    bends: np.ndarray
    shares: np.ndarray
    share_bends: np.ndarray
    beside: np.ndarray
    beside_bends: np.ndarray
    heard: np.ndarray

    def scaled(self, units: np.ndarray) -> Moves:
        """The same per so many units (d,) of each parameter, the last of which are the q amplitudes; what is no number
        counts as nothing."""
        pairs = units[:, None] * units[len(units) - self.bends.shape[1] :]
        turned = lambda part, by: np.nan_to_num(part) * by.reshape(*by.shape, *[1] * (part.ndim - by.ndim))
        powers = (units, pairs, units, pairs, units, pairs, units)
        return Moves(*(turned(part, by) for part, by in zip(self, powers, strict=True)))

    def rows(self, which: slice | np.ndarray) -> Moves:
        """Those of some of the parameters."""
        return Moves(*(part[which] for part in self))

    def among(self, some: np.ndarray) -> Moves:
        """Those of some of the amplitudes of one effect, the others at zero."""
        few = self.rows(some)
        return few._replace(**{name: getattr(few, name)[:, some] for name in _BENT})

    def beside_others(self, own: Moves) -> Moves:
        """These after those of other parameters, which move the drives along straight lines."""
        q = self.bends.shape[1]
        straight = lambda part: np.zeros((len(part), q, *part.shape[2:]), complex)
        own = own._replace(**{name: straight(getattr(own, name)) for name in _BENT})
        return Moves(*(np.concatenate(pair) for pair in zip(own, self, strict=True)))


@dataclass(frozen=True, eq=False)
class Plane:
    """The numbers of the sweeps while parameters move: the drives that the model needs move along straight lines, with
    the amplitudes of an effect along parabolas.

        numbers = rows(ln((Û + Σ x_j Û_j + Σ x_j x_k Û_jk)/(1 + Σ x_j κ_j + Σ x_j x_k κ_jk)/U))

    What the noise does to them moves too: a drive that did not depend on the amplitude would say nothing of it, however
    well it agreed with the one that was measured.

    **Arguments:** `steady`: the model's responses with the measured amplitudes, and with those larger and smaller by
    the noise; `own`: what the model's own parameters do; `heard`: (orders, points) its harmonics, m. What the actuator
    adds, κ_j, turns with the drive.
    """

    curves: Curves
    order: np.ndarray
    steady: tuple[Controlled, Controlled, Controlled]
    own: Moves
    heard: np.ndarray

    @property
    def needed(self) -> np.ndarray:
        """(points,) the drive that the model needs, complex, relative to the response, V."""
        return self.steady[0].needed

    def weighed(self, drives: np.ndarray, beside: np.ndarray) -> Plane:
        """The same with the noise carried through a model that needs `drives` (points,), and `beside` (2, points) at
        the amplitudes beside."""
        return replace(self, curves=self.curves.with_deviations(np.log(beside / drives)))

    def left(self, drives: np.ndarray, shares: np.ndarray, heard: np.ndarray) -> np.ndarray:
        """(count,) measured − model in noise floors, if the model needs `drives` (points,) of an actuator that gives
        `shares` (points,) of what it did, and has harmonics `heard`."""
        curves = self.curves
        ratio = drives / shares * (curves.measured / curves.points.amplitude) / curves.points.level
        turned = ratio * np.exp(1j * np.where(curves.phased, curves.phase, -np.angle(ratio)))
        rows, n = curves.rows(np.log(turned)), curves.heard.count
        if n:
            rows[-n:] = -curves.heard.residuals(heard)
        return rows[self.order]

    def slopes(self, drives: np.ndarray, shares: np.ndarray, heard: np.ndarray, moves: Moves) -> np.ndarray:
        """How `left` changes with moves of all, (d, count)."""
        rows, n = self.curves.rows(moves.drives / drives - moves.shares / shares), self.curves.heard.count
        if n:
            rows[:, -n:] = -self.curves.heard.slopes(heard, np.moveaxis(moves.heard, 1, 0))
        return rows[:, self.order]


def plane_of(solved: Solved, directions: np.ndarray) -> Plane:
    """The plane of a fit whose own parameters move along directions (k, m)."""
    curves, steady = solved.data.curves, solved.found.steady
    assert curves is not None and steady is not None
    three = (steady, *curves.beside(steady))
    drives, *beside = (one.slopes(directions) for one in three)
    none, around = np.zeros_like(drives), np.stack(beside, axis=1)
    straight, straight_around = none[:, None][:, :0], around[:, None][:, :0]
    orders, n = curves.heard.orders, len(drives)
    heard, change = np.zeros((0, drives.shape[1])), np.zeros((n, 0, drives.shape[1]))
    if orders:
        heard, change = steady.overtones(orders), np.moveaxis(steady.overtone_slopes(orders, directions), 0, 1)
    own = Moves(drives, straight, none, straight, around, straight_around, change)
    return Plane(curves, curve_order(solved), three, own, heard)


def curve_columns(plane: Plane, equation: Equation, values: np.ndarray, directions: np.ndarray) -> Moves:
    """What the terms of a model do to the points of a fit: at each of several `values` (p, m) along the same
    `directions` (q, m) of amplitudes, what is remembered being that of the given shapes; p q rows, those of one place
    one after another.

    At the smaller amplitudes they do what a straight line through the two others says, which the noise is small for.
    """
    here, above, below = plane.steady
    orders = plane.curves.heard.orders
    drives, bends, shares, share_bends, heard = _columns(here, equation, values, directions, orders)
    more, more_bends, *_ = _columns(above, equation, values, directions, orders)
    size, up, down = (one.points.amplitude for one in plane.steady)
    ratio = (size - down) / (up - size)
    around, bent = (np.stack([b, a - ratio * (b - a)], axis=-2) for a, b in ((drives, more), (bends, more_bends)))
    return Moves(drives, bends, shares, share_bends, around, bent, heard)


def _columns(
    steady: Controlled, equation: Equation, values: np.ndarray, directions: np.ndarray, orders: tuple[int, ...]
) -> tuple[np.ndarray, ...]:
    """Drives, shares, the bends of both, and what is `heard`, of `Moves`, at one amplitude of each point."""
    points = steady.points
    gain = float(steady.model.values[GAIN] * steady.model.equation.constants[1])
    stretch = steady.by_amplitude * points.amplitude / steady.needed
    around, q, k = circle(_STEPS), len(directions), np.array(orders, float)
    at = (points.level, points.frequency, points.load, np.real(steady.tone), np.imag(steady.tone))
    parts: list[tuple[np.ndarray, ...]] = []
    for value in values:
        found = []
        for own in batches(len(points.level)):
            said = terms_along(equation, equation.constants, value, directions, *(x[own] for x in at), around, k)
            found.append((said,))
        (real,) = joined(found, len(points.level))
        push, driven, shown, *bent, heard = np.split(
            real[::2] + 1j * real[1::2], [q, 2 * q, 3 * q, (3 + q) * q, (3 + 2 * q) * q, 3 * (1 + q) * q]
        )
        push_bent, driven_bent, shown_bent = (part.reshape(q, q, -1) for part in bent)
        past, by_force = shown / steady.tone, -1.0 / (gain * steady.share * points.level)
        past_bent = shown_bent / steady.tone
        by_past = -steady.needed * (stretch - 1.0)
        # Where amplitude and share are asked for together, a larger share goes with a smaller amplitude.
        across = lambda x: x - points.tilt * stretch * x.real
        parts.append((
            steady.needed * across(by_force * push) + by_past * past.real,
            steady.needed * across(by_force * push_bent) + by_past * np.real(past_bent - 0.5 * past[:, None] * past),
            across(driven / (gain * points.level)) + steady.share * past,
            across(driven_bent / (gain * points.level)) + steady.share * past_bent,
            heard.reshape(q, len(orders), len(points.level)),
        ))  # fmt: skip
    return tuple(np.concatenate(part) for part in zip(*parts, strict=True))


@program
def terms_along(
    equation: Equation, constants: Numbers, values: Numbers, directions: Numbers, level: Numbers,
    frequency: Numbers, load: Numbers, real: Numbers, imaginary: Numbers, circle: Numbers, orders: Numbers,
) -> Any:  # fmt: skip
    """Fundamentals of the forces on the stage and of those through the actuator, N, and of what the sensor adds, m, per
    unit of each of q directions, and of the three per product of each two; then k harmonics of the reading per unit of
    each: (2 (3 q + 3 q² + q k), points), real and imaginary part of each, relative to cos ωt."""

    def point(level: Any, frequency: Any, load: Any, real: Any, imaginary: Any) -> Any:
        cosine, sine = circle
        system = bound(equation, constants, values, load, frequency)
        omega, step = system.omega, 2.0 / (frequency * (circle.shape[1] - 1))
        z = real * cosine - imaginary * sine
        v = -omega * (real * sine + imaginary * cosine)

        def acting(x: Any, off: Any, drift: Any, swing: Any) -> Any:
            system = bound(equation, constants, values + x @ directions, load, frequency)
            voltage, rate, still = level * cosine, -level * omega * sine, 0.0 * cosine
            seen = Seen(z, v, voltage, rate, still, step, omega, jax.lax.stop_gradient(system.gain), 0.0)
            found = (0.0 * z + 0.0 * system.gain,) * 3
            for effect in system.effects:
                if effect.overrides("settled") and follows_drive_alone(effect):
                    path = driven_memory(effect, system.gain, level, frequency, circle)
                else:
                    path = steady_memory(effect, lambda _: seen, jnp.zeros(0), _bending(effect))
                one = lambda z, v, a, h, u, r, effect=effect: _of(effect, system.drive(u, r), z, v, a, h)
                said = jax.vmap(one, in_axes=(0, 0, 0, 1 if effect.state0() else None, 0, 0))(
                    z + off, v + drift, swing - omega**2 * z, path, voltage, rate
                )
                found = tuple(a + b for a, b in zip(found, said, strict=True))
            return found

        still, axes = jnp.zeros_like(z), jnp.eye(len(directions))
        one = lambda axis, x, *off: jax.jvp(lambda x: acting(x, *off), (x,), (axis,))[1]
        along = lambda *at: jax.vmap(lambda axis: one(axis, *at))(axes)
        changed, further = jax.linearize(along, 0.0 * axes[0], still, still, still)  # what remembers is followed once
        force = changed[0] + changed[1]
        answers = jax.vmap(lambda force: _overtones(force, system))(force)
        bent = jax.vmap(lambda axis, *off: further(0.5 * axis, *off))(axes, *answers)
        told = jnp.concatenate([*changed, *(part.reshape(-1, len(z)) for part in bent)])
        first = jax.vmap(lambda x: jnp.stack(_fundamental(x, circle)))(told).reshape(-1)
        return jnp.concatenate([first, _harmonics(answers[0] + changed[2], orders).reshape(-1)])

    return jax.vmap(point, out_axes=-1)(level, frequency, load, real, imaginary)


def _bending(effect: AbstractEffect) -> tuple[str, ...]:
    """Names of the amplitudes on which the memory of an effect depends."""
    if not effect.state0():
        return ()
    return tuple(p.name for p in effect.declared() if p.kind == "amplitude" and p.name in shaping(effect))


def _of(effect: Any, drive: Any, z: Any, v: Any, a: Any, hidden: Any) -> tuple[Any, Any, Any]:
    """Force of an effect on the stage, which accelerates by `a`, and through the actuator, N, and what it adds to the
    reading, m."""
    state = State(z, v, tuple(hidden))
    force = effect.force(state, drive, 0.0) if effect.overrides("force") else 0.0
    force = force - effect.inertia(z) * a if effect.overrides("inertia") else force
    driven = effect.drive(tuple(hidden), drive, 0.0) if effect.overrides("drive") else 0.0
    shown = effect.sensor(state, drive, 0.0) if effect.overrides("sensor") else 0.0
    return force + 0.0 * z, driven + 0.0 * z, shown + 0.0 * z


def _overtones(force: Any, system: Any) -> tuple[Any, Any, Any]:
    """Displacement, velocity and acceleration with which the linear part answers the mean and the overtones of a force,
    on the half-step grid."""
    z, v, swing = 0.0 * force, 0.0 * force, 0.0 * force
    for k in _ORDERS:
        cosine, sine = np.cos(k * _ANGLE), np.sin(k * _ANGLE)
        share = (1.0 if k == 0 else 2.0) / (len(_ANGLE) - 1)
        a, b = share * jnp.sum(force[:-1] * cosine[:-1]), -share * jnp.sum(force[:-1] * sine[:-1])
        spring, damper = system.stiffness - system.mass * (k * system.omega) ** 2, k * system.omega * system.damping
        size = spring**2 + damper**2
        give = jnp.where(size > 0, 1.0 / jnp.where(size > 0, size, 1.0), 0.0)  # without a spring a mean has no answer
        a, b = give * (a * spring + b * damper), give * (b * spring - a * damper)
        line = a * cosine - b * sine
        z, v, swing = z + line, v - k * system.omega * (a * sine + b * cosine), swing - (k * system.omega) ** 2 * line
    return z, v, swing


def _harmonics(x: Any, orders: Any) -> Any:
    """Real and imaginary parts of harmonics of signals (q, points), (q, k, 2)."""
    angle = orders[:, None] * _ANGLE[:-1]
    waves = 2.0 / (len(_ANGLE) - 1) * jnp.stack([jnp.cos(angle), -jnp.sin(angle)], axis=1)  # (k, 2, points)
    return jnp.tensordot(x[:, :-1], waves, axes=[[1], [2]])


def _fundamental(x: Any, circle: Any) -> tuple[Any, Any]:
    n, (cosine, sine), x = circle.shape[1] - 1, circle[:, :-1], x[:-1]
    parts = 2 / n * jnp.sum(x * cosine), -2 / n * jnp.sum(x * sine)
    seen = jnp.hypot(*parts) > _ROUNDING * jnp.max(jnp.abs(x))  # a constant has none, but for rounding
    return jnp.where(seen, parts[0], 0.0), jnp.where(seen, parts[1], 0.0)
