"""Where the searches of a task begin: its starts, and the error at each."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from .assemble import at_values, begin, begin_at
from .fit_starts import fit_starts
from .problem import Data, Evaluation, Unknowns, evaluate
from .start_scale import small_size
from .starts import random_points, starting_points
from .task import Task

_KEPT = 4  # of the grid, the ones whose first error is smallest
_ROUNDS = 2  # in which initial states are fitted before a search: they enter almost linearly
_NEAR = 0.01  # of the cost: the search itself goes the rest
_SPREAD = 0.3  # of a parameter, by which random starts move it at most
_SEEN = 1.0  # noise floors of all numbers together by which a slope moves them at a small size, to be one


class Begun(NamedTuple):
    """A start: the `cost` Σ r² there, the arrays and the unknowns with which a search begins, and the model there."""

    cost: float
    data: Data
    unknowns: Unknowns
    found: Evaluation


def told_starts(task: Task, begun: np.ndarray | None = None) -> list[Begun]:
    """The starts that a task was told, best first; `begun`: their initial states (records, s) SI, if these are known.

    Histories count against what the best of them leaves: costs of one race are of one kind.
    """
    starts = _judged(task, task.told, begun)
    misfit = task.data.misfit_of(starts[0].found)
    return [one._replace(data=one.data._replace(misfit=misfit)) for one in starts]


def grid_starts(task: Task, begun: np.ndarray | None = None) -> list[Begun]:
    """The best starts of the grids of the model's shapes, best first."""
    return _with_off_zero(task, starting_points(task.model, task.base, task.scales), begun)[:_KEPT]


def random_starts(task: Task, count: int, seed: int, begun: np.ndarray | None = None) -> list[Begun]:
    """The first start and so many around it, best first."""
    around = random_points(task.model, task.base, count, _SPREAD, seed)
    return _with_off_zero(task, [task.base, *around], begun)


def _with_off_zero(task: Task, points: Sequence[np.ndarray], begun: np.ndarray | None) -> list[Begun]:
    """Starts at some points, best first, and on curves those beside the best one, too. What they leave says nothing of
    what the model will: histories do not count against that."""
    starts = _judged(task, points, begun)
    off = _off_zero(task, starts[0]) if task.campaign.fitted_sweeps else []
    return _best_first([*starts, *_judged(task, off, begun)])


def _judged(task: Task, points: Sequence[np.ndarray], begun: np.ndarray | None) -> list[Begun]:
    """The starts at some points, best first.

    Initial states as they were read; where a task was told the parameters, fitted first: a start read off a few samples
    is wrong by many noise floors, which a search mends by moving parameters away from where they belong. Near a hilltop
    of the spring it may have no bound at all, so that those that were `begun` with before are taken instead.
    """
    static, judged = task.static, []
    for point in points:
        there = at_values(task.data, static, point)
        unknowns = begin(there, static) if begun is None else begin_at(there, static, begun)
        if task.told and static.starts_free:
            unknowns, found = fit_starts(static, there, unknowns, _ROUNDS, _NEAR)
        else:
            found = evaluate(static, there, unknowns)
        judged.append(Begun(float(found.residuals @ found.residuals), there, unknowns, found))
    return _best_first(judged)


def _best_first(starts: list[Begun]) -> list[Begun]:
    return sorted(starts, key=lambda start: start.cost)


def _off_zero(task: Task, start: Begun) -> list[np.ndarray]:
    """Points beside a start at which amplitudes have no slope that would lead a search away from zero: an even force
    does nothing to a fundamental there, whichever its sign."""
    free, parameters, values = task.static.free, task.model.parameters, start.found.values
    sizes = [small_size(parameters[i].unit, task.scales, task.model.linear.mass) for i in free]
    unit = np.where(start.data.scale == 0, 1.0, start.data.scale)
    slopes = np.linalg.norm(start.found.by_x, axis=1) / unit
    flat = {i: size for i, size, slope in zip(free, sizes, slopes, strict=True)
            if values[i] == 0 and parameters[i].kind == "amplitude" and size * slope < _SEEN}  # fmt: skip
    points = []
    for sign in (1.0, -1.0) if flat else ():
        point = values.copy()
        point[list(flat)] = [sign * size for size in flat.values()]
        points.append(point)
    return points
