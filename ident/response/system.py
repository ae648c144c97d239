"""The equation of motion with numbers in it, and what of it the loops of a program need."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jax import Array

from ..effects.dependence import depends_on, runs_by_a_clock, told_in_reading
from ..effects.effect import AbstractEffect, Drive, State
from ..model import Model
from ..units import in_reading
from .lane import Numbers
from .memory import follows_drive_alone
from .tape import Chunk


@dataclass(frozen=True, eq=False)
class Equation:
    """A model as what decides a program: two are equal if they compile to the same one."""

    model: Model

    def __hash__(self) -> int:
        return self._hash

    def __eq__(self, other: object) -> bool:
        return self is other or (isinstance(other, Equation) and self._key == other._key)

    @cached_property
    def _key(self) -> tuple[Any, ...]:
        return self.model.key

    @cached_property
    def _hash(self) -> int:  # asked for with every march
        return hash(self._key)

    @property
    def fingerprint(self) -> str | None:
        """The same for other processes; None if an effect has no file that could tell whether it changed."""
        told = [effect.fingerprint for effect in self.model.effects]
        return None if None in told else repr((self.model.kind, self.model.weighed, told))

    @cached_property
    def constants(self) -> np.ndarray:
        """Mass, kg, where it is no parameter, and force per unit of the gain, N/V."""
        return np.array([self.model.linear.mass, self.model.linear.force_per_gain])

    @cached_property
    def follow_drive(self) -> tuple[bool, ...]:
        """Of each effect, whether it follows the drive alone; such a one is integrated before the motion."""
        return tuple(follows_drive_alone(effect) for effect in self.model.effects)

    @cached_property
    def timeless(self) -> bool:
        """Whether no effect changes with the time since the first sample: under a drive that repeats itself the motion
        may then do so, too."""
        values = np.array([p.value for p in self.model.parameters])
        return not any(runs_by_a_clock(effect) for effect in self.model.bind(values)[1])

    @cached_property
    def has_kink(self) -> bool:
        """Whether any force of the motion has one."""
        pairs = zip(self.model.effects, self.follow_drive, strict=True)
        return any(effect.has_kink and not before for effect, before in pairs)

    @cached_property
    def can_stick(self) -> bool:
        """Whether any of these depends on the velocity, and may hold it."""
        pairs = zip(self.model.effects, self.follow_drive, strict=True)
        laws = [depends_on(effect) for effect, before in pairs if effect.has_kink and not before]
        return any(law is None or "v" in law[1] for law in laws)

    @property
    def stepped(self) -> int:
        """Hidden states that are integrated with the motion."""
        pairs = zip(self.model.effects, self.follow_drive, strict=True)
        return sum(len(effect.state0()) for effect, before in pairs if not before)

    @cached_property
    def histories(self) -> tuple[slice, ...]:
        """Each effect's part of the start of a record, after displacement and velocity."""
        ends = np.cumsum([2, *(len(effect.state0()) for effect in self.model.effects)])
        return tuple(slice(int(a), int(b)) for a, b in zip(ends[:-1], ends[1:], strict=True))

    @cached_property
    def history_units(self) -> tuple[str, ...]:
        """Units of all hidden states."""
        return self.history_units_of(0)

    def swings(self, values: np.ndarray) -> np.ndarray:
        """By how much more than what moves them all hidden states may swing, at some values (m,) SI."""
        effects = self.model.bind(values)[1]
        return np.concatenate([np.zeros(0), *(np.full(len(e.state0()), float(e.swing())) for e in effects)])

    def history_units_of(self, order: int) -> tuple[str, ...]:
        """The same in a record whose sensor reads the `order`-th derivative of the displacement."""
        units: list[str] = []
        for effect in self.model.effects:
            read = order > 0 and told_in_reading(effect)
            units += [in_reading(unit, order) if read else unit for unit in effect.hidden_units]
        return tuple(units)


