"""What a small change of a model would add to the readings, evaluated along the trajectory that was measured.

If the true motion is z and the model's is ẑ, their difference obeys the model's own linearised dynamics, driven by what
the model lacks, evaluated on z. For a linear model this is exact however large the missing effect; the rows below are
therefore good regressors for effects that no local expansion around the wrong model would describe.

The terms of a model are one program for each model; what answers to them (`push_columns`) is one for all.

Source: C. R. Rao, Large sample tests of statistical hypotheses, 1948, Proc. Camb. Phil. Soc. 44 (score test); the
evaluation on the measured motion follows S. F. Masri, T. K. Caughey, 1979, J. Appl. Mech. 46 (restoring force surface).
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from functools import lru_cache
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jax import lax

from ...effects.effect import State
from ...model import FREQUENCY, QUALITY
from ...programs import program
from ...response import Equation, Tape
from ...response.lane import Numbers
from ...response.memory import Seen, memory_along, shaping
from ...response.system import Block, System, assemble, behind_the_sensor
from ...response.tape import BLOCK, BLOCKS, Chunk

_STANDS = 1e-7  # of a velocity: a change of less is rounding
_OWN = 4  # directions of a model's own parameters are taken in multiples of this: how many are free differs


class Motion(NamedTuple):
    """Displacement and velocity on the half-step grid as each block sees them, (BLOCKS, 2 BLOCK + 1), m and m/s; or, of
    a sensor, what it reads of the motion and the rate of that."""

    z: Numbers
    v: Numbers


class Dynamics(NamedTuple):
    """A model linearised along a motion, per chunk.

    **Arguments:** `mass`, (BLOCKS,) kg; `stiffness` and `damping`, (BLOCKS, 2 BLOCK + 1), −∂a/∂z and −∂a/∂v; `by_z`,
    `by_v`: (BLOCKS, BLOCK) derivatives of the reading at the beginning of each step; `by_a`: the same by the
    acceleration that a push gives at once.
    """

    mass: Numbers
    stiffness: Numbers
    damping: Numbers
    by_z: Numbers
    by_v: Numbers
    by_a: Numbers


class Terms(NamedTuple):
    """Which terms of an equation are asked for: those of its effects alone, or the `linear` ones too; `bent`: whether
    what the effects remember changes too, which takes twice as long to follow."""

    equation: Equation
    linear: bool
    bent: bool = True

    @property
    def fingerprint(self) -> str | None:
        told = self.equation.fingerprint
        return None if told is None else f"{told} {self.linear} {self.bent}"

    def along(self, directions: np.ndarray) -> Terms:
        """The same, `bent` if moving the parameters along directions (d, m) may change a memory."""
        moves = zip(self.equation.model.parameters, np.any(directions != 0, axis=0), strict=True)
        return self._replace(bent=_bend(self.equation, frozenset(p.name for p, own in moves if own)))

    @property
    def at_a_time(self) -> int:
        """Directions that are taken together."""
        return _OWN if self.linear else 1

    @property
    def push(self) -> bool:
        """Whether any of them is a force."""
        return self.linear or any(e.overrides("force") or e.overrides("drive") for e in self.equation.model.effects)

    @property
    def show(self) -> bool:
        """Whether any of them adds to the reading."""
        model = self.equation.model
        riding = self.linear and model.form == "shaken"  # the sensor feels the gain of the drive itself
        return riding or any(effect.overrides("sensor") for effect in model.effects)


@lru_cache(maxsize=512)  # what a memory depends on is found by trying
def _bend(equation: Equation, moved: frozenset[str]) -> bool:
    """Whether a memory may depend on any of the parameters that are moved."""
    effects = equation.model.effects
    remembering = [effect for effect in effects if effect.state0()]
    forming = {f"{effect.name}.{name}" for effect in remembering for name in shaping(effect)}
    free = {f"{effect.name}.{name}" for effect in effects for name in effect.values} - forming
    return any(effect.needs or not moved <= free for effect in remembering)


def contributions(
    asked: Terms,
    tape: Tape,
    values: np.ndarray,
    directions: np.ndarray,
    moved: Sequence[Motion],
    seen: Sequence[Motion],
    histories: np.ndarray,
) -> Iterator[tuple[np.ndarray, np.ndarray]]:
    """What the terms of a model change in the force on the stage and in the reading, along given motions; by chunks.

    **Arguments:** `values`, (p, m), of the parameters, at each of which rows are taken along the same `directions`,
    (q, m); `moved`, the motion of the stage, and what the sensor has `seen` of it, per chunk; `histories`, (p, records,
    h): what came before each record added to the hidden states (`Equation.histories`).

    **Returns:** forces (BLOCKS, p q, 2 BLOCK + 1), N, and readings (BLOCKS, p q, BLOCK), m, per unit of the direction,
    those of one place one after another; empty where the model has none.
    """
    asked, equation, pasts = asked.along(directions), asked.equation, _by_block(tape, histories)
    places, count = len(values), len(directions)
    directions = np.concatenate([directions, np.zeros((-count % asked.at_a_time, directions.shape[1]))])
    states = [len(e.state0()) for e in equation.model.effects]
    carry = tuple((np.zeros((places, h)), np.zeros((places, len(directions), h))) for h in states)
    flat = lambda found: np.asarray(found)[:, :, :count].reshape(len(found), places * count, found.shape[-1])
    for chunk, path, own, past in zip(tape.chunks, moved, seen, pasts, strict=True):
        carry, force, shown = terms(asked, equation.constants, values, directions, path, own, past, carry, chunk)
        yield flat(force), flat(shown)


def no_histories(equation: Equation, places: int, tape: Tape) -> np.ndarray:
    """Histories of records that begin with the drive, (places, records, h)."""
    return np.zeros((places, len(tape.spans), len(equation.history_units)))


def _by_block(tape: Tape, histories: np.ndarray) -> list[np.ndarray]:
    """Histories (p, records, h) at the blocks of each record, (p, BLOCKS, h) a chunk."""
    p, records, h = histories.shape
    flat = np.moveaxis(histories, 1, 0).reshape(records, p * h)
    return [np.moveaxis(part.reshape(BLOCKS, p, h), 1, 0) for part in tape.begun(flat)]


@program
def terms(
    asked: Terms, constants: Numbers, values: Numbers, directions: Numbers, moved: Motion, seen: Motion, pasts: Numbers,
    carry: tuple, chunk: Chunk,
) -> tuple:  # fmt: skip
    """One chunk of `contributions`; `pasts`: the histories of its blocks; `carry`: hidden states, (p, h), and their
    derivatives, (p, q, h), per effect.

    What is remembered at one place is the same along every direction, and is followed once.
    """

    def remembered(values: Any, past: Any, hidden: tuple) -> tuple:
        system = assemble(asked.equation, constants, values)
        return _memories(system, asked.equation.histories, moved, seen, past, hidden, chunk)

    def acting(values: Any, paths: tuple) -> tuple:
        system, force, shown = assemble(asked.equation, constants, values), jnp.zeros((0, 0)), jnp.zeros((0, 0))
        if asked.push:
            force = _at_points(_missing, system, moved, paths, chunk, 1)
        if asked.show:
            shown = _at_points(_shown, system, seen, paths, chunk, 2)
        return force, shown

    def at_one_place(values: Any, past: Any, carry: tuple) -> tuple:
        hidden, changes = (tuple(pair[k] for pair in carry) for k in range(2))
        memory = lambda values, hidden: remembered(values, past, hidden)

        def bending(direction: Any, change: tuple) -> tuple:
            (ends, paths), (dends, bends) = jax.jvp(memory, (values, hidden), (direction, change))
            return ends, dends, *jax.jvp(acting, (values, paths), (direction, bends))[1]

        if asked.bent:
            ends, changes, force, shown = jax.vmap(bending, out_axes=(None, 0, 1, 1))(directions, changes)
        else:
            ends, paths = memory(values, hidden)
            along = lambda direction: jax.jvp(lambda values: acting(values, paths), (values,), (direction,))[1]
            force, shown = jax.vmap(along, out_axes=1)(directions)
        return tuple(zip(ends, changes, strict=True)), force, shown

    return jax.vmap(at_one_place, out_axes=(0, 1, 1))(values, pasts, carry)


def _memories(
    system: System, parts: tuple[slice, ...], moved: Motion, seen: Motion, pasts: Any, hidden: tuple, chunk: Chunk
) -> tuple[tuple, tuple]:
    """Hidden states of each effect at the end of a chunk, (h,), and in it, (BLOCKS, h, points), along the motion that
    the stage has `moved` or, behind the sensor, what that has `seen`; `pasts`, (BLOCKS, h), what the history of each
    block's record added to those with which it begins, by `parts`."""
    points = 2 * BLOCK + 1
    if not any(h.shape[0] for h in hidden):
        return hidden, tuple(jnp.zeros((BLOCKS, 0, points)) for _ in hidden)

    def one_block(k: Any, state: tuple) -> tuple:
        hidden, paths = state
        block = jax.tree.map(lambda field: field[k], Block.of(chunk))
        here = system.at(block)
        ends, found = [], []
        for effect, part, h, path in zip(here.effects, parts, hidden, paths, strict=True):
            if not h.shape[0]:
                ends.append(h)
                found.append(path)
                continue
            drive = chunk.voltage[k], chunk.rate[k]
            z, v = seen if behind_the_sensor(effect) else moved
            motion = here.seen_by(effect, z[k], v[k], *drive)
            there = Seen(*motion, *drive, block.times(points, 0.5), block.step, block.omega, here.gain, block.moving)
            fresh = jnp.stack([jnp.asarray(x, float) for x in effect.begun(there.first)])
            fresh = fresh + pasts[k, part.start - 2 : part.stop - 2]
            end, along = memory_along(effect, tuple(jnp.where(chunk.first[k] > 0, fresh, h)), there)
            ends.append(jnp.stack(end))
            found.append(lax.dynamic_update_index_in_dim(path, jnp.stack(along), k, 0))
        return tuple(ends), tuple(found)

    nothing = 0.0 * system.gain
    begin = tuple(jnp.zeros((BLOCKS, h.shape[0], points)) + nothing for h in hidden)
    return lax.fori_loop(0, chunk.count, one_block, (hidden, begin))


