"""Steady records of a fit are put on periodic orbits of its model, and taken off again where they have none."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import numpy as np

from ..campaign.record import Trace
from ..model import FREQUENCY
from .assemble import weight_of
from .fit_starts import fit_starts
from .problem import Data, Evaluation, Static, Unknowns, evaluate, physical
from .steady import begin_steady, repeats

Problem = tuple[Static, Data, Unknowns]
_OTHER = 0.01  # of the size of the motion, by which another orbit differs from the same one found again
_ROUNDS = 3  # in which the start is fitted that may lead to another orbit


def on_orbits(
    static: Static, data: Data, records: Sequence[Trace], unknowns: Unknowns, but: Iterable[int] = ()
) -> Problem:
    """The same fit with the steady records on periodic orbits: on the stable ones that are nearest to the initial
    states of `unknowns`.

    Where drive or model do not repeat themselves, or no such orbit is found, the initial state remains unknown; that of
    some records in any case, `but`.
    """
    states, values = unknowns.starts * data.start_scale, physical(static, data, unknowns.x)
    scale, weight, begun = data.start_scale.copy(), data.weight.copy(), unknowns.starts.copy()
    steady = list(data.steady)
    for k, (record, own) in enumerate(zip(records, data.tape.slices, strict=True)):
        if k in but or not np.any(scale[k]) or not repeats(record, static.equation):
            continue
        substeps, unit = data.tape.spans[k].substeps, data.start_scale[k]
        one = begin_steady(record, k, substeps, static.equation, values, states[k], unit, static.width)
        if one is not None:
            steady.append(one)
            scale[k], begun[k], weight[own] = 0.0, 0.0, record.counted / record.noise.sigma
    return _with(static, data, unknowns.x, begun, scale, weight, steady)


def off_orbits(static: Static, data: Data, records: Sequence[Trace], unknowns: Unknowns, which: set[int]) -> Problem:
    """The same fit with the initial states of some records unknown, from where they are."""
    scale, weight, begun = data.start_scale.copy(), data.weight.copy(), unknowns.starts.copy()
    values = physical(static, data, unknowns.x)
    for one in data.steady:
        k = one.record
        if k in which:
            orbit = one.at(static.equation, values, np.zeros((0, len(values))), static.width)
            scale[k], begun[k] = one.unit, orbit.start / one.unit
            weight[data.tape.slices[k]] = weight_of(records[k], float(values[FREQUENCY]))
    steady = [one for one in data.steady if one.record not in which]
    return _with(static, data, unknowns.x, begun, scale, weight, steady)


def _with(
    static: Static, data: Data, x: np.ndarray, begun: np.ndarray, scale: np.ndarray, weight: np.ndarray, steady: list
) -> Problem:
    static = static._replace(starts_free=bool(np.any(scale)))
    return static, data._replace(start_scale=scale, weight=weight, steady=tuple(steady)), Unknowns(x, begun)


def unstable(static: Static, data: Data, found: Evaluation) -> set[int]:
    """Records on orbits to which no motion comes back: none of them can have been measured."""
    nothing = np.zeros((0, len(found.values)))
    ones = ((one, one.at(static.equation, found.values, nothing, static.width)) for one in data.steady)
    return {one.record for one, orbit in ones if not orbit.stable}


def on_better_orbits(
    static: Static, data: Data, records: Sequence[Trace], unknowns: Unknowns, found: Evaluation, misfits: set[int]
) -> tuple[Data, Evaluation] | None:
    """The same fit with some records on the orbits to which the initial states lead that fit them best, if these are
    others and leave less; None if not."""
    free = off_orbits(static, data, records, unknowns, misfits)
    best, _ = fit_starts(*free, _ROUNDS)
    _, moved, _ = on_orbits(free[0], free[1], records, best)
    old = {one.record: found.starts[one.record] for one in data.steady}
    changed = [
        one for one in moved.steady
        if one.record in misfits and _apart(one.known[0].orbit.start - old[one.record], one.unit) > _OTHER
    ]  # fmt: skip
    if not changed:
        return None
    rest = [one for one in data.steady if one.record not in {c.record for c in changed}]
    trial = data._replace(steady=(*rest, *changed))
    there = evaluate(static, trial, unknowns)
    less = float(there.residuals @ there.residuals) < float(found.residuals @ found.residuals)
    return (trial, there) if less else None


def _apart(change: np.ndarray, unit: np.ndarray) -> float:
    """How far two states are apart, in displacement and velocity."""
    return float(np.max(np.abs(change[:2] / unit[:2])))
