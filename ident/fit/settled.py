"""A search goes on with the steady records on periodic orbits, until they stay on those that they show."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from ..campaign.record import Trace
from .on_orbits import off_orbits, on_better_orbits, on_orbits, unstable
from .problem import Data, Static
from .solve import Solution

Search = Callable[..., tuple[Data, Solution]]
"""`solve.least_squares` of static, data, unknowns and the most steps; with the model there, if that is known."""

_ROUNDS = 3  # of searches on orbits: on those of the first fit, on others that fit better, and off those that are none
_MISSED = 1.5  # of a record's mean squared residual: so much may have another orbit as its reason


def settled(
    static: Static, data: Data, records: Sequence[Trace], found: Solution, search: Search, most: int, compared: bool
) -> tuple[Static, Data, Solution]:
    """A solution with the steady records on the stable orbits of the model that they show, and what remained unknown
    with the initial states fitted; in `most` steps together. Fits that are only `compared` look for no other orbits."""
    barred: set[int] = set()
    if not np.isfinite(found.cost):  # a motion without bound has no orbit either
        return static, data, found
    for _ in range(_ROUNDS):
        before = data.steady
        if off := unstable(static, data, found.found):
            barred |= off
            static, data, unknowns = off_orbits(static, data, records, found.unknowns, off)
        else:
            static, data, unknowns = on_orbits(static, data, records, found.unknowns, barred)
        begun = None
        missed = set() if compared or off or len(data.steady) != len(before) else _missed(data, found)
        if missed and (other := on_better_orbits(static, data, records, unknowns, found.found, missed)):
            data, begun = other
        if data.steady == before:
            break
        data, better = search(static, data, unknowns, max(most - found.steps, 1), begun)
        found = better._replace(steps=found.steps + better.steps)
    return static, data, found


def _missed(data: Data, found: Solution) -> set[int]:
    """Steady records that the model misses."""
    rows = {one.record: found.found.residuals[data.tape.slices[one.record]] for one in data.steady}
    counted = {k: max(np.count_nonzero(data.weight[data.tape.slices[k]]), 1) for k in rows}
    return {k for k, own in rows.items() if own @ own > _MISSED * counted[k]}
