"""A search goes on until all that it stands on is its own.

The orbits of steady records, the noise of curves, and the misfit against which histories count are those of its start;
the steps of the solver lead near the minimum only.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..campaign.record import Trace
from ..pulse import Pulse, Report
from ..response import Tape
from .on_orbits import off_orbits, on_better_orbits, on_orbits, unstable
from .problem import Data, Evaluation, Static, Unknowns, evaluate, reweighed
from .solve import How, Solution, least_squares

_ROUNDS = 3  # of searches on orbits: on those of the first fit, on others that fit better, and off those that are none
_MISSED = 1.5  # of a record's mean squared residual: so much may have another orbit as its reason
_REWEIGHED = 4  # times that the noise of curves is carried through the model anew, at most
_SETTLED = 0.01  # relative change of the cost by new weights that is not worth another search
_LAST_STEPS = 25  # of a search in short steps of the solver, at most: the one in long ones has led near the minimum


class GoingOn:
    """Goes on from where a search has ended, as the search did (`how`), and reports how far it has come."""

    def __init__(self, how: How, report: Report):
        self.how, self._pulse = how, Pulse(report, "least squares")

    def __call__(
        self, static: Static, data: Data, unknowns: Unknowns, most: int, known: Evaluation | None = None
    ) -> tuple[Data, Solution]:
        """The end after so many steps more at the `most`; `known`: the model where they begin."""
        watch = lambda cost: self._pulse.beat(f"error over noise {data.error_of(cost):.3g}")
        return least_squares(static, data, unknowns, self.how._replace(most=most), known, watch)


def settled(
    static: Static, data: Data, found: Solution, records: Sequence[Trace], go_on: GoingOn
) -> tuple[Static, Data, Solution]:
    """A solution on orbits, with weights and beside histories that are its own; with the search before it in as many
    steps as that may take."""
    if not np.isfinite(found.cost):  # a motion without bound has none of them
        return static, data, found
    static, data, found = _on_its_orbits(static, data, found, records, go_on)
    data, found = _reweighed(static, data, found, go_on)
    return static, *_remembered(static, data, found, go_on)


def _on_its_orbits(
    static: Static, data: Data, found: Solution, records: Sequence[Trace], go_on: GoingOn
) -> tuple[Static, Data, Solution]:
    """A solution with the steady records on the stable orbits of the model that they show, and what remained unknown
    with the initial states fitted. Fits that are only compared look for no other orbits."""
    most, compared = go_on.how.most, go_on.how.compared
    barred: set[int] = set()
    for _ in range(_ROUNDS):
        before = data.steady
        if off := unstable(static, data, found.found):
            barred |= off
            static, data, unknowns = off_orbits(static, data, records, found.unknowns, off)
        else:
            static, data, unknowns = on_orbits(static, data, records, found.unknowns, barred)
        known = None
        missed = set() if compared or off or len(data.steady) != len(before) else _missed(data, found)
        if missed and (other := on_better_orbits(static, data, records, unknowns, found.found, missed)):
            data, known = other
        if data.steady == before:
            break
        data, better = go_on(static, data, unknowns, max(most - found.steps, 1), known)
        found = _after(found, better)
    return static, data, found


def _after(found: Solution, better: Solution) -> Solution:
    """A solution to which a search led that went on from another one, with the steps of both."""
    return better._replace(steps=found.steps + better.steps)


def _missed(data: Data, found: Solution) -> set[int]:
    """Steady records that the model misses."""
    errors = data.errors_of(found.found)
    return {one.record for one in data.steady if errors[one.record] ** 2 > _MISSED}


def _reweighed(static: Static, data: Data, found: Solution, go_on: GoingOn) -> tuple[Data, Solution]:
    """A solution with the noise of the curves carried through the model as it is there."""
    most = go_on.how.most
    sweeps = data.curves is not None or data.passes is not None
    for _ in range(_REWEIGHED if sweeps and np.isfinite(found.cost) else 0):
        before, data = data, reweighed(static, data, found.found.values)
        same = before.curves is None or data.curves is None or np.array_equal(before.curves.white, data.curves.white)
        again = evaluate(static, data, found.unknowns)
        cost = float(again.residuals @ again.residuals)
        done = (data.passes is None and same) or abs(cost - found.cost) < _SETTLED * found.cost
        found = found._replace(cost=cost, found=again)
        if done or found.steps >= most:
            break
        data, better = go_on(static, data, found.unknowns, most - found.steps, again)
        found = _after(found, better)
    return data, found


def _remembered(static: Static, data: Data, found: Solution, go_on: GoingOn) -> tuple[Data, Solution]:
    """A solution whose histories count against what it leaves itself, not what its start left."""
    most = go_on.how.most
    while found.steps < most and np.isfinite(found.cost):
        misfit = data.misfit_of(found.found)
        held = float(np.sum((data.misfit * found.unknowns.starts[:, 2:]) ** 2))
        if held * (1 - (misfit / data.misfit) ** 2) < _SETTLED * found.cost:
            break
        data, better = go_on(static, data._replace(misfit=misfit), found.unknowns, most - found.steps, found.found)
        found = _after(found, better)
    return data, found


def in_short_steps(
    static: Static, data: Data, found: Solution, records: Sequence[Trace], tape: Tape, go_on: GoingOn
) -> tuple[Data, Solution]:
    """A solution in the steps of the solver, those of a `tape`, that the error bars of its numbers need: those of a
    model that is only compared, which led near it, are up to three times as long."""
    if [span.substeps for span in tape.spans] == [span.substeps for span in data.tape.spans]:
        return data, found
    steady = tuple(one.stepped(records[one.record], tape.spans[one.record].substeps) for one in data.steady)
    data = data._replace(tape=tape, steady=steady)
    data, better = go_on(static, data, found.unknowns, min(go_on.how.most, _LAST_STEPS))
    return data, _after(found, better)
