"""The values of a model from which what it lacks is seen best, where those of its fit are far from the device's own.

A fit that lacks an effect bends its parameters to mimic it. Seen from there the motion passes through dynamics that are
not the device's, which blurs every candidate. Two things may be nearer: what the equation of motion itself, along the
measured motion, says of spring, damper and gain; and the values that describe a single record. What bends a fit are the
strong records: from the device's own small motion the missing effect stands out.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ...campaign.record import Trace
from ...fit import Fit, fit
from ...fit.rebuild import fit_at
from ...fit.starts import base_values, first_guess, scales_of
from ...model import as_weighed_by
from ..side_by_side import at_once
from .regression import Regression, prepare
from .shorten import working
from .trajectory import Diverged

_CLEARLY = 0.5  # of what was left: so much less another place must leave to be taken instead
_INERTIAL = 0.1  # of the acceleration: that much devices with inertia left unexplained (see `regression`); a stage
# without any, whose spring and drive were taken away to explain it, left 0.4
_STEPS = 12  # along the measured motion: from six times the resonance it took five


def prepare_at_best(joint: Fit) -> Regression:
    """The regression of a fit, or of the same model at values from which the equation of motion, or a single record, is
    described clearly better."""
    regression = prepare(working(joint))
    if regression.settled or not regression.whitenings:
        return regression
    there = _along_the_motion(regression) or (None if regression.credible else _of_one_record(regression))
    return regression if there is None else replace(there, instead_of=regression)


def _along_the_motion(regression: Regression) -> Regression | None:
    """Where steps along the measured motion lead, as long as each leaves less of the acceleration; None if that is not
    clearly less than the fit leaves, or, of a fit without inertia, more than devices that have it leave.

    A fit far above its resonance has hardly any inertia, and one step does not lead all the way.
    """
    place = regression if regression.credible else prepare(regression.fit, believed=True)
    most, nothing = _CLEARLY * place.unexplained, np.zeros(len(regression.left))
    for _ in range(_STEPS):
        there = _at(place, place.moved(nothing), True)
        if there is None or not there.unexplained < place.unexplained:
            break
        place = there
    return place if place.unexplained < (most if regression.credible else min(most, _INERTIAL)) else None


def _of_one_record(regression: Regression) -> Regression | None:
    """The values that describe one record to the noise: they are the device's own, those that bend less in one record
    than in all are only bent otherwise."""
    joint = regression.fit
    records = joint.campaign.fitted
    alone = at_once(lambda record: _alone(joint, record), records)
    known = [one for one in alone if one.trusted and not any(e.flags for e in one.estimates if e.fitted)]
    best = min(known, key=lambda one: one.fitted.error_over_noise, default=None)
    if best is None or not best.fitted.error_over_noise < _CLEARLY * joint.fitted.error_over_noise:
        return None
    there = _at(regression, best.values, True)
    return there and replace(there, alone=best.campaign.records[0].name)


def _alone(joint: Fit, record: Trace) -> Fit:
    """The model fitted to one record, from the values of all and from what the record itself says of the linear part,
    which the others may have bent beyond return."""
    campaign = replace(joint.campaign, records=(record,))
    model = as_weighed_by(campaign, joint.model, joint.values)
    if model.form != "oscillator":
        return fit(model, campaign)
    linear = [parameter.name for parameter in model.parameters[:3]]
    fresh = replace(model, start=tuple(told for told in model.start if told[0] not in linear))
    guess = first_guess(fresh, campaign)
    own = base_values(fresh, guess, scales_of(campaign, guess.frequency))
    return fit(model, campaign, initial=[joint.values, own])


def _at(regression: Regression, values: np.ndarray | None, believed: bool) -> Regression | None:
    """The regression at other values; None if the motion has no bound there."""
    if values is None:
        return None
    try:
        return prepare(fit_at(regression.fit.model, regression.fit.campaign, values), believed)
    except Diverged:
        return None
