"""The drive between its samples at every node of a walk: is it held, and since when?

The start model chose it beside the whole misfit (`fit.linear.drives`), in which a drive that is held, and so late, may
hide behind an effect, or an effect behind it. What another drive does to the readings is a push along the motion that
was measured, g (V' − V), with no number to fit; the criterion weighs it as it weighs effects, and a refit has the last
word. Left out, it would be named a lag.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from ...campaign.campaign import Campaign
from ...campaign.device import Oscillator
from ...campaign.drive import half_step_drive
from ...campaign.held_drive import jumps
from ...campaign.record import Trace
from ...fit import Fit, fit
from ...pulse import Report
from ...response.system import assemble
from ..evidence.criterion import VERY_STRONG, Left, Weighed, clearly_better, criteria
from ..evidence.enough import MOST_OF_IT
from ..linearised.columns import push_columns
from ..linearised.regression import Regression, by_record, prepare
from ..linearised.shorten import CRAWLS
from ..linearised.trajectory import Diverged
from ..ranking.look import Look

_EDGES = np.arange(-1.0, 2.01, 0.25)  # of drives that jump, in sampling intervals; between them a parabola tells
_CLOSER = (0.25, 0.1, 0.05)  # sampling intervals between the three through which it is drawn
_AGAIN = 4  # refits at most until an edge stays


def other_drive(
    fitted: Fit, regression: Regression, report: Report, look: Look | None = None, instead_of: Regression | None = None
) -> Campaign | None:
    """The campaign of a fit with another drive between the samples, if the records clearly ask for it by now; what it
    says itself stays.

    **Arguments:** `regression`: of the fit; `look`: at it, for an effect that may be added, which the drive must
    explain as well: if it promises less, but most of that, once both are refitted; `instead_of`: of the fit with one
    that has been, than which the drive must do no worse.
    """
    records = [r for r in fitted.campaign.fitted if _may_be_otherwise(r)]
    if not records or not isinstance(fitted.model.device, Oscillator) or not regression.credible:
        return None
    now, jumping = records[0].edge, any(jumps(r.drive) for r in records)
    edges = [None, 0.0]
    if jumping:
        found = _left_with(regression, list(_EDGES))
        edges.append(_refined(regression, float(_EDGES[np.argmin([float(x @ x) for x in found])])))
        if now is not None:  # found beside what has been missing, and perhaps bent by it
            edges.append(_refined(regression, now))
    edges = [e for e in edges if e != now]
    left = _left_with(regression, edges)
    numbers = lambda edge: regression.numbers + (edge not in (None, 0.0))
    weighed = [Left(x, numbers(edge)) for x, edge in zip(left, edges, strict=True)]
    here = Left(regression.residual, numbers(now))
    *others, _ = criteria([*weighed, here])
    best = int(np.argmin(others))
    edge, drop = edges[best], regression.chi2 - float(left[best] @ left[best])
    promise = 0.0 if look is None else look.promise
    if not clearly_better(weighed[best], here) or drop < min(MOST_OF_IT * promise, promise - VERY_STRONG):
        return None
    rivals: list[Weighed] = []
    if look is not None and drop < promise - VERY_STRONG:
        rivals += [one for one in look.tried if one.possible]
    try:
        shown = fit(fitted.model, with_edges(regression.fit.campaign, edge), initial=fitted.values, most=CRAWLS)
        there = prepare(shown)
        reached, simulated = Left(there.residual, numbers(edge)), Left(there.left, numbers(edge))
        second = instead_of and Left(instead_of.residual, instead_of.numbers)
        if not clearly_better(reached, here) or (second is not None and clearly_better(second, reached)):
            return None
        if any(clearly_better(rival, simulated) for rival in rivals):
            return None
        if edge not in (None, 0.0):
            edge = _settled(shown, edge)
    except Diverged:
        return None
    held = "is a smooth curve" if edge is None else f"is held, from {edge:+.2g} samples"
    report(f"the drive {held} between its samples: once more, with such a drive")
    return with_edges(fitted.campaign, edge)


def with_edges(campaign: Campaign, edge: float | None) -> Campaign:
    """The campaign with another drive between the samples, where it does not say what it is."""
    records = (replace(r, edge=edge) if _may_be_otherwise(r) else r for r in campaign.records)
    return replace(campaign, records=tuple(records))


def _may_be_otherwise(record: object) -> bool:
    """Whether a record does not say itself what its drive is, and where its edges lie is no number of its own."""
    if not isinstance(record, Trace) or record.between != "auto" or not record.driven:
        return False
    return record.edge is None or record.own is None or record.own[0] != "delay"


def _left_with(regression: Regression, edges: Sequence[float | None]) -> list[np.ndarray]:
    """Whitened residuals (n,) with other drives, without what the model absorbs."""
    trajectories = regression.trajectories
    tape, equation = trajectories.tape, trajectories.solved.static.equation
    gain = float(assemble(equation, equation.constants, regression.fit.values).gain)
    grids = []
    for record, lane, span in zip(regression.fit.campaign.fitted, tape.lanes, tape.spans, strict=True):
        free = _may_be_otherwise(record)
        others = [half_step_drive(replace(record, edge=e if free else record.edge), span.substeps)[0] for e in edges]
        grids.append(gain * np.stack([other - lane.voltage for other in others]))
    rows = by_record(regression, push_columns(tape, trajectories.dynamics, tape.windows(grids)))
    traces = regression.left[: rows.shape[1]]
    rest = regression.left[rows.shape[1] :]
    return list(regression.project(np.concatenate([traces - rows, np.tile(rest, (len(edges), 1))], axis=1)))


def _settled(shown: Fit, edge: float) -> float:
    """The edge of a fit with it, sought again from there until it stays: it was found beside a model that lacked it,
    whose damping had made good a part."""
    for _ in range(_AGAIN):
        before, edge = edge, _refined(prepare(shown), edge)
        if abs(edge - before) < _CLOSER[-1]:
            break
        shown = fit(shown.model, with_edges(shown.campaign, edge), initial=shown.values, most=CRAWLS)
    return edge


def _refined(regression: Regression, edge: float) -> float:
    """The edge that leaves least: by the parabola through three, and through three that lie closer there."""
    for spacing in _CLOSER:
        low, middle, high = (float(x @ x) for x in _left_with(regression, [edge - spacing, edge, edge + spacing]))
        bend = low - 2 * middle + high
        edge += 0.5 * spacing * (low - high) / bend if bend > 0 else 0.0
    return edge