def _at_points(
    function: Any, system: System, motion: Motion, paths: tuple, chunk: Chunk, stride: int, base: Any = 0.0
) -> Any:
    """A function of state and drive at points of a chunk, (BLOCKS, …): of the half-step grid, or at the beginning of
    each step if `stride` is 2; its acceleration is against a base that travels by so much per unit of the drive."""
    thin = lambda x: x[..., : 2 * BLOCK : 2] if stride == 2 else x

    def one_block(block: Block, z: Any, v: Any, hidden: tuple, voltage: Any, rate: Any) -> Any:
        here, time = system.at(block), block.times(2 * BLOCK + 1, 0.5)
        one = lambda z, v, a, h, u, r, t: function(here, z, v, a, h, u, r, t)
        axes = (0, 0, 0, tuple(1 for _ in hidden), 0, 0, 0)
        spacing = jnp.where(block.step > 0, 0.5 * block.step, 1.0)  # behind the last record there is none
        a = jnp.asarray(jnp.gradient(v - base * rate)) / spacing
        return jax.vmap(one, in_axes=axes)(*jax.tree.map(thin, (z, v, a, hidden, voltage, rate, time)))

    return jax.vmap(one_block)(Block.of(chunk), motion.z, motion.v, paths, chunk.voltage, chunk.rate)


