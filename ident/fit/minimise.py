"""The least-squares minimum of a model on the records of a campaign, without uncertainties.

The searches of a fit go from the best starts to their ends, one after the other; those of a model that is only compared
with others race. The best one then goes on until all that it stands on is its own.
"""

from __future__ import annotations

import time
from collections.abc import Sequence

import numpy as np

from ..campaign.campaign import Campaign
from ..model import Model
from ..pulse import Pulse, Report
from .finish import Minimum
from .first_errors import Begun, grid_starts, random_starts, told_starts
from .linear.guess import DataScales
from .on_orbits import on_orbits
from .race import GoOn, cost_of, race
from .result import Start
from .settled import GoingOn, in_short_steps, settled
from .solve import How, Search
from .task import Points, Task, task_of

AT_THE_FLOOR = 1.02  # error over noise with which no further start of the grid can be better
_IN_A_RACE = 6  # of the starts that were told, the ones whose first error is smallest


def minimise(
    model: Model,
    campaign: Campaign,
    how: How,
    *,
    initial: Points | None = None,
    begun: np.ndarray | None = None,
    starts: int = 0,
    seed: int = 0,
    report: Report = lambda _: None,
) -> Minimum:
    """The minimum of a fit; `how` each of its searches goes, the others as in `fit`.

    **Raises:** UserError if there is nothing to fit.
    """
    task = task_of(model, campaign, initial, report)
    if task.told:
        first = told_starts(task, begun)
    else:
        first = random_starts(task, starts, seed, begun) if starts else grid_starts(task, begun)
    go_on, searches = _reported(task, report, len(first)), []
    for number, start in enumerate(first, 1):
        searches.append(_search_from(task, start, how))
        go_on(number, searches[-1], how.most)
        enough = not (task.told or starts) and task.data.error_of(searches[-1].cost) < AT_THE_FLOOR
        if enough or time.monotonic() > how.until:
            break
    return _ended(task, first, searches, how, report)


def refit(
    model: Model,
    campaign: Campaign,
    initial: Points | None,
    most: int,
    *,
    report: Report = lambda _: None,
    scales: DataScales | None = None,
) -> Minimum:
    """The minimum of a model that is only compared with others, as nearly as that needs: of the best `initial` points,
    or of the grids if there are none, as a race of `most` steps has it.

    `scales`: by which limits are placed, if not those of the campaign's records: of all records, where these are a
    part. **Raises:** UserError if there is nothing to fit.
    """
    how = How(most=most, compared=True)
    task = task_of(model, campaign, initial, report, scales)
    first = told_starts(task)[:_IN_A_RACE] if task.told else grid_starts(task)
    searches = [_search_from(task, start, how) for start in first]
    race(searches, most, _reported(task, report, len(first)))
    return _ended(task, first, searches, how, report)


def _search_from(task: Task, start: Begun, how: How) -> Search:
    if not task.told:  # the first search says which of several orbits a steady record shows
        return Search(task.static, start.data, start.unknowns, how, start.found)
    static, data, unknowns = on_orbits(task.static, start.data, task.records, start.unknowns)
    return Search(static, data, unknowns, how, None if data.steady else start.found)


def _reported(task: Task, report: Report, many: int) -> GoOn:
    """Lets one of so many searches go on, and reports how far it has come."""

    def go_on(number: int, one: Search, most: int) -> None:
        stage = f"least squares, start {number} of {many}"
        report(stage)
        pulse = Pulse(report, stage)
        one.go_on(most, lambda cost: pulse.beat(f"error over noise {task.data.error_of(cost):.3g}"))

    return go_on


def _ended(task: Task, first: Sequence[Begun], searches: Sequence[Search], how: How, report: Report) -> Minimum:
    """Where the best of the searches ends, gone on with until all that it stands on is its own, and those of them all.

    All starts had the same weights; those of the best one's model are its own.
    """
    best, further = min(searches, key=cost_of), GoingOn(how, report)
    static, data, found = settled(best.static, *best.found, task.records, further)
    if not how.compared:
        data, found = in_short_steps(static, data, found, task.records, task.short_steps(), further)
    ends = [found if one is best else one.found[1] for one in searches]
    table = [
        Start(data.error_of(start.cost), data.error_of(end.cost), end.steps, end.converged)
        for start, end in zip(first, ends, strict=False)  # a fit that has found the floor leaves the rest out
    ]
    return Minimum(static, data, found, tuple(table), task.scales)
