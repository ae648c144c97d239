"""A platform's sensor whose zero is off, told by the first samples of records that start from rest, whatever else is
missing: it is named before all that would bend to mimic it.

An oscillator's constant is part of its linear start model (`fit.linear.choice`). A platform's linear part is known, so
that its constant is a step of the walk, the first one.
"""

from __future__ import annotations

from dataclasses import replace
from typing import NamedTuple

from ...campaign.device import Platform
from ...effects.linear_side import constant_on
from ...effects.registry import Registry
from ...fit import Fit, fit
from ...fit.linear.choice import begin_off_zero
from ...pulse import Report
from ..evidence.criterion import behind
from ..ranking.confirm import accept, confirm
from ..ranking.look import Look, first_look
from .as_step import step_with
from .conclude import tied_at_the_end
from .steps import Discovery, Step, Walked


class Zero(NamedTuple):
    """The fit with which the walk begins, the step that names the constant, and the look at that fit."""

    start: Fit
    step: Step
    look: Look

    def beside(self, walked: Walked) -> Walked:
        """The walk that goes on from the fit with the constant."""
        return Walked(self.step.fit, walked.steps[1:], walked.gains)

    def before(self, walked: Walked) -> Walked:
        """The whole walk, of one that went on from there."""
        start, campaign = self.start, walked.start.campaign
        if len(campaign.left_out) > len(start.campaign.left_out):  # a run is read back with one set of records
            start = fit(start.model, campaign, initial=start.values)
        return Walked(start, (self.step._replace(fit=walked.start), *walked.steps), walked.gains)

    def whole(self, found: Discovery, report: Report) -> Discovery:
        """The discovery with this step first; what it ties with, now that all others are in."""
        start, step = self.start, self.step._replace(fit=found.start)
        if found.start.campaign is not start.campaign:  # other noise floors, or records read otherwise
            start = fit(start.model, found.start.campaign, initial=start.values)
        if found.steps:
            step = tied_at_the_end(step, found.final, start, self.look.library, report)
        alone = "ambiguous" if len(step.tie_set) > 1 else "identified"
        verdict = alone if found.verdict in ("adequate", "identified") else found.verdict
        confirmed = {step.added: step.confirmed_gain}
        ranking = tuple(self.look.candidates)
        steps = (step, *found.steps)
        return replace(found, verdict=verdict, start=start, steps=steps, ranking=ranking, confirmed=confirmed)


def zero_of_the_sensor(walked: Walked, library: Registry, report: Report) -> Zero | None:
    """The constant of a platform's sensor, if its records begin off zero, and the fit says so, too."""
    start, constant = walked.start, constant_on("sensor", library)
    there = any(effect.is_constant for effect in start.model.effects)
    if constant is None or there or not isinstance(start.model.device, Platform):
        return None
    if not begin_off_zero(start.campaign.fitted):
        return None
    look = first_look(start, library, report)
    candidate = next((c for c in look.real if c.name == constant.name), None)
    if candidate is None:
        return None
    if walked.steps:
        return Zero(start, walked.steps[0], look) if walked.steps[0].added == constant.name else None
    report(f"the records begin off zero: {constant.name}")
    found = confirm(look.regression, constant, candidate)
    if not found.possible or behind(found, look.regression) >= 0:
        return None
    step = step_with(found, look.regression, look.real, library, "effect", accept(found, start), tried=[found])
    return Zero(start, step, look)
