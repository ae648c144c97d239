"""One effect more, or some less: refits from a parent."""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache

import numpy as np

from ...effects.effect import AbstractEffect
from ...effects.registry import effect_class, find, registry
from ...fit import Fit, fit
from ...fit.minimise import refit
from ...fit.rebuild import fit_at, values_without
from ...fit.solve import MAX_STEPS
from ...fit.starts import starting_points
from ...pulse import Report
from ...threads import one_thread
from ..linearised.regression import Regression, prepare
from ..linearised.shorten import CRAWLS, working
from ..ranking.confirm import Confirmed, confirm
from ..ranking.score import score
from ..ranking.starts import is_possible, shapes_of, start_of, with_effect, with_one, without_unseen

RACE = 12  # steps, after which the best of several shapes is known
_FEW = 4  # steps after which the better of two starts is known
ENOUGH = 25  # steps from the parent's values: a model that is as good without the effect, or with another, is near by


@one_thread
def add(
    parent: Fit,
    effect: str | type[AbstractEffect],
    report: Report = lambda _: None,
    others: int = 4,
    most: int = MAX_STEPS,
) -> Fit:
    """The parent's model with one effect more, fitted from the size that the score predicts, with the parent's values
    or those to which it moves them, whichever leads further, and from so many `others` of its grids, in at most so many
    steps from each.

    **Raises:** UserError if there is no such effect, the model has it, or it cannot act on this device.
    """
    effect = find(effect, registry(parent.campaign.effect_files)) if isinstance(effect, str) else effect_class(effect)
    report(f"estimating {effect.name} along the measured motion")
    regression = prepare(parent)
    found = score(regression, {effect.name: effect}, forms=True)
    scored = found[0] if found else None
    if scored is not None and scored.otherwise:
        scored = confirm(regression, effect, scored).candidate
    model = without_unseen(with_effect(parent, effect, None if scored is None else scored.words), scored)
    own = start_of(model, scored, parent.scales)
    first = np.concatenate([parent.values, own])
    grid = starting_points(model, first, parent.scales, others)[1:]
    if scored is not None and scored.beside is not None:
        starts = [first, np.concatenate([scored.beside, own])]
        first = refit(model, parent.campaign, starts, _FEW, report=report).values
    return fit(model, parent.campaign, initial=[first, *grid], report=report, most=most)


@one_thread
def remove(parent: Fit, name: str, report: Report = lambda _: None) -> Fit:
    """The parent's model without one effect, fitted from the parent's values."""
    return fit(parent.model - name, parent.campaign, initial=values_without(parent, name), report=report)


def without(parent: Fit, names: Sequence[str]) -> Fit:
    """The parent's model without several effects, in as many steps as a refit that is only compared."""
    model = parent.model
    for name in reversed(names):
        model = model - name
    return fit(model, parent.campaign, initial=values_without(parent, *names), most=CRAWLS)


@lru_cache(maxsize=8)  # asked whether a model needs an effect, what stands in its place, and what it is mistaken for
def try_without(parent: Fit, name: str, start: Fit) -> Fit:
    """The parent's model without one effect, only to compare: a model that lacks what it needs would crawl for long,
    and no number of it is reported.

    `start`: the fit before any effect was added. An effect may have taken over the stiffness or the damping; from its
    linear parameters the model finds back. Where another effect would have to be what it cannot be (friction that
    drives, for want of a drag), the others stay as they were.
    """
    model, rest = parent.model - name, values_without(parent, name)
    linear = sum(p.kind == "linear" for p in model.parameters)
    starts = [rest, np.concatenate([start.values[:linear], rest[linear:]])]
    race = refit(model, parent.campaign, starts, _FEW)
    found = refit(model, parent.campaign, race.values, ENOUGH)
    begun = found.best.found.starts
    # What is kept of it is fitted to its end.
    without = fit_at(model, parent.campaign, found.values, converged=False, begun=begun)
    return without if still_possible(without, parent) else fit_at(model, parent.campaign, rest, converged=False)


def from_its_score(
    parent: Fit, name: str, effect: type[AbstractEffect], start: Fit, most: int, refining: bool = True
) -> tuple[Regression, Confirmed] | None:
    """A refit of an effect in the place of the one called `name`, from where its score leads there, and the regression
    of the fit without either; None if its score says nothing. `start`, as of `try_without`."""
    below = prepare(try_without(working(parent), name, start))
    scored = score(below, {effect.name: effect}, forms=True)
    if not scored:
        return None
    return below, confirm(below, effect, scored[0], most, values_without(parent, name), refining)


def still_possible(after: Fit, before: Fit) -> bool:
    """Whether the effects that were possible before a change are so after it: a stop may have bent what is gone."""
    possible = lambda fit, effect: is_possible(fit.model, fit.values, effect, fit.scales)
    able = {e.name for e in before.model.effects if possible(before, e)}
    return all(possible(after, e) for e in after.model.effects if e.name in able)


def to_its_end(found: Fit, report: Report = lambda _: None) -> Fit:
    """A fit that was only compared so far, as long as it takes, with the initial states that it had found.

    Where a law has a kink, slopes tell nothing of a shape that no step resolves, and a search stops before its end: it
    then begins again with other shapes.
    """
    model, campaign, begun = found.model, found.campaign, found.solved.found.starts
    last = fit(model, campaign, initial=found.values, begun=begun, report=report)
    kinked = {effect.name for effect in model.effects if effect.has_kink}
    shapes = [(i, x) for i, x in shapes_of(model, last) if model.parameters[i].name.partition(".")[0] in kinked]
    if last.converged or not shapes:
        return last
    starts = [last.values, *(with_one(last.values, i, x) for i, x in shapes)]
    best = refit(model, campaign, starts, RACE)
    other = fit(model, campaign, initial=best.values, report=report)
    return min(last, other, key=lambda one: one.fitted.chi2)