class Block(NamedTuple):
    """What is constant in a block of a record, as in `tape.Chunk`."""

    step: Any
    clock: Any
    omega: Any
    load: Any
    moving: Any
    order: Any
    stiffer: Any
    damped: Any
    sine: Any
    allowed: Any
    beside: Any

    @classmethod
    def of(cls, chunk: Chunk) -> Block:
        """Those of all blocks of a chunk, (BLOCKS,) each."""
        return cls(*(getattr(chunk, name) for name in cls._fields))

    def times(self, points: int, spacing: float) -> Array:
        """Times of the points of the block, s since the first sample of the record; `spacing` in steps."""
        return self.clock + spacing * self.step * jnp.arange(points)


class System(NamedTuple):
    """Everything of a model that is constant along a record; numbers and, among the effects, code."""

    effects: tuple[AbstractEffect, ...]
    mass: Any
    damping: Any
    stiffness: Any
    gain: Any
    omega: Any = 0.0
    moving: Any = 0.0
    order: Any = 0.0
    beside: Any = 0.0  # s² or s, as of `lane.Lane`
    step: Any = 0.0  # s, of the solver
    share: Any = 1.0  # of what the actuator gives, that acts on the stage; of the drive, that the sensor sees past it
    base: Any = None  # travel of the base that carries spring and damper, per unit of the drive; None if that pushes
    riding: bool = False  # whether the drive is the acceleration of the base, and an accelerometer rides on the body

    def drive(self, voltage: Any, rate: Any) -> Drive:
        """The drive as the effects see it."""
        return Drive(voltage, rate, self.omega, self.gain, self.moving, self.order)

    def drive_of(self, effect: AbstractEffect, voltage: Any, rate: Any) -> Drive:
        """The same as an effect sees it with the actuator's share: one that adds to the reading adds that share, too.

        Past an antiresonance a reading would else be answered by two shares, or by none.
        """
        past = behind_the_sensor(effect)
        return self.drive(self.share * voltage, self.share * rate) if past else self.drive(voltage, rate)

    def apart(self, z: Any, v: Any, voltage: Any, rate: Any) -> tuple[Any, Any]:
        """Displacement and velocity of the stage against what carries it: spring, damper and forces act by these."""
        return (z, v) if self.base is None else (z - self.base * voltage, v - self.base * rate)

    def seen_by(self, effect: AbstractEffect, z: Any, v: Any, voltage: Any, rate: Any) -> tuple[Any, Any]:
        """Displacement and velocity as an effect sees them: a sensor stands beside the device."""
        return self.apart(z, v, voltage, rate) if effect.overrides("force") else (z, v)

    def felt(self, acceleration: Any, voltage: Any) -> Any:
        """Acceleration that a sensor of acceleration feels: where that rides on a body whose base the drive
        accelerates, what the inertia of the body is to the base is none to the world."""
        return acceleration - self.share * self.push(voltage) / self.mass if self.riding else acceleration

    def read(self, z: Any, v: Any, acceleration: Any, jerk: Any, rate: Any) -> tuple[Any, Any]:
        """What the sensor reads of a motion, and the rate of that; V̇ is the `rate` of the drive."""
        ordered = lambda *of: jnp.where(self.order > 1, of[2], jnp.where(self.order > 0, of[1], of[0]))
        jumped = self.beside * self.share * self.push(rate) / self.mass
        felt = acceleration if self.riding else acceleration + jumped  # riding, it does not feel the drive itself
        return ordered(z, v + jumped, felt), ordered(v, acceleration, jerk)

    def moved(self, z: Any) -> Any:
        """The mass that is moved at a displacement, kg."""
        return sum((e.inertia(z) for e in self.effects if e.overrides("inertia")), self.mass)

    def push(self, voltage: Any) -> Any:
        """Force of the drive itself."""
        return self.gain * voltage if self.base is None else 0.0 * voltage

    def at(self, block: Block) -> System:
        """The same in a block of a record."""
        spring, damper = self.stiffness * (1 + block.stiffer), self.damping * (1 + block.damped)
        there = self._replace(mass=self.mass + block.load, damping=damper, stiffness=spring)
        there = there._replace(omega=block.omega, moving=block.moving, order=block.order)
        there = there._replace(beside=block.beside, step=block.step)
        return there.undispersed(block.sine * block.step)

    def undispersed(self, step: Any) -> System:
        """The system that the solver, in steps h, integrates as the given one: what steps of fourth order do to an
        oscillation of frequency ω, θ = ωh, is to slow it by θ⁴/120 and to damp it by ω θ⁵/144, and is taken off."""
        theta = self.omega * step
        mass = self.mass / (1 + theta**4 / 60)
        return self._replace(mass=mass, damping=self.damping - mass * self.omega * theta**5 / 72)

    @property
    def numbers(self) -> Any:
        """Its numbers alone, a tree of arrays."""
        own = tuple((dict(effect.values), effect.prepared) for effect in self.effects)
        return (self.mass, self.damping, self.stiffness, self.gain, own, self.base)

    def with_numbers(self, numbers: Any) -> System:
        """The same with other numbers, as `numbers` gives them."""
        mass, damping, stiffness, gain, own, base = numbers
        effects: dict[str, AbstractEffect] = {}
        for effect, (values, prepared) in zip(self.effects, own, strict=True):
            effects[effect.name] = effect.carrying(values, prepared)
        joined = (e.accompanied(effects[e.needs]) if e.needs else e for e in effects.values())
        return self._replace(
            effects=tuple(joined), mass=mass, damping=damping, stiffness=stiffness, gain=gain, base=base
        )


