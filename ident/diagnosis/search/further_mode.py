"""The linear side of a decay at every node of a walk: does another mode ring, now that an effect has its place?

The start model was given none where the bent line of the strongest mode hid it (`fit.linear.modes`). What the model
leaves is then read as a decay is: by its strongest line. It is no effect, and need not be worth a name; but it must
take the greater part of what is left, for harmonics are lines, too.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from ...campaign.device import Oscillator
from ...effects.linear_side import MODE
from ...fit import Fit, fit
from ...fit.linear.free_modes import amplitudes, next_line
from ...fit.linear.start_model import modes_of
from ...fit.linear.stretches import stretch_of
from ...model import FREQUENCY, QUALITY, make_effect
from ...pulse import Report
from ..evidence.criterion import Left, clearly_better
from ..linearised.regression import Regression, prepare
from ..linearised.shorten import CRAWLS, working
from ..linearised.trajectory import Diverged

_GREATER_PART = 0.5  # of χ² beyond noise
_HALVES = 8  # of a period, over which a frequency is taken


def with_its_mode(fitted: Fit, regression: Regression, report: Report) -> tuple[Fit, Regression]:
    """A fit of decays with one mode more, if the records ask for it by now, and the regression; else what was given."""
    model, campaign = fitted.model, fitted.campaign
    decays = isinstance(model.device, Oscillator) and campaign.fitted and not any(r.driven for r in campaign.fitted)
    if not (decays and model.form == "oscillator"):
        return fitted, regression
    modes = modes_of(campaign)
    name = next((one for one in modes if one not in model.names), None)
    if name is None:
        return fitted, regression
    pairs = zip(campaign.traces, fitted.readings, strict=True)
    left = [replace(r, response=r.across(r.response - told)) for r, told in pairs if not r.holdout]
    stretches = [stretch_of(record) for record in left]
    line = next_line(stretches, np.empty((0, 2)))
    if line is None:
        return fitted, regression
    frequency, quality = map(float, np.exp(line))
    moves = _moves_through(fitted) if name == modes[0] else []  # with two in what is read, zeros tell of neither
    if _same_line(fitted, frequency, quality, moves):
        return fitted, regression
    travel = float(amplitudes(stretches, line[None])[0]) / (2 * np.pi * frequency) ** left[0].order
    more = model + make_effect(campaign, name)
    begin = [(f"{name}.{key}", value) for key, value in zip(MODE, (travel, 1 / frequency, quality), strict=True)]
    more = replace(more, start=(*more.start, *begin))
    values = np.append(fitted.values, [p.value for p in more.parameters[len(fitted.values) :]])
    try:
        found = fit(more, campaign, initial=values, most=CRAWLS)
        after = prepare(working(found))
    except Diverged:
        return fitted, regression
    if _same_line(found, 1 / found.value(f"{name}.period"), found.value(f"{name}.quality"), moves):
        return fitted, regression
    clear = clearly_better(Left(after.residual, after.numbers), Left(regression.residual, regression.numbers))
    if not clear or after.chi2 - after.n > _GREATER_PART * (regression.chi2 - regression.n):
        return fitted, regression
    report(f"beside it another mode rings, {name}: error over noise {found.fitted.error_over_noise:.3g}")
    return found, after


def _same_line(fitted: Fit, frequency: float, quality: float, moves: Sequence[float]) -> bool:
    """Whether a mode lies within the bandwidths of the strongest, wherever that `moves`, or so near to it that the
    longest record does not tell two lines: it is that one. A search may take a line there that began beside it, where
    another effect is missing."""
    own, sharp = (float(fitted.values[i]) for i in (FREQUENCY, QUALITY))
    longest = max(record.time[-1] - record.time[0] for record in fitted.campaign.traces)
    near = max((frequency / quality + own / sharp) / 2, 1 / float(longest))
    return min(own, *moves) - near < frequency < max(own, *moves) + near if moves else abs(frequency - own) < near


def _moves_through(fitted: Fit) -> list[float]:
    """Least and largest frequency (Hz) of the decays of a model with one mode, each over some periods between zeros: a
    spring that bends moves it away from that of the linear part."""
    found = []
    for record, told in zip(fitted.campaign.traces, fitted.readings, strict=True):
        z = told - np.median(told)
        before = np.flatnonzero((z[:-1] > 0) != (z[1:] > 0))
        at = record.time[before] + record.step * z[before] / (z[before] - z[before + 1])
        if len(at) > 2 * _HALVES:
            found.append(0.5 * _HALVES / (at[_HALVES:] - at[:-_HALVES]))
    return [float(edge(one)) for one in found for edge in (np.min, np.max)]
