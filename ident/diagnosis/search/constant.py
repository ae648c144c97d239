"""The linear side at every node of a walk: does it need a constant, now that an effect has its place?"""

from __future__ import annotations

from ...campaign.device import Oscillator
from ...effects.linear_side import constant_on
from ...effects.registry import Registry
from ...fit import Fit
from ...fit.linear.choice import side_of_constant
from ...pulse import Report
from ..evidence.criterion import behind
from ..linearised.regression import Regression, prepare
from ..linearised.shorten import working
from ..linearised.trajectory import Diverged
from ..ranking.confirm import accept, confirm
from ..ranking.score import score


def with_its_constant(fitted: Fit, regression: Regression, library: Registry, report: Report) -> tuple[Fit, Regression]:
    """A fit with the constant that its linear form may have, if the records ask for it by now, and the regression.

    The start model was given none where a missing effect hid it. It is chosen as there (`fit.linear.choice`), by
    n ln χ² + k ln n with the independent samples in what is left: it is no effect, and need not be worth a name. A
    platform's linear part is known, and decays are counted from where they come to rest.
    """
    model = fitted.model
    constant = constant_on(side_of_constant(model.form), library)
    asked = isinstance(model.device, Oscillator) and any(record.driven for record in fitted.campaign.fitted)
    if not asked or constant is None or any(effect.is_constant for effect in model.effects):
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
