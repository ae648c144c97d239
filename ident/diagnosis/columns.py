"""What a small change of a model would add to the readings, evaluated along the trajectory that was measured.

If the true motion is z and the model's is ẑ, their difference obeys the model's own linearised dynamics, driven by what
the model lacks, evaluated on z. For a linear model this is exact however large the missing effect; the rows below are
therefore good regressors for effects that no local expansion around the wrong model would describe.

Source: C. R. Rao, Large sample tests of statistical hypotheses, 1948, Proc. Camb. Phil. Soc. 44 (score test); the
evaluation on the measured motion follows S. F. Masri, T. K. Caughey, 1979, J. Appl. Mech. 46 (restoring force surface).
"""

from __future__ import annotations

from typing import Any

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jax import Array, lax

from ..effects.effect import State
from ..response import Equation
from ..response.lane import Lane, Numbers, half_step_time
from ..response.memory import memory_along
from ..response.transient import System, assemble
from .trajectory import Path

_CHUNK = 32  # columns solved together: one compiled program serves any number of them


@eqx.filter_jit
def contributions(
    equation: Equation, substeps: int, values: Numbers, directions: Numbers, lanes: Lane, path: Path, seen: Path
) -> tuple[Array, Array]:
    """What the terms of a model change in the force on the stage and in the sensor, along given motions.

    **Arguments:** `values` and `directions`, (d, m): at which parameter values, and along which direction, each row is
    taken; `path` of the stage and what the sensor has `seen`, each (lanes, 2 n + 1).

    **Returns:** forces (d, lanes, 2 n + 1), N, and readings (d, lanes, samples), m, per unit of the direction.
    """

    def one(lane: Lane, path: Path, seen: Path) -> tuple[Array, Array]:
        def acting(values: Array) -> tuple[Array, Array]:
            system = assemble(equation, values, lane)
            return _force(system, lane, path), _readings(system, lane, seen, 2 * substeps)

        return jax.vmap(lambda at, along: jax.jvp(acting, (at,), (along,))[1])(values, directions)

    return jax.vmap(one, out_axes=1)(lanes, path, seen)


@eqx.filter_jit
def _responses(equation: Equation, substeps: int, values: Numbers, pushes: Numbers, lanes: Lane, path: Path) -> Array:
    def one(lane: Lane, path: Path, push: Numbers) -> Array:
        system = assemble(equation, values, lane)
        z, v = _respond(push / system.mass, *_linearised(system, lane, path), lane.step, substeps)
        by_z, by_v = _sensor_slopes(system, lane, path, 2 * substeps)
        return by_z * z + by_v * v

    return jax.vmap(one, in_axes=(0, 0, 1), out_axes=1)(lanes, path, pushes)


def push_columns(
    equation: Equation, substeps: int, values: np.ndarray, pushes: np.ndarray, lanes: Lane, path: Path
) -> np.ndarray:
    """Change of the readings by given extra forces on the stage, through the model's dynamics linearised on the motion.

    **Arguments:** `values`, (m,) SI; `pushes`, (d, lanes, 2 n + 1) N on the half-step grid.

    **Returns:** (d, lanes, samples), m.
    """
    pushes, found = np.asarray(pushes), []
    for first in range(0, len(pushes), _CHUNK):
        part = pushes[first : first + _CHUNK]
        padded = np.zeros((_CHUNK, *part.shape[1:]))
        padded[: len(part)] = part
        found.append(np.asarray(_responses(equation, substeps, values, padded, lanes, path))[: len(part)])
    return np.concatenate(found)


def _hidden(system: System, lane: Lane, path: Path) -> tuple[tuple[Array, ...], ...]:
    """Each effect's hidden states along a given motion, on the half-step grid."""
    return tuple(memory_along(effect, system.gain, system.omega, lane, path.z, path.v) for effect in system.effects)


