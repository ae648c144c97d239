"""What is minimised: a model on the records of a campaign, as arrays."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from ..campaign.campaign import Campaign
from ..campaign.record import Trace
from ..errors import UserError
from ..model import FREQUENCY, QUALITY, Model
from ..pulse import Report
from ..response import Tape
from .assemble import assemble_fit, tape_of
from .linear.guess import DataScales, LinearGuess
from .problem import Data, Static
from .starts import base_values, first_guess, scales_of

Points = np.ndarray | Sequence[np.ndarray]
"""One start or several: all parameters of a model, SI."""


class Task(NamedTuple):
    """A model that is fitted to the records of a campaign.

    **Arguments:** `told`: starts that were given, near which the minimum is known to be; `guess`, the linear model, and
    `base` (m,) SI, where the search begins, by which the solver's steps are chosen; `scales`, by which limits are
    placed; `static` and `data`: the arrays, in the long steps that lead near a minimum.
    """

    model: Model
    campaign: Campaign
    told: list[np.ndarray]
    guess: LinearGuess
    base: np.ndarray
    scales: DataScales
    static: Static
    data: Data

    @property
    def records(self) -> Sequence[Trace]:
        """The traces that are fitted."""
        return self.campaign.fitted

    def short_steps(self) -> Tape:
        """The records in the steps that the error bars of a model's numbers need."""
        return tape_of(self.model, self.campaign, self.guess, self.base)


def task_of(
    model: Model, campaign: Campaign, initial: Points | None, report: Report, scales: DataScales | None = None
) -> Task:
    """A model and the records that are not held out, from `initial` points or, without any, from the linear guess.

    **Raises:** UserError if there is nothing to fit, or a start has not one value for each parameter.
    """
    many = len(campaign.fitted) + len(campaign.fitted_sweeps)
    if not many:
        what = "the campaign has no record that is not held out"
        raise UserError(what, do="add a record with holdout = false")
    told = [] if initial is None else list(np.atleast_2d(np.asarray(initial, float)))
    needed = len(model.parameters)
    if wrong := next((len(one) for one in told if len(one) != needed), None):
        what = f"a start has {wrong} value{'s' if wrong > 1 else ''}, and the model {needed} parameters"
        raise UserError(what, do="give all of them, in the order of model.parameters, those that are held too")
    if told:
        guess = LinearGuess(float(told[0][FREQUENCY]), float(told[0][QUALITY]), float("nan"), float("nan"))
    else:
        report("reading the resonance off the records")
        guess = first_guess(model, campaign)
    scales = scales or scales_of(campaign, guess.frequency)
    base = told[0] if told else base_values(model, guess, scales)
    static, data = assemble_fit(model, campaign, guess, scales, base, compared=True)
    report(f"compiling the model ({len(static.free)} parameters, {many} records)")
    return Task(model, campaign, told, guess, base, scales, static, data)