def _missing(system: System, z: Any, v: Any, a: Any, hidden: tuple, u: Any, r: Any, t: Any) -> Any:
    """Force by which a motion of acceleration `a` misses the equation, on the stage without what moves along with it:
    what a change of the model changes in it, inertia and mass too, is what that pushes."""
    mass = system.moved(system.apart(z, v, u, r)[0])
    return jax.lax.stop_gradient(system.mass / mass) * (_total(system, z, v, hidden, u, r, t) - mass * a)


def _force(system: System, z: Any, v: Any, a: Any, hidden: tuple, u: Any, r: Any, t: Any) -> Any:
    """The force that gives the stage without what moves along with it its acceleration."""
    mass = system.moved(system.apart(z, v, u, r)[0])
    return system.mass / mass * _total(system, z, v, hidden, u, r, t)


def _total(system: System, z: Any, v: Any, hidden: tuple, u: Any, r: Any, t: Any) -> Any:
    """Total force on the stage and on what moves along with it."""
    drive, (z, v) = system.drive(u, r), system.apart(z, v, u, r)
    force = system.push(u) - system.damping * v - system.stiffness * z
    for effect, h in zip(system.effects, hidden, strict=True):
        if effect.overrides("force"):
            force = force + effect.force(State(z, v, tuple(h)), drive, t)
        if effect.overrides("drive"):
            force = force + effect.drive(tuple(h), drive, t)
    return force


def _turning(system: System, z: Any, v: Any, a: Any, hidden: tuple, u: Any, r: Any, t: Any) -> Any:
    """What slopes by velocity lack of the forces with kinks, N s/m: a friction that turns between two points turns by
    none of its slopes at them. Over the velocities of a step about each point it is Δk/Δv, and so in all, as a step
    weighs its ends by a third of its middle: two motions that differ before it differ by exp(h Δk/Δv) after, which is
    a₊/a₋ but for the third power of Δk/a (`response.kinks`)."""
    own = [(e, h) for e, h in zip(system.effects, hidden, strict=True) if e.has_kink]
    alone = system._replace(effects=tuple(e for e, _ in own), damping=0.0, stiffness=0.0)
    by_velocity = lambda v: _force(alone, z, v, a, tuple(h for _, h in own), u, r, t)
    aside = 0.5 * a * system.step
    told = jnp.abs(aside) > _STANDS * jnp.abs(system.apart(z, v, u, r)[1])
    change = by_velocity(v + aside) - by_velocity(v - aside)
    slope = jax.jvp(by_velocity, (v,), (jnp.ones_like(v),))[1]
    return jnp.where(told, change / jnp.where(told, 2 * aside, 1.0) - slope, 0.0)


