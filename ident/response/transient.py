"""Transient response: fixed-step Runge–Kutta of order 4 along the tape, driven by the measured voltage.

The state is a tuple of scalars and its derivatives are vectors, so that XLA keeps the whole loop in registers and fills
the vector units. Derivatives are taken of one step, not of the loop. Forces of the momentary drive are computed in the
loop too: read from memory, with their tangents, they would cost more. Those that remember the drive are integrated
block by block before it (`memory`).

Source: E. Hairer, S. P. Nørsett, G. Wanner, Solving Ordinary Differential Equations I, 1993, §II.1.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property, lru_cache, partial
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from jax import lax

from ..programs import program
from .kinks import advanced, bend, between, halved, limits_of, sticks, turned
from .lane import Numbers
from .memory import Remembered, Seen, forgotten, remembered_force
from .runge_kutta import by_steps, stages, with_stages
from .system import Block, Equation, System, assemble, begun, derivative, reading, slices, tangents
from .tape import BLOCK, BLOCKS, Chunk, Tape

WIDTHS = (4, 8, 12, 16, 24)
"""Numbers of directions that one march takes: those that fill the vector units (5 of them take longer than 8). The laws
cost more than the directions: 24 take 1.4 times as long as 8."""


@dataclass(frozen=True, eq=False)
class Response:
    """What a march says, at the samples of all records of a tape."""

    tape: Tape
    directions: int
    marches: tuple[tuple[tuple[Numbers, ...], ...], ...]
    """Per march and chunk, at the beginning of each step: readings, z, v, and derivatives along some directions."""

    @cached_property
    def readings(self) -> np.ndarray:
        """(samples,) m."""
        return self._part(0)[0]

    @cached_property
    def z(self) -> np.ndarray:
        """Displacement of the stage, (samples,) m."""
        return self._part(1)[0]

    @cached_property
    def v(self) -> np.ndarray:
        """Velocity of the stage, (samples,) m/s."""
        return self._part(2)[0]

    @cached_property
    def slopes(self) -> np.ndarray:
        """Derivatives of the readings, (d, samples)."""
        if not self.marches:
            return np.zeros((self.directions, 0))
        return np.concatenate([self._part(3, march) for march in range(len(self.marches))])[: self.directions]

    def _part(self, k: int, march: int = 0) -> np.ndarray:
        if not self.marches:
            return np.zeros((1, 0))
        return self.tape.at_samples([chunk[k] for chunk in self.marches[march]])


def respond(
    equation: Equation,
    tape: Tape,
    values: Numbers,
    starts: Numbers,
    directions: np.ndarray | None = None,
    kicks: np.ndarray | None = None,
) -> Response:
    """Sensor readings of all records of a tape, and how they change along directions.

    **Arguments:** `values`, (m,) SI, in the order of `model.parameters`; `starts`, (records, 2) m and m/s at the first
    samples, or (records, 2 + h) with what the history of each record added to the hidden states, as
    `Equation.histories`; `directions`, (d, m) changes of the values, and `kicks`, (d, records, …), of the starts;
    without them there are no derivatives.
    """
    starts, values = np.asarray(starts, float), np.asarray(values, float)
    if not tape.spans:
        return Response(tape, 0 if directions is None else len(directions), ())
    if directions is None or kicks is None:
        return Response(tape, 0, (_pass(equation, tape, values, starts, None, None),))
    width = fitting_width(len(directions))
    marches = []
    for first in range(0, max(len(directions), 1), width):
        own = slice(first, first + width)
        along = filled(directions[own], width), filled(kicks[own], width)
        marches.append(_pass(equation, tape, values, starts, *along))
    return Response(tape, len(directions), tuple(marches))


def fitting_width(directions: int) -> int:
    """How many directions one march takes, if there are so many in all."""
    return next((w for w in WIDTHS if w >= directions), WIDTHS[-1])


def filled(rows: np.ndarray, count: int) -> np.ndarray:
    """(count, …) rows, zeros behind those that there are."""
    return np.concatenate([rows, np.zeros((count - len(rows), *rows.shape[1:]))])


def _pass(
    equation: Equation, tape: Tape, values: np.ndarray, starts: np.ndarray,
    directions: np.ndarray | None, kicks: np.ndarray | None,
) -> tuple[tuple[Numbers, ...], ...]:  # fmt: skip
    width = None if directions is None else len(directions)
    known = starts.shape[1]
    carry, begin, found = rest(equation, width, known > 2), tape.begun(starts), []
    kick: list[np.ndarray | None] = [None] * len(begin)
    if kicks is not None:
        flat = np.moveaxis(kicks, 0, 1).reshape(len(starts), -1)
        kick = [part.reshape(BLOCKS, -1, known) for part in tape.begun(flat)]
    for chunk, own, change in zip(tape.chunks, begin, kick, strict=True):
        carry, *said = march(equation, equation.constants, values, directions, own, change, carry, chunk)
        found.append(tuple(said))
    return tuple(found)


@lru_cache(maxsize=512)  # which effects remember what is found by trying, and asked for with every march
def rest(equation: Equation, width: int | None, past: bool) -> tuple:
    """What goes from chunk to chunk, before the first: state, its derivatives along so many directions (None: there are
    none), and what is remembered of the drive; `past`, whether a history comes before the records."""
    size = 2 + equation.stepped
    pairs = zip(equation.model.effects, equation.follow_drive, strict=True)
    memories = [forgotten(effect, past) for effect, before in pairs if before]
    return (
        tuple(np.zeros(()) for _ in range(size)),
        None if width is None else tuple(np.zeros(width) for _ in range(size)),
        tuple((np.zeros(hidden), np.zeros(slopes)) for hidden, slopes in memories),
    )


@program
def march(
    equation: Equation,
    constants: Numbers,
    values: Numbers,
    directions: Numbers | None,
    begin: Numbers,
    kick: Numbers | None,
    carry: tuple,
    chunk: Chunk,
) -> tuple:
    """March through one chunk.

    **Arguments:** `constants` of the equation; `directions`, (d, m), or None if no derivative is asked for; `begin`,
    (BLOCKS, 2 …), and `kick`, (BLOCKS, d, 2 …), the initial states of each block's record and their derivatives;
    `carry` as of `rest`.

    **Returns:** the carry; at the beginning of each step readings, z and v, (BLOCKS, BLOCK), and slopes, (BLOCKS,
    BLOCK, d) or None.
    """
    parts, histories = slices(equation), equation.histories
    whole = assemble(equation, constants, values)
    changing = lambda values: _changing(assemble(equation, constants, values).numbers)
    numbers, along = tangents(changing, (values,), (directions,))
    system_of = lambda numbers: whole.with_numbers(_completed(numbers, whole.numbers))

    def one_block(k: Any, state: tuple) -> tuple:
        y, dy, memories, *out = state
        block = jax.tree.map(lambda field: field[k], Block.of(chunk))
        voltage, rate, first = chunk.voltage[k], chunk.rate[k], chunk.first[k]
        time = block.times(2 * BLOCK + 1, 0.5)
        seen = Seen(None, None, voltage, rate, time, block.step, block.omega, numbers[3], block.moving)
        own_kick = None if kick is None else kick[k]
        system = system_of(numbers)
        memories, forces, pushes = _before(equation, system, along, begin[k], own_kick, memories, first, seen)

        def beginning(numbers: Any, start: Any) -> tuple:
            return begun(system_of(numbers).at(block), parts, histories, start, voltage[0], rate[0])

        fresh = tangents(beginning, (numbers, begin[k]), (along, own_kick))
        y, dy = jax.tree.map(lambda a, b: jnp.where(first > 0, a, b), fresh, (y, dy))

        def ahead(numbers: Any, y: tuple, inputs: list) -> tuple:
            system = system_of(numbers).at(block)
            slope = jax.jit(partial(derivative, system, parts))  # traced once instead of four times
            shown = reading(system, parts, y, inputs[0][:3], slope(y, inputs[0])[1])
            after, states = with_stages(slope, y, inputs, block.step)
            return after, shown, states

        def in_parts(y: tuple, dy: tuple, at: tuple, remembered: tuple, changes: Any, limits: tuple) -> tuple:
            def stepped(numbers: Any, y: tuple, inputs: list, h: Any, told_apart: bool = False) -> tuple:
                return advanced(system_of(numbers).at(block), parts, y, inputs, h, equation.can_stick, told_apart)

            def part(state: tuple) -> tuple:
                first, length, y, dy = state
                length = halved(partial(stepped, numbers), y, (*at, *remembered), block.step, first, length, limits)

                def one(numbers: Any, y: tuple, remembered: tuple) -> tuple:
                    return stepped(
                        numbers, y, between((*at, *remembered), first, length), block.step * length, dy is not None
                    )

                y, dy = tangents(one, (numbers, y, remembered), (along, dy, changes))
                first = first + length
                return first, jnp.minimum(2 * length, 1 - first), y, dy

            zero = 0.0 * block.step
            return lax.while_loop(lambda state: state[0] < 1, part, (zero, zero + 1, y, dy))[2:]

        def advance(state: tuple, x: tuple) -> tuple:
            (y, dy), (at, remembered, changes) = state, x
            f = lambda numbers, y, remembered: ahead(numbers, y, stages((*at, *remembered)))
            (after, shown, states), change = tangents(f, (numbers, y, remembered), (along, dy, changes))
            dafter, dshown, _ = change or (None, None, None)
            if equation.has_kink:
                now, (first, middle, last) = system_of(numbers).at(block), stages(at)
                rate, allowed = limits = limits_of(now, block.allowed)
                inside = (first, middle, middle, last)
                missed = bend(now, parts, states, inside, block.step) > rate * allowed
                if equation.can_stick:  # of the states of a method that is not stable there nothing is told
                    missed = missed | sticks(now, parts, y, last, block.step)
                    missed = missed | turned(now, parts, states, inside, block.step, rate * allowed)
                divided = lambda: in_parts(y, dy, at, remembered, changes, limits)
                after, dafter = lax.cond(missed, divided, lambda: (after, dafter))
            return (after, dafter), (shown, y[0], y[1], dshown)

        inputs = (by_steps((voltage, rate, time)), by_steps(forces), pushes and by_steps(pushes))
        (y, dy), said = lax.scan(advance, (y, dy), inputs)
        out = jax.tree.map(lambda a, b: lax.dynamic_update_index_in_dim(a, b, k, 0), tuple(out), said)
        return (y, dy, memories, *out)

    plain = jnp.zeros((BLOCKS, BLOCK))
    wide = None if directions is None else jnp.zeros((BLOCKS, BLOCK, directions.shape[0]))
    out = (plain, plain, plain, wide)
    y, dy, memories, *out = lax.fori_loop(0, chunk.count, one_block, (*carry, *out))
    return ((y, dy, memories), *out)


def _changing(tree: Any) -> Any:
    """The real arrays of a tree, None in the place of all else.

    As `equinox.filter`, the import of which took longer than tracing a march.
    """
    real = lambda x: isinstance(x, (np.ndarray, np.generic, jax.Array)) and jnp.issubdtype(x.dtype, jnp.inexact)
    return jax.tree.map(lambda x: x if real(x) else None, tree)


def _completed(tree: Any, whole: Any) -> Any:
    """A tree of `_changing`, with what it lacks from the whole one."""
    return jax.tree.map(lambda own, other: other if own is None else own, tree, whole, is_leaf=lambda x: x is None)


def _before(
    equation: Equation, system: System, along: Any, start: Any, kick: Any, memories: tuple, first: Any, seen: Seen
) -> tuple[tuple, tuple, tuple | None]:
    """What the effects that follow the drive alone remember; their force, (points,), and its derivatives along the
    directions, (points, d); nothing where there are none."""
    own = [i for i, before in enumerate(equation.follow_drive) if before]
    kept, forces, pushes = [], [], []
    for i, memory in zip(own, memories, strict=True):
        still, past = jnp.zeros_like(seen.time), equation.histories[i]
        after, force, slopes = remembered_force(
            system.effects[i], Remembered(*memory), first, seen._replace(z=still, v=still), start[past]
        )
        kept.append(tuple(after))
        forces.append(force)
        if along is not None:  # by its own parameters, the gain and the history, (values + 1 + p, d)
            pushes.append(slopes.T @ jnp.stack([*along[4][i][0].values(), along[3], *kick[:, past].T]))
    nothing = None if along is None else ()
    return tuple(kept), (sum(forces),) if own else (), (sum(pushes),) if pushes else nothing
