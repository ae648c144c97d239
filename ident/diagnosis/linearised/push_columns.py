"""How the readings of any model answer to extra forces on the stage: an oscillator whose spring and damper vary."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from typing import Any

import jax.numpy as jnp
import numpy as np
from jax import lax

from ...programs import program
from ...response import Tape
from ...response.kinks import STIFF
from ...response.lane import Numbers
from ...response.runge_kutta import by_steps, runge_kutta, stages
from ...response.tape import BLOCK, BLOCKS
from .columns import Dynamics

_COLUMNS = (4, 12, 36)  # solved together: three programs serve any number of them; 36 are those of a pair of splines


def push_columns(tape: Tape, dynamics: Sequence[Dynamics], pushes: Sequence[np.ndarray]) -> np.ndarray:
    """Change of the readings by given extra forces on the stage, through the model's dynamics linearised on the motion.

    **Arguments:** `pushes`, per chunk (BLOCKS, d, 2 BLOCK + 1) N on the half-step grid.

    **Returns:** (d, samples), m.
    """
    columns, count = [], pushes[0].shape[1]
    width = next((w for w in _COLUMNS if w >= count), _COLUMNS[-1])
    for first in range(0, count, width):
        carry, found = (np.zeros(width),) * 2, []
        for chunk, along, push in zip(tape.chunks, dynamics, pushes, strict=True):
            filled = part = push[:, first : first + width]
            if part.shape[1] < width:
                filled = np.zeros((len(part), width, part.shape[2]))
                filled[:, : part.shape[1]] = part
            carry, rows = answer(None, filled, along, carry, chunk.step, chunk.first, chunk.count)
            found.append(rows)
        columns.append(tape.at_samples(found))
    return np.concatenate(columns)[:count]


@program
def answer(
    _: None, pushes: Numbers, along: Dynamics, carry: tuple, steps: Numbers, first: Numbers, count: Numbers
) -> tuple:
    """One chunk of `push_columns`, at rest at the beginning of every record.

    **Returns:** the carry (z, v), (d,) each; changes of the readings, (BLOCKS, BLOCK, d).
    """

    def one_block(k: Any, state: tuple) -> tuple:
        *y, out = state
        y = tuple(jnp.where(first[k] > 0, 0.0, x) for x in y)
        inputs = by_steps((pushes[k].T / along.mass[k], along.stiffness[k], along.damping[k]))
        y, said = lax.scan(partial(_step, steps[k]), y, (inputs, along.by_z[k], along.by_v[k], along.by_a[k]))
        return *y, lax.dynamic_update_index_in_dim(out, said, k, 0)

    out = jnp.zeros((BLOCKS, BLOCK, pushes.shape[1]))
    z, v, out = lax.fori_loop(0, count, one_block, (*carry, out))
    return (z, v), out


def _step(h: Any, y: tuple, x: tuple) -> tuple:
    """The state after a step, and the change of the reading at its beginning. Where friction sticks the step is
    implicit, as that of the motion was (`response.kinks`)."""
    grids, by_z, by_v, by_a = x
    (push, _, _), _, (c0, cm, c1) = grids
    z, v = y
    plain = runge_kutta(_slope, y, stages(grids), h)
    stuck = h * jnp.maximum(jnp.maximum(c0, cm), c1) > STIFF
    after = tuple(jnp.where(stuck, a, b) for a, b in zip(_held(y, grids, h), plain, strict=True))
    return after, by_z * z + by_v * v + by_a * push


def _slope(y: tuple, at: tuple) -> tuple:
    """Velocity and acceleration of the oscillator in a state (z, v), by push, stiffness and damping per mass."""
    (z, v), (push, stiffness, damping) = y, at
    return v, push - stiffness * z - damping * v


def _held(y: tuple, grids: tuple, h: Any) -> tuple:
    """The state after a linearly implicit step, by the means of the inputs in it."""
    z, v = y
    push, stiffness, damping = ((a + 4 * b + c) / 6 for a, b, c in grids)
    after = (v + h * (push - stiffness * z)) / (1 + h * damping)
    return z + h * after, after
