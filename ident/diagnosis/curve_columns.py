"""What a small change of a model would do to the points of sweeps, on the motion that was measured there.

At a measured point the stage moves, to first order, as Re(a e^{iωt}) with the a that was measured. A force of which the
model knows nothing is one that the drive need not bring along, and what a sensor adds is no motion:

    Û → (Û − δF₁/G + Û (ε Re ρ + i Im ρ))/(1 + δD₁/(G U)),  ρ = −δs₁/Y₁,  ε = d ln Û/d ln A

with the fundamentals of forces on the stage F₁, of what the actuator adds to the drive D₁ and of what the sensor adds
s₁. That holds however large an effect is.

Source: as of `columns`; W. Krack, J. Gross, Harmonic Balance for Nonlinear Vibration Problems, 2019, §2.4.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np

from ..effects.effect import State
from ..fit.curves import Curves
from ..fit.result import Solved
from ..programs import program
from ..response import Equation
from ..response.controlled import Controlled
from ..response.lane import Numbers
from ..response.memory import Seen, follows_drive_alone
from ..response.periodic import batches, bound, circle, joined
from ..response.steady_memory import driven_memory, steady_memory

_STEPS = 128  # of a period
_ROUNDING = 1e-9  # of a force: a smaller fundamental is none


def curve_order(solved: Solved) -> np.ndarray:
    """The numbers of the sweeps one sweep after another, where a fit has all amplitudes before all phases."""
    curves = solved.data.curves
    assert curves is not None
    return np.concatenate([curves.places(own) for own in curves.slices])


class Moves(NamedTuple):
    """What units of some parameters do, complex: to the `drives` that are needed, (d, points) V, and to the `shares` of
    the drive that the actuator gives; `beside`, (d, 2, points): to the drives at amplitudes larger and smaller by the
    noise."""

    drives: np.ndarray
    shares: np.ndarray
    beside: np.ndarray


@dataclass(frozen=True, eq=False)
class Plane:
    """The numbers of the sweeps while parameters move: the drives that the model needs move along straight lines.

        numbers = rows(ln((Û + Σ x_j Û_j)/(1 + Σ x_j κ_j)/U))

    What the noise does to them moves too: a drive that did not depend on the amplitude would say nothing of it, however
    well it agreed with the one that was measured.

    **Arguments:** `steady`: the model's responses with the measured amplitudes, and with those larger and smaller by
    the noise; `own`: what the model's own parameters do. What the actuator adds, κ_j, turns with the drive.
    """

    curves: Curves
    order: np.ndarray
    steady: tuple[Controlled, Controlled, Controlled]
    own: Moves

    @property
    def needed(self) -> np.ndarray:
        """(points,) the drive that the model needs, complex, relative to the response, V."""
        return self.steady[0].needed

    def weighed(self, drives: np.ndarray, beside: np.ndarray) -> Plane:
        """The same with the noise carried through a model that needs `drives` (points,), and `beside` (2, points) at
        the amplitudes beside."""
        return replace(self, curves=self.curves.with_deviations(np.log(beside / drives)))

    def left(self, drives: np.ndarray, shares: np.ndarray) -> np.ndarray:
        """(count,) measured − model in noise floors, if the model needs `drives` (points,) of an actuator that gives
        `shares` (points,) of what it did."""
        curves = self.curves
        ratio = drives / shares * (curves.measured / curves.points.amplitude) / curves.points.level
        turned = ratio * np.exp(1j * np.where(curves.phased, curves.phase, -np.angle(ratio)))
        return curves.rows(np.log(turned))[self.order]

    def slopes(self, drives: np.ndarray, shares: np.ndarray, moves: Moves) -> np.ndarray:
        """How `left` changes with moves of both, (d, count)."""
        return self.curves.rows(moves.drives / drives - moves.shares / shares)[:, self.order]


def plane_of(solved: Solved, directions: np.ndarray) -> Plane:
    """The plane of a fit whose own parameters move along directions (k, m)."""
    curves, steady = solved.data.curves, solved.found.steady
    assert curves is not None and steady is not None
    three = (steady, *curves.beside(steady))
    drives, *beside = (one.slopes(directions) for one in three)
    own = Moves(drives, np.zeros_like(drives), np.stack(beside, axis=1))
    return Plane(curves, curve_order(solved), three, own)


def curve_columns(plane: Plane, equation: Equation, values: np.ndarray, directions: np.ndarray) -> Moves:
    """What the terms of a model do to the points of a fit; `values` and `directions` (d, m) of each row."""
    (drives, shares), *beside = (_columns(one, equation, values, directions) for one in plane.steady)
    return Moves(drives, shares, np.stack([one for one, _ in beside], axis=1))


def _columns(
    steady: Controlled, equation: Equation, values: np.ndarray, directions: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Drives and shares of `Moves` at one amplitude of each point."""
    points = steady.points
    gain = float(steady.model.values[2] * steady.model.equation.constants[1])
    stretch = steady.by_amplitude * points.amplitude / steady.needed
    around = circle(_STEPS)
    at = (points.level, points.frequency, points.load, np.real(steady.tone), np.imag(steady.tone))
    drives, shares = [], []
    for value, direction in zip(values, directions, strict=True):
        found = []
        for own in batches(len(points.level)):
            said = terms_along(equation, equation.constants, value, direction, *(x[own] for x in at), around)
            found.append((said,))
        (real,) = joined(found, len(points.level))
        push, driven, shown = real[::2] + 1j * real[1::2]
        offset = -shown / steady.tone
        change = -push / (gain * steady.level) + stretch * offset.real + 1j * offset.imag
        drives.append(steady.needed * change)
        shares.append(driven / (gain * points.level))
    return np.array(drives), np.array(shares)


