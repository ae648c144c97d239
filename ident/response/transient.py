"""Transient response: fixed-step Runge–Kutta of order 4 in one scan, driven by the measured voltage.

One lane is one record. The carry is a tuple of scalars, so that XLA keeps the whole loop in registers. Forces that
depend on the drive alone are computed in the loop too: read from memory, with their tangents, they would cost more.

Source: E. Hairer, S. P. Nørsett, G. Wanner, Solving Ordinary Differential Equations I, 1993, §II.1.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jax import Array, lax

from ..effects.effect import AbstractEffect, Drive, State
from ..model import Model

Numbers = Array | np.ndarray


@dataclass(frozen=True, eq=False)
class Equation:
    """A model as a static argument of compiled code: two are equal if they compile to the same program."""

    model: Model

    def __hash__(self) -> int:
        return hash(self.model.key)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Equation) and self.model.key == other.model.key


class Lane(NamedTuple):
    """One record as the solver sees it.

    **Arguments:** `step`, s, of the Runge–Kutta method; `voltage` and `rate`, (2 n + 1,) V and V/s on the half-step
    grid; `omega`, rad/s; `load`, kg.
    """

    step: Numbers
    voltage: Numbers
    rate: Numbers
    omega: Numbers
    load: Numbers


class System(NamedTuple):
    """Everything that is constant along one trajectory."""

    effects: tuple[AbstractEffect, ...]
    slices: tuple[slice, ...]
    mass: Any
    damping: Any
    stiffness: Any
    gain: Any
    omega: Any


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


def half_step_time(lane: Lane) -> Array:
    """Time since the first sample on the half-step grid, s."""
    return jnp.asarray(0.5 * lane.step * jnp.arange(lane.voltage.shape[0]))


def integrate(
    system: System, substeps: int, start: Numbers, lane: Lane, half_time: Array, whole_state: bool = True
) -> tuple[Array, ...]:
    """State (z, v, hidden …) at the samples, or z alone; each (n / substeps + 1,)."""
    grids = (lane.voltage, lane.rate, half_time)
    inputs = tuple((grid[:-1:2], grid[1::2], grid[2::2]) for grid in grids)
    # Adding a zero that depends on the parameters gives the carry the type it will have under differentiation.
    nothing = 0.0 * system.stiffness
    memory = (h for effect in system.effects for h in effect.begun(_first_drive(system, lane)))
    carry = tuple(x + nothing for x in (start[0], start[1], *memory))

    slope = jax.jit(partial(derivative, system))  # traced once instead of four times

    def advance(y: tuple[Array, ...], x: Any) -> tuple[tuple[Array, ...], Any]:
        at = [tuple(grid[i] for grid in x) for i in range(3)]
        y = _runge_kutta(slope, y, at, lane.step)
        return y, (y if whole_state else y[:1])

    _, path = lax.scan(advance, carry, inputs)
    return tuple(jnp.concatenate([a[None], b[substeps - 1 :: substeps]]) for a, b in zip(carry, path, strict=False))


def _first_drive(system: System, lane: Lane) -> Drive:
    return Drive(jnp.asarray(lane.voltage)[0], jnp.asarray(lane.rate)[0], system.omega, system.gain)


def assemble(equation: Equation, values: Numbers, lane: Lane) -> System:
    """Bind parameter values, (m,) SI, to the equation of motion of one record."""
    (frequency, quality, gain), effects = equation.model.bind(values)
    linear = equation.model.linear
    omega0 = 2 * jnp.pi * frequency
    slices, first = [], 0
    for effect in effects:
        size = len(effect.state0())
        slices.append(slice(first, first + size))
        first += size
    return System(
        effects,
        tuple(slices),
        linear.mass + lane.load,
        linear.mass * omega0 / quality,
        linear.mass * omega0**2,
        linear.force_per_gain * gain,
        lane.omega,
    )


def derivative(system: System, y: tuple[Array, ...], at: tuple[Array, ...]) -> tuple[Array, ...]:
    """(ż, v̇, hidden rates) of the state `y` at `at` = (V, V̇, t)."""
    voltage, rate, t = at
    z, v, *hidden = y
    drive = Drive(voltage, rate, system.omega, system.gain)
    force, rates = system.gain * voltage - system.damping * v - system.stiffness * z, []
    for effect, own in zip(system.effects, system.slices, strict=True):
        memory = tuple(hidden[own])
        state = State(z, v, memory)
        if effect.overrides("force"):
            force = force + effect.force(state, drive, t)
        if effect.overrides("drive"):
            force = force + effect.drive(memory, drive, t)
        if memory:
            rates += effect.rate(state, drive, t)
    return (v, force / system.mass, *rates)


def _runge_kutta(f: Any, y: tuple[Array, ...], at: list[tuple[Array, ...]], h: Numbers) -> tuple[Array, ...]:
    move = lambda k, step: tuple(a + step * b for a, b in zip(y, k, strict=True))
    k1 = f(y, at[0])
    k2 = f(move(k1, h / 2), at[1])
    k3 = f(move(k2, h / 2), at[1])
    k4 = f(move(k3, h), at[2])
    return tuple(a + h / 6 * (p + 2 * q + 2 * r + s) for a, p, q, r, s in zip(y, k1, k2, k3, k4, strict=True))


def rates_along(effect: AbstractEffect, system: System, lane: Lane, z: Numbers, v: Numbers) -> tuple[Array, ...]:
    """Hidden states of one effect along a given motion (2 n + 1,), on the half-step grid; midpoints are
    interpolated."""
    initial = tuple(jnp.asarray(h) + 0.0 * system.stiffness for h in effect.begun(_first_drive(system, lane)))
    if not initial:
        return ()
    grids = (z, v, lane.voltage, lane.rate, half_step_time(lane))
    inputs = tuple((grid[:-1:2], grid[1::2], grid[2::2]) for grid in grids)

    def rate(hidden: tuple[Array, ...], at: tuple[Array, ...]) -> tuple[Array, ...]:
        z, v, voltage, slope, t = at
        return effect.rate(State(z, v, hidden), Drive(voltage, slope, system.omega, system.gain), t)

    def advance(hidden: tuple[Array, ...], x: Any) -> tuple[tuple[Array, ...], tuple[Array, ...]]:
        hidden = _runge_kutta(rate, hidden, [tuple(grid[i] for grid in x) for i in range(3)], lane.step)
        return hidden, hidden

    _, path = lax.scan(advance, initial, inputs)
    whole = tuple(jnp.concatenate([a[None], b]) for a, b in zip(initial, path, strict=True))
    return tuple(_with_midpoints(h) for h in whole)


def _with_midpoints(x: Array) -> Array:
    return jnp.concatenate([jnp.stack([x[:-1], (x[:-1] + x[1:]) / 2], axis=1).ravel(), x[-1:]])


def _reading(system: System, path: tuple[Array, ...], lane: Lane, half_time: Array, stride: int) -> Array:
    reading = path[0]
    voltage, rate, time = (grid[::stride] for grid in (lane.voltage, lane.rate, half_time))
    for effect, own in zip(system.effects, system.slices, strict=True):
        if effect.overrides("sensor"):
            hidden = tuple(path[2:][own])
            one = lambda z, v, h, u, r, t, effect=effect: effect.sensor(
                State(z, v, h), Drive(u, r, system.omega, system.gain), t
            )
            reading = reading + jax.vmap(one)(path[0], path[1], hidden, voltage, rate, time)
    return reading


def simulate_group(equation: Equation, substeps: int, values: Array, starts: Numbers, lanes: Lane) -> Array:
    """Sensor readings of records of equal length: `starts` (lanes, 2), every field of `lanes` with a leading axis."""
    return jax.vmap(partial(simulate, equation, substeps, values))(starts, lanes)
