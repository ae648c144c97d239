"""Effects that have another form, which says the same until the records ask for more.

A mode beside the stage's own and a part that the stage carries are one transfer function until a law bends; a contact
that bends before it slides is dry friction until it slides by little. The usual form has the name, and what it leaves
beyond noise says nothing of the other, which is refitted in its place: from the numbers that make the same linear
device, or from those that its score tells there.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from ...effects.effect import AbstractEffect, Linear
from ...effects.registry import Registry
from ...fit import Fit, fit
from ...fit.rebuild import values_without
from ...model import FREQUENCY, GAIN, QUALITY, make_effect
from ...pulse import Report
from ..evidence.criterion import clearly_better
from ..evidence.enough import LITTLE, adequate
from ..evidence.held_out import hurts
from ..linearised.regression import Regression, prepare
from ..linearised.shorten import CRAWLS, working
from ..linearised.trajectory import Diverged
from ..ranking.confirm import accept
from .change import RACE, from_its_score
from .steps import Step


class Instead(NamedTuple):
    """A `fit` with the effect called `name` in the place of the one called `usual`, and its `regression`."""

    usual: str
    name: str
    fit: Fit
    regression: Regression


def in_another_form(
    current: Fit, regression: Regression, start: Fit, library: Registry, report: Report
) -> Instead | None:
    """A fit with one of its effects replaced by another form of it, if that does clearly better; not one that the
    campaign names. `start`: the fit before any effect was added."""
    own = [one for one in current.model.effects if one.name not in current.campaign.effects]
    for one in (one for one in own if not current.model.carries(one.name)):
        others = (effect for effect in library.values() if effect.name not in current.model.names)
        for form in (effect for effect in others if one.name in effect.form_of):
            report(f"does {form.name} say more than {one.name}?")
            try:
                after = _instead(current, one, form, start, regression)
                if after is None:
                    continue
                left = prepare(working(after))
            except Diverged:
                continue
            if clearly_better(left, regression) and not hurts(current, after):
                report(f"{form.name} in the place of {one.name}: error over noise {after.fitted.error_over_noise:.3g}")
                return Instead(one.name, form.name, after, left)
    return None


def steps_in_another_form(
    steps: list[Step], regression: Regression, start: Fit, library: Registry, report: Report
) -> tuple[list[Step], Regression]:
    """The steps with an effect of the last fit replaced by its other form, and the regression of that fit, if that does
    clearly better; else what was given. One that the first model had is an addition of its own."""
    found = None if adequate(regression) else in_another_form(steps[-1].fit, regression, start, library, report)
    if found is None:
        return steps, regression
    left = found.regression
    gain = 1.0 - (left.chi2 - left.n) / (regression.chi2 - regression.n)
    own = Step(
        added=found.name,
        predicted_gain=gain,
        confirmed_gain=gain,
        tie_set=(found.name,),
        role="effect",
        fit=found.fit,
        regression=regression,
    )
    if found.usual not in [step.added for step in steps]:
        return [*steps, own], left
    renamed = {"added": found.name, "tie_set": (found.name,), "reasons": (), "tied": ()}
    named = [step._replace(**renamed) if step.added == found.usual else step for step in steps]
    return [*named[:-1], named[-1]._replace(fit=found.fit)], left


def _instead(
    current: Fit, one: AbstractEffect, form: type[AbstractEffect], start: Fit, usual: Regression
) -> Fit | None:
    """The fit with another form in the place of an effect; None if it has no such form here, or none that leaves as
    little as the `usual` one after as many steps as tell the best of several shapes."""
    if not form.overrides("in_its_form"):
        return _where_its_score_leads(current, one, form, start, usual)
    begin = _the_same_linear_device(current, one, form)
    if begin is None:
        return None
    model = current.model - one.name + make_effect(current.campaign, form.name, {form.name: form})
    return fit(model, current.campaign, initial=begin, most=CRAWLS)


def _where_its_score_leads(
    current: Fit, one: AbstractEffect, form: type[AbstractEffect], start: Fit, usual: Regression
) -> Fit | None:
    most_left = (1.0 + LITTLE) * (usual.best_chi2 - usual.n)
    for most in (RACE, CRAWLS):  # on a mass whose spring re-centres a form that is not it took four minutes
        found = from_its_score(current, one.name, form, start, most)
        if found is None or not found[1].possible or found[1].chi2 - usual.n > most_left:
            return None
    return accept(found[1], current)


def _the_same_linear_device(current: Fit, one: AbstractEffect, form: type[AbstractEffect]) -> np.ndarray | None:
    """Values, with those of the form at the end, that make the same linear device."""
    model = current.model
    if model.form != "oscillator":
        return None
    frequency, quality, gain = (float(current.values[i]) for i in (FREQUENCY, QUALITY, GAIN))
    there = Linear(
        float(model.mass_of(current.values)), 2 * math.pi * frequency, quality, model.linear.force_per_gain * gain
    )
    same = form.in_its_form(there, {p.name: current.value(f"{one.name}.{p.name}") for p in one.parameters})
    if same is None:
        return None
    stage, numbers = same
    values = values_without(current, one.name)
    values[[FREQUENCY, QUALITY, GAIN]] = stage.omega / (2 * math.pi), stage.quality, gain * stage.push / there.push
    return np.concatenate([values, [numbers[p.name] for p in form.parameters]])
