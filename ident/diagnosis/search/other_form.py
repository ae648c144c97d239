"""Effects that have another form, the same as long as everything else is linear: which one, once a law bends?

A mode beside the stage's own and a part that the stage carries are one transfer function. The usual form has the name
until a law beside it tells them apart, and its score says nothing of that: the other one is refitted in its place, from
the numbers that make the same linear device.
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
from ..evidence.enough import adequate
from ..evidence.held_out import hurts
from ..linearised.regression import Regression, prepare
from ..linearised.shorten import CRAWLS, working
from ..linearised.trajectory import Diverged
from .steps import Step


class Instead(NamedTuple):
    """A `fit` with the effect called `name` in the place of the one called `usual`, and its `regression`."""

    usual: str
    name: str
    fit: Fit
    regression: Regression


def in_another_form(current: Fit, regression: Regression, library: Registry, report: Report) -> Instead | None:
    """A fit with one of its effects replaced by its other form, if that does clearly better; not one that the campaign
    names."""
    if current.model.form != "oscillator":
        return None
    for one in (effect for effect in current.model.effects if effect.name not in current.campaign.effects):
        for form in (effect for effect in library.values() if effect.form_of == one.name):
            found = None if current.model.carries(one.name) else _instead(current, one, form, regression, report)
            if found is not None:
                after, left = found
                report(f"{form.name} in the place of {one.name}: error over noise {after.fitted.error_over_noise:.3g}")
                return Instead(one.name, form.name, after, left)
    return None


def steps_in_another_form(
    steps: list[Step], regression: Regression, library: Registry, report: Report
) -> tuple[list[Step], Regression]:
    """The steps with an effect of the last fit replaced by its other form, and the regression of that fit, if that does
    clearly better; else what was given. One that the first model had is an addition of its own."""
    found = None if adequate(regression) else in_another_form(steps[-1].fit, regression, library, report)
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
    current: Fit, one: AbstractEffect, form: type[AbstractEffect], regression: Regression, report: Report
) -> tuple[Fit, Regression] | None:
    """The fit with the other form in the place of one, and its regression, if the records ask for it."""
    model = current.model
    frequency, quality, gain = (float(current.values[i]) for i in (FREQUENCY, QUALITY, GAIN))
    there = Linear(
        float(model.mass_of(current.values)), 2 * math.pi * frequency, quality, model.linear.force_per_gain * gain
    )
    same = form.in_its_form(there, {p.name: current.value(f"{one.name}.{p.name}") for p in one.parameters})
    if same is None:
        return None
    report(f"does {form.name} say more than {one.name}?")
    stage, numbers = same
    values = values_without(current, one.name)
    values[[FREQUENCY, QUALITY, GAIN]] = stage.omega / (2 * math.pi), stage.quality, gain * stage.push / there.push
    begin = np.concatenate([values, [numbers[p.name] for p in form.parameters]])
    try:
        after = fit(
            model - one.name + make_effect(current.campaign, form.name, {form.name: form}),
            current.campaign, initial=begin, most=CRAWLS,
        )  # fmt: skip
        left = prepare(working(after))
    except Diverged:
        return None
    return (after, left) if clearly_better(left, regression) and not hurts(current, after) else None
