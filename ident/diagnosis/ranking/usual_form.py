"""Which numbers of a law had the records to tell? Not a shape that its textbook had told already.

A yield that is quadratic, a contact that is linear or Hertz's, a saturation that levels off as a tanh: such a number
has no unit and no size of the device in it, and a law has it before any record is seen. To free it in a refit makes
room for devices that differ, and costs nothing where this one does not: the law in its usual form, which is one model,
is then the one that the records prefer. Counted as if the records had to tell it, a law would lose to any other that
happens to be written with fewer letters.

The usual form has its shapes at the nearest values of their grids. It is weighed without another refit: χ² would rise
by what moving them there does to the readings and no other parameter makes good. Of several shapes those are held which
it is best to hold; the rise, and 2 ln m for the choice between m usual values, count as the part of a number that costs
as much.
"""

from __future__ import annotations

import itertools

import numpy as np

from ...fit.coordinates import slopes
from ...fit.finish import Minimum
from ...fit.linear.independent import independent_samples
from ...model import Model, ModelParameter
from ..linearised.basis import orthonormal
from ..linearised.regression import Regression
from ..linearised.whiten import whiten


def numbers_told(regression: Regression, model: Model, found: Minimum, left: np.ndarray) -> float:
    """How many numbers of a refit the records had to tell: its fitted parameters, or fewer in the usual form of the
    model's last effect.

    **Arguments:** `found`: the refit, which leaves `left` (n,), whitened as the regression is.
    """
    free, name = list(found.static.free), model.effects[-1].name
    shapes = [k for k, i in enumerate(free) if _has_usual(model.parameters[i]) and model.parameters[i].effect == name]
    chi2 = float(left @ left)
    if not shapes or not 0 < chi2 < np.inf:
        return len(free)
    n, rows = independent_samples(left), _rows(regression, found)
    away = {k: _away(model.parameters[free[k]], float(found.values[free[k]])) * rows[k] for k in shapes}
    told = [float(len(free))]
    for count in range(1, len(shapes) + 1):
        for held in itertools.combinations(shapes, count):
            others = orthonormal(rows[[k for k in range(len(free)) if k not in held]])
            moved = sum(away[k] for k in held)
            moved = moved - others @ (others.T @ moved)
            rise = n * np.log1p(float(moved @ moved) / chi2)
            choice = 2 * sum(np.log(len(model.parameters[free[k]].grid)) for k in held)
            told.append(len(free) - count + (rise + choice) / np.log(n))
    return min(told)


def _has_usual(parameter: ModelParameter) -> bool:
    """Whether a law has a value for a number before any record is seen: it is no amplitude, and measured in nothing."""
    return parameter.kind == "shape" and parameter.unit == "1" and parameter.scale == "one" and bool(parameter.grid)


def _away(parameter: ModelParameter, value: float) -> float:
    """How far the nearest usual value is."""
    return float(min(np.asarray(parameter.grid) - value, key=abs))


def _rows(regression: Regression, found: Minimum) -> np.ndarray:
    """(p, n) what the fitted parameters (SI) do to the readings, whitened as the regression is."""
    evaluation, data, free = found.best.found, found.data, list(found.static.free)
    samples, slope = zip(regression.whitenings, data.tape.slices, strict=True), evaluation.response.slopes[: len(free)]
    slope = np.where(np.isfinite(slope), slope, 0.0)
    traces = [whiten(one, slope[:, own]) for one, own in samples]
    rows = np.concatenate([*traces, evaluation.by_x[:, data.tape.samples :]], axis=1)
    return rows / (slopes(evaluation.values[free], data.lower, data.upper) * data.scale)[:, None]
