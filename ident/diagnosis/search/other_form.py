"""Effects that have another form, the same as long as everything else is linear: which one, once a law bends?

A mode beside the stage's own and a part that the stage carries are one transfer function. The usual form has the name
until a law beside it tells them apart, and its score says nothing of that: the other one is refitted in its place, from
the numbers that make the same linear device.
"""

from __future__ import annotations

import math

import numpy as np

from ...effects.effect import AbstractEffect, Linear
from ...effects.registry import Registry
from ...fit import Fit, fit
from ...model import FREQUENCY, GAIN, QUALITY, make_effect
from ...pulse import Report
from ..evidence.criterion import clearly_better
from ..evidence.enough import adequate
from ..evidence.held_out import hurts
from ..linearised.regression import Regression, prepare
from ..linearised.shorten import CRAWLS, working
from ..linearised.trajectory import Diverged
from .change import values_without
from .steps import Step


def in_another_form(
    steps: list[Step], regression: Regression, library: Registry, report: Report
) -> tuple[list[Step], Regression]:
    """The steps with an effect of the last fit replaced by its other form, if that does clearly better, and the
    regression of that fit; else what was given. One that the first model had is an addition of its own."""
    current = steps[-1].fit
    if current.model.form != "oscillator" or adequate(regression):
        return steps, regression
    for one in current.model.effects:
        for form in (effect for effect in library.values() if effect.form_of == one.name):
            found = None if current.model.carries(one.name) else _instead(current, one, form, regression, report)
            if found is None:
                continue
            fitted, left = found
            report(f"{form.name} in the place of {one.name}: error over noise {fitted.fitted.error_over_noise:.3g}")
            gain = 1.0 - (left.chi2 - left.n) / (regression.chi2 - regression.n)
            own = Step(form.name, gain, gain, (form.name,), "effect", fitted, regression=regression)
            renamed = {"added": form.name, "tie_set": (form.name,), "reasons": (), "tied": ()}
            named = [step._replace(**renamed) if step.added == one.name else step for step in steps]
            if named == steps:
                return [*steps, own], left
            return [*named[:-1], named[-1]._replace(fit=fitted)], left
    return steps, regression


def _instead(
    current: Fit, one: AbstractEffect, form: type[AbstractEffect], regression: Regression, report: Report
) -> tuple[Fit, Regression] | None:
    """The fit with the other form in the place of one, and its regression, if the records ask for it."""
    model = current.model
    frequency, quality, gain = (float(current.values[i]) for i in (FREQUENCY, QUALITY, GAIN))
    there = Linear(model.linear.mass, 2 * math.pi * frequency, quality, model.linear.force_per_gain * gain)
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
