"""Where a walk begins again: with another drive between the samples, with other starts of its records, from a better
minimum of its first model, or of one with effects."""

from __future__ import annotations

import itertools
from dataclasses import replace

import numpy as np

from ...campaign.held_drive import Edges
from ...fit import Fit, fit
from ...fit.finish import Minimum
from ...fit.minimise import refit
from ...model import QUALITY
from ...pulse import Report
from ..evidence.criterion import clearly_better
from ..linearised.regression import prepare
from ..linearised.shorten import CRAWLS, is_long, working
from ..linearised.trajectory import Diverged
from ..ranking.look import Look
from ..side_by_side import at_once
from .drive import other_drive, with_edges
from .steps import Step

_MOST_SHAPES = 24  # each a refit to its end; one law has up to 20


def begun_with(start: Fit, edges: Edges) -> Fit:
    """The first model on a campaign whose drives run otherwise between their samples; one that had rung only to follow
    a drive that came at another time is overdamped."""
    campaign = with_edges(start.campaign, edges)
    again = fit(start.model, campaign, initial=start.values)
    if again.model.form != "oscillator" or "at-bound" not in again.estimates[QUALITY].flags:
        return again
    return fit(replace(start.model, form="overdamped"), campaign, initial=again.values)


def lower_start(start: Fit, last: Fit, report: Report) -> Fit | None:
    """The fit of the first model from where a walk has taken its numbers, if that is a clearly lower minimum than the
    one from which the walk began: a name may owe all that it gained to the way there."""
    if is_long(start.campaign) or start.campaign.sweeps:
        return None
    found = dict(zip((p.name for p in last.model.parameters), last.values, strict=True))
    initial = np.array([found.get(p.name, v) for p, v in zip(start.model.parameters, start.values, strict=True)])
    try:
        lower = fit(start.model, start.campaign, initial=initial)
        if not clearly_better(prepare(working(lower)), prepare(working(start))):
            return None
    except (Diverged, np.linalg.LinAlgError):  # from there the motion has no bound
        return None
    report("the first model has a better minimum: once more, from there")
    return lower


def another_minimum(current: Fit, start: Fit, report: Report) -> Fit | None:
    """The fit of a model from other shapes of the laws that a walk has added to the first one, beside the numbers of
    that, if it is a clearly better minimum than where the walk has come to.

    Beside a law of a wrong shape the linear part bends to make good for it, and from there no slope leads back. Each
    start is followed to its end: in a race the valley of the device's own shapes may fall last.
    """
    first = dict(zip((p.name for p in start.model.parameters), start.values, strict=True))
    begun = np.array([first.get(p.name, v) for p, v in zip(current.model.parameters, current.values, strict=True)])
    added = [effect.name for effect in current.model.effects if effect.name not in start.model.names]
    points = [point for name in added for point in _other_shapes(current, begun, name)]
    points = points[:: max(-(-len(points) // _MOST_SHAPES), 1)]
    if not points or current.campaign.sweeps:
        return None
    report(f"the same laws from {len(points)} other shapes")
    shown = working(current)

    def from_there(point: np.ndarray) -> Minimum:
        return refit(shown.model, shown.campaign, point, CRAWLS)

    try:
        best = min(at_once(from_there, points), key=lambda one: one.error)
        if not best.error < shown.fitted.error_over_noise:
            return None
        begins = best.best.found.starts if shown is current else None
        lower = fit(current.model, current.campaign, initial=best.values, begun=begins, most=CRAWLS)
        better = clearly_better(prepare(working(lower)), prepare(shown)) and lower.fitted.chi2 < current.fitted.chi2
    except (Diverged, np.linalg.LinAlgError):  # from there the motion has no bound
        return None
    return lower if better else None


def _other_shapes(current: Fit, begun: np.ndarray, effect: str) -> list[np.ndarray]:
    """Values at every point of the grid of one effect's shapes."""
    grids = {
        i: [g * getattr(current.scales, p.scale) for g in p.grid]
        for i, p in enumerate(current.model.parameters)
        if p.effect == effect and p.kind == "shape" and p.fitted and len(p.grid) > 1
    }
    points = []
    for shapes in itertools.product(*grids.values()) if grids else ():
        point = begun.copy()
        point[list(grids)] = shapes
        points.append(point)
    return points


def with_other_starts(one: Fit) -> Fit | None:
    """A fit with free starts of the records that do not seem to begin as they are said to; None where no record does,
    or the motion then has no bound."""
    otherwise = {name for name, _ in one.begun_otherwise}
    if not otherwise:
        return None
    records = (replace(r, start="unknown") if r.name in otherwise else r for r in one.campaign.records)
    try:
        freed = fit(one.model, replace(one.campaign, records=tuple(records)), initial=one.values, most=CRAWLS)
        prepare(working(freed))  # a fit itself only leaves what is no number
    except (Diverged, np.linalg.LinAlgError):
        return None
    return freed


def drive_beside(more: list[Step], current: Fit, look: Look) -> Edges | None:
    """Another drive between the samples, if the records ask for it beside what was added, and no effect promises more;
    beside the first of two, too, for the second may be its lag, where it explains no more than that drive does.

    `look`: at the fit with them."""
    if len(more) > 1:
        first = more[0].fit
        try:
            other = other_drive(first, prepare(working(first)), look.report, instead_of=look.regression)
        except Diverged:
            other = None
        if other is not None:
            return other
    return other_drive(current, look.regression, look.report, look)