def assemble(equation: Equation, constants: Numbers, values: Numbers) -> System:
    """Bind parameter values, (m,) SI, to the equation of motion; `constants` as the equation's own."""
    (frequency, quality, gain), effects = equation.model.bind(values)
    mass = equation.model.mass_of(values) if equation.model.weighed else constants[0]
    stiffness, damping = equation.model.spring_and_damper(frequency, quality, mass)
    if equation.model.form == "base":
        return System(effects, mass, damping, stiffness, stiffness * gain, base=gain)
    riding = equation.model.form == "shaken"
    force = constants[1] * gain
    return System(effects, mass, damping, stiffness, -force if riding else force, riding=riding)


def slices(equation: Equation) -> tuple[slice | None, ...]:
    """Each effect's part of the hidden states of the motion; None if it follows the drive alone."""
    found: list[slice | None] = []
    first = 0
    for effect, before in zip(equation.model.effects, equation.follow_drive, strict=True):
        size = 0 if before else len(effect.state0())
        found.append(None if before else slice(first, first + size))
        first += size
    return tuple(found)


def derivative(
    system: System, parts: tuple[slice | None, ...], y: tuple[Any, ...], at: tuple[Any, ...]
) -> tuple[Any, ...]:
    """(ż, v̇, hidden rates) of the state `y` at `at` = (V, V̇, t), and the remembered force if there is one."""
    v, acceleration = y[1], accelerated(system, parts, y, at)
    rates = _rates(system, parts, y, at, acceleration)
    return (v, acceleration, *(rate for own in rates for rate in own))


def reading(
    system: System, parts: tuple[slice | None, ...], y: tuple[Any, ...], at: tuple[Any, ...], acceleration: Any
) -> Any:
    """What the sensor shows of the state `y` and its acceleration at `at` = (V, V̇, t)."""
    voltage, rate, t = at
    sensors = [pair for pair in zip(system.effects, parts, strict=True) if pair[0].overrides("sensor")]
    felt = system.felt(acceleration, voltage)
    read, its_rate = _read(system, parts, y, at, acceleration) if sensors else system.read(y[0], y[1], felt, 0.0, rate)
    shown = read
    for effect, own in sensors:
        if own is not None:
            state = State(read, its_rate, tuple(y[2:][own]))
            shown = shown + effect.sensor(state, system.drive_of(effect, voltage, rate), t)
    return shown


def behind_the_sensor(effect: AbstractEffect) -> bool:
    """Whether an effect sees what the sensor reads, and not the motion of the stage."""
    return effect.overrides("sensor") and not effect.overrides("force")


def accelerated(system: System, parts: tuple[slice | None, ...], y: tuple[Any, ...], at: tuple[Any, ...]) -> Any:
    """v̇ of the state `y` at `at`, as `derivative`."""
    voltage, rate, t, *remembered = at
    z, v, *hidden = y
    apart, pace = system.apart(z, v, voltage, rate)
    given, force = sum(remembered, system.push(voltage)), -system.damping * pace - system.stiffness * apart
    for effect, own in zip(system.effects, parts, strict=True):
        if own is None:
            continue
        memory, drive = tuple(hidden[own]), system.drive_of(effect, voltage, rate)
        if effect.overrides("force"):
            force = force + effect.force(State(*system.seen_by(effect, z, v, voltage, rate), memory), drive, t)
        if effect.overrides("drive"):
            given = given + effect.drive(memory, drive, t)
    return (system.share * given + force) / system.moved(apart)


