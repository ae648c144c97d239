"""The linear side of a decay at every node of a walk: does another mode ring, now that an effect has its place?

The start model was given none where the bent line of the strongest mode hid it (`fit.linear.modes`). What the model
leaves is then read as a decay is: by its strongest line. It is no effect, and need not be worth a name; but it must
take the greater part of what is left, for harmonics are lines, too.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ...campaign.device import Oscillator
from ...fit import Fit, fit
from ...fit.linear.free_modes import amplitudes, next_line
from ...fit.linear.start_model import FURTHER
from ...fit.linear.stretches import stretch_of
from ...model import FREQUENCY, QUALITY, make_effect
from ...pulse import Report
from ..evidence.criterion import Left, clearly_better
from ..linearised.regression import Regression, prepare
from ..linearised.shorten import working
from ..linearised.trajectory import Diverged

_GREATER_PART = 0.5  # of χ² beyond noise


def with_its_mode(fitted: Fit, regression: Regression, report: Report) -> tuple[Fit, Regression]:
    """A fit of decays with one mode more, if the records ask for it by now, and the regression; else what was given."""
    model, campaign = fitted.model, fitted.campaign
    name = next((one for one in FURTHER if one not in model.names), "")
    decays = isinstance(model.device, Oscillator) and campaign.fitted and not any(r.driven for r in campaign.fitted)
    if not (decays and name and model.form == "oscillator"):
        return fitted, regression
    pairs = zip(campaign.traces, fitted.readings, strict=True)
    left = [replace(r, response=r.across(r.response - told)) for r, told in pairs if not r.holdout]
    stretches = [stretch_of(record) for record in left]
    line = next_line(stretches, np.empty((0, 2)))
    if line is None:
        return fitted, regression
    frequency, quality = map(float, np.exp(line))
    own, sharp = (float(fitted.values[i]) for i in (FREQUENCY, QUALITY))
    if abs(frequency - own) < (frequency / quality + own / sharp) / 2:  # the same line, which moves
        return fitted, regression
    travel = float(amplitudes(stretches, line[None])[0]) / (2 * np.pi * frequency) ** left[0].order
    more = model + make_effect(campaign, name)
    begin = [*((f"{name}.travel", travel), (f"{name}.period", 1 / frequency), (f"{name}.quality", quality))]
    more = replace(more, start=(*more.start, *begin))
    try:
        found = fit(more, campaign, initial=np.append(fitted.values, [value for _, value in begin]))
        after = prepare(working(found))
    except Diverged:
        return fitted, regression
    clear = clearly_better(Left(after.residual, after.numbers), Left(regression.residual, regression.numbers))
    if not clear or after.chi2 - after.n > _GREATER_PART * (regression.chi2 - regression.n):
        return fitted, regression
    report(f"beside it another mode rings, {name}: error over noise {found.fitted.error_over_noise:.3g}")
    return found, after