def _force(system: System, lane: Lane, path: Path) -> Array:
    """Total force on the stage on a given motion, on the half-step grid."""
    time = half_step_time(lane)
    force = system.gain * lane.voltage - system.damping * path.v - system.stiffness * path.z
    for effect, hidden in zip(system.effects, _hidden(system, lane, path), strict=True):
        if effect.overrides("force"):
            one = lambda z, v, h, u, r, t, e=effect: e.force(State(z, v, h), system.drive(u, r), t)
            force = force + jax.vmap(one)(path.z, path.v, hidden, lane.voltage, lane.rate, time)
        if effect.overrides("drive"):
            one = lambda h, u, r, t, e=effect: e.drive(h, system.drive(u, r), t)
            force = force + jax.vmap(one)(hidden, lane.voltage, lane.rate, time)
    return force


def _readings(system: System, lane: Lane, path: Path, stride: int) -> Array:
    """What the effects add to the reading of a given motion, at the samples."""
    time = half_step_time(lane)
    added = jnp.zeros_like(time[::stride])
    for effect, hidden in zip(system.effects, _hidden(system, lane, path), strict=True):
        if effect.overrides("sensor"):
            one = lambda z, v, h, u, r, t, e=effect: e.sensor(State(z, v, h), system.drive(u, r), t)
            arguments = (path.z, path.v, hidden, lane.voltage, lane.rate, time)
            added = added + jax.vmap(one)(*jax.tree.map(lambda x: x[::stride], arguments))
    return added


def _linearised(system: System, lane: Lane, path: Path) -> tuple[Array, Array]:
    """−∂a/∂z and −∂a/∂v along the motion, hidden states held."""
    time = half_step_time(lane)

    def acceleration(z: Array, v: Array, hidden: Any, u: Array, r: Array, t: Array) -> Array:
        drive = system.drive(u, r)
        force = -system.damping * v - system.stiffness * z
        for effect, own in zip(system.effects, hidden, strict=True):
            if effect.overrides("force"):
                force = force + effect.force(State(z, v, own), drive, t)
        return -force / system.mass

    both = jax.vmap(jax.jacfwd(acceleration, argnums=(0, 1)))
    return both(path.z, path.v, _hidden(system, lane, path), lane.voltage, lane.rate, time)


def _sensor_slopes(system: System, lane: Lane, path: Path, stride: int) -> tuple[Array, Array]:
    """∂(reading)/∂z and ∂(reading)/∂v at the samples."""
    time = half_step_time(lane)

    def reading(z: Array, v: Array, hidden: Any, u: Array, r: Array, t: Array) -> Array:
        drive = system.drive(u, r)
        extra = [
            effect.sensor(State(z, v, own), drive, t)
            for effect, own in zip(system.effects, hidden, strict=True)
            if effect.overrides("sensor")
        ]
        return z + sum(extra, 0.0 * v)

    arguments = (path.z, path.v, _hidden(system, lane, path), lane.voltage, lane.rate, time)
    return jax.vmap(jax.jacfwd(reading, argnums=(0, 1)))(*jax.tree.map(lambda x: x[::stride], arguments))


def _respond(push: Array, stiffness: Array, damping: Array, h: Numbers, substeps: int) -> tuple[Array, Array]:
    """Linear time-varying response to (d, 2 n + 1) accelerations, at rest before; (d, samples) each."""
    grids = (push.T, stiffness, damping)
    inputs = tuple((grid[:-1:2], grid[1::2], grid[2::2]) for grid in grids)

    def step(y: tuple[Array, Array], x: Any) -> tuple[tuple[Array, Array], tuple[Array, Array]]:
        (p0, pm, p1), (k0, km, k1), (c0, cm, c1) = x
        z, v = y
        a1 = p0 - k0 * z - c0 * v
        za, va = z + h / 2 * v, v + h / 2 * a1
        a2 = pm - km * za - cm * va
        zb, vb = z + h / 2 * va, v + h / 2 * a2
        a3 = pm - km * zb - cm * vb
        zc, vc = z + h * vb, v + h * a3
        a4 = p1 - k1 * zc - c1 * vc
        y = (z + h / 6 * (v + 2 * va + 2 * vb + vc), v + h / 6 * (a1 + 2 * a2 + 2 * a3 + a4))
        return y, y

    rest = jnp.zeros_like(push[:, 0])
    _, (z, v) = lax.scan(step, (rest, rest), inputs)
    thin = lambda x: jnp.concatenate([rest[:, None], x[substeps - 1 :: substeps].T], axis=1)
    return thin(z), thin(v)
