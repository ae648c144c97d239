"""Many simulations of one tape at once, without derivatives: what a sampler asks for."""

from __future__ import annotations

import jax
import numpy as np

from ..programs import program
from .lane import Numbers
from .system import Equation
from .tape import Chunk, Tape
from .transient import march, rest


def respond_many(equation: Equation, tape: Tape, values: np.ndarray, starts: np.ndarray) -> np.ndarray:
    """Sensor readings of all records of a tape for many sets of parameters, (k, samples) m.

    **Arguments:** `values`, (k, m) SI, in the order of `model.parameters`; `starts`, (k, records, 2 …) as of `respond`
    at the first samples. Each k has its own program: ask for the same number again.
    """
    values, starts = np.asarray(values, float), np.asarray(starts, float)
    k = len(values)
    carry = jax.tree.map(lambda x: np.broadcast_to(x, (k, *x.shape)).copy(), rest(equation, None, starts.shape[2] > 2))
    begin = np.stack([np.stack(tape.begun(own)) for own in starts], axis=1)  # (chunks, k, BLOCKS, 2 …)
    found = []
    for chunk, own in zip(tape.chunks, begin, strict=True):
        carry, readings = march_many(equation, equation.constants, values, own, carry, chunk)
        found.append(np.moveaxis(np.asarray(readings), 0, -1))
    return tape.at_samples(found)


@program
def march_many(
    equation: Equation, constants: Numbers, values: Numbers, begin: Numbers, carry: tuple, chunk: Chunk
) -> tuple:
    """`march` for many sets of parameters; the carry and the readings, (k, BLOCKS, BLOCK)."""

    def one(values: Numbers, begin: Numbers, carry: tuple) -> tuple:
        carry, readings, *_ = march.function(equation, constants, values, None, begin, None, carry, chunk)
        return carry, readings

    return jax.vmap(one)(values, begin, carry)