@program
def terms_along(
    equation: Equation, constants: Numbers, values: Numbers, direction: Numbers, level: Numbers,
    frequency: Numbers, load: Numbers, real: Numbers, imaginary: Numbers, circle: Numbers,
) -> Any:  # fmt: skip
    """Fundamentals of the forces on the stage and of those through the actuator, N, and of what the sensor adds, m, per
    unit of the direction: (6, points), real and imaginary part of each, relative to cos ωt."""

    def point(level: Any, frequency: Any, load: Any, real: Any, imaginary: Any) -> Any:
        def acting(values: Any) -> Any:
            system = bound(equation, constants, values, load, frequency)
            omega, step = system.omega, 2.0 / (frequency * (circle.shape[1] - 1))
            cosine, sine = circle
            z = real * cosine - imaginary * sine
            v = -omega * (real * sine + imaginary * cosine)
            voltage, rate, still = level * cosine, -level * omega * sine, 0.0 * cosine
            seen = Seen(z, v, voltage, rate, still, step, omega, jax.lax.stop_gradient(system.gain), 0.0)
            found = (0.0 * z + 0.0 * system.gain,) * 3
            for effect in system.effects:
                if follows_drive_alone(effect):
                    path = driven_memory(effect, system.gain, level, frequency, circle)
                else:
                    path = steady_memory(effect, lambda _: seen, jnp.zeros(0))
                one = lambda z, v, h, u, r, effect=effect: _of(effect, system.drive(u, r), z, v, h)
                said = jax.vmap(one, in_axes=(0, 0, 1 if effect.state0() else None, 0, 0))(z, v, path, voltage, rate)
                found = tuple(a + b for a, b in zip(found, said, strict=True))
            return found

        changed = jax.jvp(acting, (values,), (direction,))[1]
        return jnp.stack([part for x in changed for part in _fundamental(x, circle)])

    return jax.vmap(point, out_axes=-1)(level, frequency, load, real, imaginary)


def _of(effect: Any, drive: Any, z: Any, v: Any, hidden: Any) -> tuple[Any, Any, Any]:
    """Force of an effect on the stage and through the actuator, N, and what it adds to the reading, m."""
    state = State(z, v, tuple(hidden))
    force = effect.force(state, drive, 0.0) if effect.overrides("force") else 0.0
    driven = effect.drive(tuple(hidden), drive, 0.0) if effect.overrides("drive") else 0.0
    shown = effect.sensor(state, drive, 0.0) if effect.overrides("sensor") else 0.0
    return force + 0.0 * z, driven + 0.0 * z, shown + 0.0 * z


def _fundamental(x: Any, circle: Any) -> tuple[Any, Any]:
    n, (cosine, sine), x = circle.shape[1] - 1, circle[:, :-1], x[:-1]
    parts = 2 / n * jnp.sum(x * cosine), -2 / n * jnp.sum(x * sine)
    seen = jnp.hypot(*parts) > _ROUNDING * jnp.max(jnp.abs(x))  # a constant has none, but for rounding
    return jnp.where(seen, parts[0], 0.0), jnp.where(seen, parts[1], 0.0)
