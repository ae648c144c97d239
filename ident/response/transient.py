"""Transient response: fixed-step Runge–Kutta of order 4 in one scan, driven by the measured voltage.

One lane is one record. The carry is a tuple of scalars, so that XLA keeps the whole loop in registers. Forces of the
momentary drive are computed in the loop too: read from memory, with their tangents, they would cost more. Those that
remember the drive are integrated before it (`memory`).

Source: E. Hairer, S. P. Nørsett, G. Wanner, Solving Ordinary Differential Equations I, 1993, §II.1.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
from jax import Array, lax

from ..effects.effect import AbstractEffect, Drive, State
from ..model import Model
from .lane import Lane, Numbers, half_step_time
from .memory import follows_drive_alone, remembered_force
from .runge_kutta import runge_kutta, stages, steps_of


@dataclass(frozen=True, eq=False)
class Equation:
    """A model as a static argument of compiled code: two are equal if they compile to the same program."""

    model: Model

    def __hash__(self) -> int:
        return hash(self.model.key)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Equation) and self.model.key == other.model.key


class System(NamedTuple):
    """Everything that is constant along one trajectory; `slices`: each effect's part of the hidden states, None if it
    follows the drive alone and is integrated before the motion."""

    effects: tuple[AbstractEffect, ...]
    slices: tuple[slice | None, ...]
    mass: Any
    damping: Any
    stiffness: Any
    gain: Any
    omega: Any
    moving: Any

    def drive(self, voltage: Any, rate: Any) -> Drive:
        """The drive as the effects see it."""
        return Drive(voltage, rate, self.omega, self.gain, self.moving)


def simulate(equation: Equation, substeps: int, values: Array, start: Numbers, lane: Lane) -> Array:
    """Sensor reading at the samples of one record.

    **Arguments:** `substeps`, solver steps per sample; `values`, (p,) physical parameters in the order of
    `model.parameters`; `start`, (2,) displacement and velocity at the first sample; `lane`, the record.

    **Returns:** (n / substeps + 1,) m.
    """
    system = assemble(equation, values, lane)
    half_time = half_step_time(lane)
    whole_state = any(effect.overrides("sensor") for effect in system.effects)
    path = integrate(system, substeps, start, lane, half_time, whole_state)
    return _reading(system, path, lane, half_time, 2 * substeps)


def integrate(
    system: System, substeps: int, start: Numbers, lane: Lane, half_time: Array, whole_state: bool = True
) -> tuple[Array, ...]:
    """State (z, v, hidden …) at the samples, or z alone; each (n / substeps + 1,)."""
    grids: tuple[Numbers, ...] = (lane.voltage, lane.rate, half_time)
    before = [effect for effect, own in zip(system.effects, system.slices, strict=True) if own is None]
    if before:
        forces = [remembered_force(effect, system.gain, system.omega, lane) for effect in before]
        grids += (jnp.sum(jnp.stack(forces), axis=0),)
    # Adding a zero that depends on the parameters gives the carry the type it will have under differentiation.
    nothing = 0.0 * system.stiffness
    drive = system.drive(jnp.asarray(lane.voltage)[0], jnp.asarray(lane.rate)[0])
    memory = (h for effect in system.effects if effect not in before for h in effect.begun(drive))
    carry = tuple(x + nothing for x in (start[0], start[1], *memory))

    slope = jax.jit(partial(derivative, system))  # traced once instead of four times

    def advance(y: tuple[Array, ...], x: Any) -> tuple[tuple[Array, ...], Any]:
        y = runge_kutta(slope, y, stages(x), lane.step)
        return y, (y if whole_state else y[:1])

    _, path = lax.scan(advance, carry, steps_of(grids))
    return tuple(jnp.concatenate([a[None], b[substeps - 1 :: substeps]]) for a, b in zip(carry, path, strict=False))


def assemble(equation: Equation, values: Numbers, lane: Lane) -> System:
    """Bind parameter values, (m,) SI, to the equation of motion of one record."""
    (frequency, quality, gain), effects = equation.model.bind(values)
    linear = equation.model.linear
    stiffness, damping = equation.model.spring_and_damper(frequency, quality)
    slices: list[slice | None] = []
    first = 0
    for effect in effects:
        if follows_drive_alone(effect):
            slices.append(None)
            continue
        slices.append(slice(first, first + len(effect.state0())))
        first += len(effect.state0())
    return System(
        effects,
        tuple(slices),
        linear.mass + lane.load,
        damping,
        stiffness,
        linear.force_per_gain * gain,
        lane.omega,
        lane.moving,
    )


def derivative(system: System, y: tuple[Array, ...], at: tuple[Array, ...]) -> tuple[Array, ...]:
    """(ż, v̇, hidden rates) of the state `y` at `at` = (V, V̇, t), and the remembered force if there is one."""
    voltage, rate, t, *remembered = at
    z, v, *hidden = y
    drive = system.drive(voltage, rate)
    force, rates = sum(remembered, system.gain * voltage - system.damping * v - system.stiffness * z), []
    for effect, own in zip(system.effects, system.slices, strict=True):
        if own is None:
            continue
        memory = tuple(hidden[own])
        state = State(z, v, memory)
        if effect.overrides("force"):
            force = force + effect.force(state, drive, t)
        if effect.overrides("drive"):
            force = force + effect.drive(memory, drive, t)
        if memory:
            rates += effect.rate(state, drive, t)
    return (v, force / system.mass, *rates)


def _reading(system: System, path: tuple[Array, ...], lane: Lane, half_time: Array, stride: int) -> Array:
    reading = path[0]
    voltage, rate, time = (grid[::stride] for grid in (lane.voltage, lane.rate, half_time))
    for effect, own in zip(system.effects, system.slices, strict=True):
        if own is not None and effect.overrides("sensor"):
            hidden = tuple(path[2:][own])
            one = lambda z, v, h, u, r, t, effect=effect: effect.sensor(State(z, v, h), system.drive(u, r), t)
            reading = reading + jax.vmap(one)(path[0], path[1], hidden, voltage, rate, time)
    return reading


def simulate_group(equation: Equation, substeps: int, values: Array, starts: Numbers, lanes: Lane) -> Array:
    """Sensor readings of records of equal length: `starts` (lanes, 2), every field of `lanes` with a leading axis."""
    return jax.vmap(partial(simulate, equation, substeps, values))(starts, lanes)