def _rates(
    system: System, parts: tuple[slice | None, ...], y: tuple[Any, ...], at: tuple[Any, ...], acceleration: Any,
    sensors: bool = True,
) -> list[tuple[Any, ...]]:  # fmt: skip
    """Rates of the hidden states, effect by effect; zeros of those behind the sensor if these are not asked for."""
    voltage, rate, t = at[:3]
    z, v, *hidden = y
    remembering = any(behind_the_sensor(effect) and effect.state0() for effect in system.effects)
    read = _read(system, parts, y, at, acceleration) if sensors and remembering else (z, v)
    found: list[tuple[Any, ...]] = []
    for effect, own in zip(system.effects, parts, strict=True):
        if own is None or own.start == own.stop:
            continue
        behind = behind_the_sensor(effect)
        if behind and not sensors:
            found.append(tuple(0.0 * h for h in hidden[own]))
            continue
        seen = read if behind else system.seen_by(effect, z, v, voltage, rate)
        state = State(*seen, tuple(hidden[own]))
        found.append(tuple(effect.rate(state, system.drive_of(effect, voltage, rate), t)))
    return found


def _read(
    system: System, parts: tuple[slice | None, ...], y: tuple[Any, ...], at: tuple[Any, ...], acceleration: Any
) -> tuple[Any, Any]:
    """What the sensor reads of the motion itself, and its rate.

    That of an acceleration is how the forces change along the motion, V̇ held, and what follows the drive alone. Where
    nothing asks for it, it is not computed.
    """
    z, v = y[:2]
    hidden = (rate for own in _rates(system, parts, y, at, acceleration, sensors=False) for rate in own)
    steady = tuple(0.0 * x for x in at[3:])
    onward = ((v, acceleration, *hidden), (at[1], 0.0 * at[1], 1.0, *steady))
    numbers = lambda tree: jax.tree.map(lambda x: jnp.asarray(x, float), tree)
    of_motion = lambda y, at: accelerated(system, parts, y, at)
    jerk = jax.jvp(of_motion, numbers((tuple(y), tuple(at))), numbers(onward))[1]
    return system.read(z, v, system.felt(acceleration, at[0]), system.felt(jerk, at[1]), at[1])


def at_rest(equation: Equation, values: Numbers) -> float:
    """What the sensor shows of a stage at rest without a drive, at `values` (m,) SI; 0 where that is no number."""
    system = assemble(equation, equation.constants, values)
    parts = slices(equation)
    still = begun(system, parts, equation.histories, (0.0, 0.0), 0.0, 0.0)
    shown = float(reading(system, parts, still, (0.0, 0.0, 0.0), 0.0))
    return shown if np.isfinite(shown) else 0.0


def begun(
    system: System, parts: tuple[slice | None, ...], histories: tuple[slice, ...], start: Any, voltage: Any, rate: Any
) -> tuple[Any, ...]:
    """The state (z, v, hidden …) at the first sample of a record; `start` (2,) displacement and velocity, or (2 + h,)
    what its history added to the hidden states too."""
    drive, hidden = system.drive(voltage, rate), []
    for effect, own, past in zip(system.effects, parts, histories, strict=True):
        if own is not None:
            fresh = effect.begun(drive)
            hidden += fresh if len(start) == 2 else [h + start[past][i] for i, h in enumerate(fresh)]
    return tuple(jnp.asarray(x, float) for x in (start[0], start[1], *hidden))


def tangents(function: Any, at: tuple, along: tuple) -> Any:
    """f and its derivatives along (d, …) directions of all its arguments: f(at), (d, …); None where `along` is None."""
    if along[0] is None:
        return function(*at), None
    one = lambda *change: jax.jvp(function, at, change)
    return jax.vmap(one, out_axes=(None, 0))(*along)
