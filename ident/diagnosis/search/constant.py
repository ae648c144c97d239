"""The linear side at every node of a walk: does it need a constant, now that an effect has its place, and still need
it at the end?"""

from __future__ import annotations

from collections.abc import Sequence

from ...campaign.device import Oscillator
from ...effects.linear_side import constant_on
from ...effects.registry import Registry
from ...fit import Fit
from ...fit.linear.choice import side_of_constant
from ...fit.linear.start_model import start_model
from ...fit.rebuild import fit_at
from ...pulse import Report
from ..evidence.criterion import behind
from ..evidence.held_out import hurts
from ..linearised.regression import Regression, prepare
from ..linearised.shorten import working
from ..linearised.trajectory import Diverged
from ..ranking.confirm import accept, confirm
from ..ranking.score import score
from .change import still_possible, try_without
from .own_zeros import has_own_zeros


def with_its_constant(fitted: Fit, regression: Regression, library: Registry, report: Report) -> tuple[Fit, Regression]:
    """A fit with the constant that its linear form may have, if the records ask for it by now, and the regression.

    The start model was given none where a missing effect hid it. It is chosen as there (`fit.linear.choice`), by
    n ln χ² + k ln n with the independent samples in what is left: it is no effect, and need not be worth a name. A
    platform's linear part is known, and decays are counted from where they come to rest.
    """
    model = fitted.model
    constant = constant_on(side_of_constant(model.form), library)
    asked = isinstance(model.device, Oscillator) and any(record.driven for record in fitted.campaign.fitted)
    there = any(effect.is_constant for effect in model.effects) or has_own_zeros(fitted.campaign)
    if not asked or constant is None or there:
        return fitted, regression
    candidates = score(regression, {constant.name: constant})
    try:
        if not candidates or behind(found := confirm(regression, constant, candidates[0]), regression) >= 0:
            return fitted, regression
        with_it = accept(found, fitted)
        left = with_it.fitted.error_over_noise
        report(f"beside it the records need a constant, {constant.name}: error over noise {left:.3g}")
        return with_it, prepare(working(with_it))
    except Diverged:
        return fitted, regression


def without_idle_constant(fitted: Fit, named: Sequence[str], start: Fit, report: Report) -> Fit:
    """A fit without the constant that its linear form had beside what was missing, and needs no more by the same
    criterion, nor for the held-out records; one of the `named` steps, or that somebody asked for, stays.

    `start`: with which the walk began.
    """
    last, campaign = working(fitted), fitted.campaign
    for effect in fitted.model.effects if isinstance(fitted.model.device, Oscillator) else ():
        if not effect.is_constant or effect.name in (*named, *campaign.effects):
            continue
        if effect.name in start.model.names and effect.name not in start_model(campaign).names:
            continue  # neither the records chose it nor the walk
        report(f"does the model still need {effect.name}?")
        without = try_without(last, effect.name, start)
        try:
            idle = behind(prepare(without), prepare(last)) < 0 and still_possible(without, last)
        except Diverged:
            continue
        whole = without if last is fitted else fit_at(without.model, campaign, without.values, converged=False)
        return whole if idle and not hurts(fitted, whole) else fitted
    return fitted
