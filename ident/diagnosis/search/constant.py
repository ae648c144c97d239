"""The linear side at every node of a walk: does it need a constant, now that an effect has its place?"""

from __future__ import annotations

from ...campaign.device import Oscillator
from ...effects.registry import Registry
from ...fit import Fit
from ...fit.linear.choice import LEVELS
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
    model, name = fitted.model, LEVELS[fitted.model.form]
    asked = isinstance(model.device, Oscillator) and any(record.driven for record in fitted.campaign.fitted)
    if not asked or name not in library or {*LEVELS.values()} & {*model.names}:
        return fitted, regression
    candidates = score(regression, {name: library[name]})
    try:
        if not candidates or behind(found := confirm(regression, library[name], candidates[0]), regression) >= 0:
            return fitted, regression
        with_it = accept(found, fitted)
        report(f"beside it the records need a constant, {name}: error over noise {with_it.fitted.error_over_noise:.3g}")
        return with_it, prepare(working(with_it))
    except Diverged:
        return fitted, regression