def _shown(system: System, z: Any, v: Any, a: Any, hidden: tuple, u: Any, r: Any, t: Any) -> Any:
    """What the sensor adds to what it reads of the motion, `z`, with its rate `v`."""
    drive, shown = system.drive(u, r), system.felt(0.0 * z, u)
    for effect, h in zip(system.effects, hidden, strict=True):
        if effect.overrides("sensor"):
            shown = shown + effect.sensor(State(z, v, tuple(h)), drive, t)
    return shown


def linearised(
    equation: Equation, tape: Tape, values: np.ndarray, moved: Sequence[Motion], seen: Sequence[Motion],
    histories: np.ndarray,
) -> tuple[Dynamics, ...]:  # fmt: skip
    """A model linearised along a motion, of which the sensor has `seen` something, hidden states held; per chunk.
    `histories`, (records, h)."""
    acting = [e for e in equation.model.effects if e.overrides("force") or e.overrides("sensor")]
    carry = tuple(np.zeros(len(effect.state0())) for effect in equation.model.effects)
    found = []
    for chunk, motion, own, past in zip(tape.chunks, moved, seen, _by_block(tape, histories[None]), strict=True):
        if acting:
            carry, *parts = slopes(equation, equation.constants, values, motion, own, past[0], carry, chunk)
        else:  # nothing to differentiate
            parts = _linear(equation, values, chunk)
        found.append(Dynamics(*parts))
    return tuple(found)


def _linear(equation: Equation, values: np.ndarray, chunk: Chunk) -> tuple[np.ndarray, ...]:
    mass = float(equation.model.mass_of(values))
    stiffness, damping = equation.model.spring_and_damper(float(values[FREQUENCY]), float(values[QUALITY]), mass)
    whole = mass + np.asarray(chunk.load)
    share, nothing = np.ones((BLOCKS, 2 * BLOCK + 1)) / whole[:, None], np.zeros((BLOCKS, BLOCK))
    spring = stiffness * share * (1 + np.asarray(chunk.stiffer))[:, None]
    damper = damping * share * (1 + np.asarray(chunk.damped))[:, None]
    return whole, spring, damper, *_of_motion(np.asarray(chunk.order), spring, damper, nothing, nothing)


def _of_motion(order: Numbers, stiffness: Any, damping: Any, by_read: Any, by_rate: Any) -> tuple[Any, Any, Any]:
    """`Dynamics.by_z`, `by_v` and `by_a` of the displacement, velocity or acceleration, by `order`, that each block
    reads; `by_read` and `by_rate` are those of what its sensor adds, by that and by its rate."""
    each = order[:, None]
    spring, damper = (grid[:, : 2 * BLOCK : 2] for grid in (stiffness, damping))
    shown = 1.0 + by_read
    by_z, by_v = (each == 0) * shown, (each == 0) * by_rate + (each == 1) * shown - (each == 2) * spring * by_rate
    by_a = (each == 1) * by_rate + (each == 2) * (shown - damper * by_rate)
    return by_z - spring * by_a, by_v - damper * by_a, by_a


@program
def slopes(
    equation: Equation, constants: Numbers, values: Numbers, moved: Motion, seen: Motion, pasts: Numbers, carry: tuple,
    chunk: Chunk,
) -> tuple:  # fmt: skip
    """One chunk of `linearised`: the carry, and what `Dynamics` holds."""
    system = assemble(equation, constants, values)
    carry, paths = _memories(system, equation.histories, moved, seen, pasts, carry, chunk)

    def by_state(function: Any) -> Any:
        one = lambda system, z, v, *rest: jax.jacfwd(lambda z, v: function(system, z, v, *rest), (0, 1))(z, v)
        return one

    force = _at_points(by_state(_force), system, moved, paths, chunk, 1)
    if equation.can_stick:
        base = 0.0 if system.base is None else system.base  # against which friction turns
        force = force[0], force[1] + _at_points(_turning, system, moved, paths, chunk, 1, base)
    shown = _at_points(by_state(_shown), system, seen, paths, chunk, 2)
    mass = system.mass + chunk.load
    stiffness, damping = (-slope / mass[:, None] for slope in force)
    return (carry, mass, stiffness, damping, *_of_motion(chunk.order, stiffness, damping, *shown))
