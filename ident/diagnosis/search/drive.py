"""The drive between its samples at every node of a walk: is it held, and since when?

The start model chose it beside the whole misfit (`fit.linear.drives`), in which a drive that is held, and so late, may
hide behind an effect, or an effect behind it. What another drive does to the readings is a push along the motion that
was measured, g (V' − V), with no number to fit; the criterion weighs it as it weighs effects, and a refit has the last
word. Left out, it would be named a lag.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import TypeGuard

import numpy as np

from ...campaign.campaign import Campaign
from ...campaign.device import Oscillator
from ...campaign.drive import half_step_drive
from ...campaign.held_drive import Edges, jumps
from ...campaign.record import Trace
from ...fit import Fit, fit
from ...pulse import Report
from ...response.system import assemble
from ..evidence.criterion import VERY_STRONG, Left, Weighed, clearly_better, criteria
from ..evidence.enough import MOST_OF_IT
from ..linearised.push_columns import push_columns
from ..linearised.regression import Regression, by_record, prepare
from ..linearised.shorten import CRAWLS
from ..linearised.trajectory import Diverged
from ..ranking.look import Look

_EDGES = np.arange(-1.0, 2.01, 0.25)  # of drives that jump, in sampling intervals; between them a parabola tells
_CLOSER = (0.25, 0.1, 0.05)  # sampling intervals between the three through which it is drawn
_AGAIN = 4  # refits at most until an edge stays


def other_drive(
    fitted: Fit, regression: Regression, report: Report, look: Look | None = None, instead_of: Regression | None = None
) -> Edges | None:
    """Other drives between the samples than those of a fit, if the records clearly ask for them by now; what a campaign
    says itself stays.

    **Arguments:** `regression`: of the fit; `look`: at it, for an effect that may be added, which the drive must
    explain as well: if it promises less, but most of that, once both are refitted; `instead_of`: of the fit with one
    that has been, than which the drive must do no worse.
    """
    records = [r for r in fitted.campaign.fitted if _may_be_otherwise(r)]
    if not records or not isinstance(fitted.model.device, Oscillator) or not regression.credible:
        return None
    now = edges_of(fitted.campaign)
    ways = [way for way in _ways(regression, records, now) if way != now]
    left = _left_with(regression, ways)
    numbers = lambda way: regression.numbers + way.numbers
    weighed = [Left(x, numbers(way)) for x, way in zip(left, ways, strict=True)]
    here = Left(regression.residual, numbers(now))
    *others, _ = criteria([*weighed, here])
    best = int(np.argmin(others))
    way, drop = ways[best], regression.chi2 - float(left[best] @ left[best])
    promise = 0.0 if look is None else look.promise
    if not clearly_better(weighed[best], here) or drop < min(MOST_OF_IT * promise, promise - VERY_STRONG):
        return None
    rivals: list[Weighed] = []
    if look is not None and drop < promise - VERY_STRONG:
        rivals += [one for one in look.tried if one.possible]
    try:
        shown = fit(fitted.model, with_edges(regression.fit.campaign, way), initial=fitted.values, most=CRAWLS)
        there = prepare(shown)
        reached, simulated = Left(there.residual, numbers(way)), Left(there.left, numbers(way))
        second = instead_of and Left(instead_of.residual, instead_of.numbers)
        if not clearly_better(reached, here) or (second is not None and clearly_better(second, reached)):
            return None
        if way.numbers:
            way = _settled(shown, way)
        if rivals and any(clearly_better(rival, simulated) for rival in rivals):
            # An effect may mimic an edge that is not yet where it belongs better than that does.
            shown = fit(shown.model, with_edges(shown.campaign, way), initial=shown.values, most=CRAWLS)
            simulated = Left(prepare(shown).left, numbers(way))
            if any(clearly_better(rival, simulated) for rival in rivals):
                return None
    except Diverged:
        return None
    where = "" if way.everywhere else ", where it jumps,"
    held = "is a smooth curve" if way.first is None else f"is held{where} from {way.first:+.2g} samples"
    report(f"the drive {held} between its samples: once more, with such a drive")
    return way


def with_edges(campaign: Campaign, way: Edges) -> Campaign:
    """The campaign with another drive between the samples, where it does not say what it is."""
    records = (replace(r, edge=way.of(r.drive)) if _may_be_otherwise(r) else r for r in campaign.records)
    return replace(campaign, records=tuple(records))


def smooth_instead(campaign: Campaign) -> Edges | None:
    """A drive that is held only where it jumps, if it is taken for one that is held everywhere, and no campaign says
    so."""
    records, now = [record for record in campaign.fitted if _may_be_otherwise(record)], edges_of(campaign)
    held = now.first is not None and now.everywhere and not all(jumps(record.drive) for record in records)
    return now._replace(everywhere=False) if held else None


def edges_of(campaign: Campaign) -> Edges:
    """What the drives of a campaign are taken for, where it does not say what they are."""
    edges = [record.edge for record in campaign.fitted if _may_be_otherwise(record)]
    first = next((edge for edge in edges if edge is not None), None)
    return Edges(first, first is None or None not in edges)


def _ways(regression: Regression, records: Sequence[Trace], now: Edges) -> list[Edges]:
    """What drives may be between their samples: smooth, or held on the clock of the samples or, where they jump, with
    the edges that leave least; each everywhere, or only where they jump."""
    ways, jumping = [Edges(), Edges(0.0)], [jumps(record.drive) for record in records]
    for everywhere in (True, False) if any(jumping) else ():
        if not everywhere and all(jumping):
            continue
        tried = [Edges(float(edge), everywhere) for edge in _EDGES]
        found = _left_with(regression, tried)
        ways += [Edges(0.0, everywhere), _refined(regression, tried[np.argmin([float(x @ x) for x in found])])]
    if any(jumping) and now.first is not None:  # found beside what has been missing, and perhaps bent by it
        ways.append(_refined(regression, now))
    return list(dict.fromkeys(ways))


def _may_be_otherwise(record: object) -> TypeGuard[Trace]:
    """Whether a record does not say itself what its drive is, and where its edges lie is no number of its own."""
    if not isinstance(record, Trace) or record.between != "auto" or not record.driven:
        return False
    return record.edge is None or record.own is None or record.own[0] != "delay"


def _left_with(regression: Regression, ways: Sequence[Edges]) -> list[np.ndarray]:
    """Whitened residuals (n,) with other drives, without what the model absorbs."""
    trajectories = regression.trajectories
    tape, equation = trajectories.tape, trajectories.solved.static.equation
    gain = float(assemble(equation, equation.constants, regression.fit.values).gain)
    grids = []
    for record, lane, span in zip(regression.fit.campaign.fitted, tape.lanes, tape.spans, strict=True):
        edges = [way.of(record.drive) if _may_be_otherwise(record) else record.edge for way in ways]
        others = [half_step_drive(replace(record, edge=edge), span.substeps)[0] for edge in edges]
        grids.append(gain * np.stack([other - lane.voltage for other in others]))
    rows = by_record(regression, push_columns(tape, trajectories.dynamics, tape.windows(grids)))
    traces = regression.left[: rows.shape[1]]
    rest = regression.left[rows.shape[1] :]
    return list(regression.project(np.concatenate([traces - rows, np.tile(rest, (len(ways), 1))], axis=1)))


def _settled(shown: Fit, way: Edges) -> Edges:
    """The edges of a fit with them, sought again from there until they stay: they were found beside a model that lacked
    them, whose damping had made good a part."""
    for _ in range(_AGAIN):
        before, way = way, _refined(prepare(shown), way)
        if abs((way.first or 0.0) - (before.first or 0.0)) < _CLOSER[-1]:
            break
        shown = fit(shown.model, with_edges(shown.campaign, way), initial=shown.values, most=CRAWLS)
    return way


def _refined(regression: Regression, way: Edges) -> Edges:
    """The edges that leave least: by the parabola through three, and through three that lie closer there."""
    edge = way.first or 0.0
    for spacing in _CLOSER:
        three = [way._replace(first=edge + shift * spacing) for shift in (-1, 0, 1)]
        low, middle, high = (float(x @ x) for x in _left_with(regression, three))
        bend = low - 2 * middle + high
        edge += 0.5 * spacing * (low - high) / bend if bend > 0 else 0.0
    return way._replace(first=edge)
