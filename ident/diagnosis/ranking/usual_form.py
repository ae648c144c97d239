"""Which numbers of a law had the records to tell? Not a shape that its textbook had told already.

A yield that is quadratic, a contact that is linear or Hertz's, a saturation that levels off as a tanh: such a number
has no unit and no size of the device in it, and a law has it before any record is seen. To free it in a refit makes
room for devices that differ, and costs nothing where this one does not: the law in its usual form, which is one model,
is then the one that the records prefer. Counted as if the records had to tell it, a law would lose to any other that
happens to be written with fewer letters.

A shape counts as a number where χ² would rise by more than four, two standard errors, if it were held at the nearest
value of its grid and all else were fitted again; by as many times more as what is left is larger than noise. Several of
one law are held together, or as many of them as can be.
"""

from __future__ import annotations

import itertools

import numpy as np

from ...fit.coordinates import slopes
from ...fit.fit import Minimum
from ...fit.linear.independent import independent_samples
from ...model import Model, ModelParameter
from ..linearised.basis import orthonormal
from ..linearised.regression import Regression
from ..linearised.whiten import whiten

_ERRORS = 2.0  # standard errors within which a shape is its usual one, as for an amplitude that is none (`Fit.freedom`)


def in_usual_form(regression: Regression, model: Model, found: Minimum, left: np.ndarray) -> int:
    """How many of the fitted shapes of a model's last effect the records do not tell from their usual values.

    **Arguments:** `found`: a refit of the model, which leaves `left` (n,), whitened as the regression is.
    """
    free, values, name = list(found.static.free), found.values, model.effects[-1].name
    shapes = [k for k, i in enumerate(free) if _has_usual(model.parameters[i]) and model.parameters[i].effect == name]
    chi2 = float(left @ left)
    if not shapes or not np.isfinite(chi2):
        return 0
    rows = _rows(regression, found)
    noise = max(chi2 / independent_samples(left), 1.0)
    away = {k: _away(model.parameters[free[k]], float(values[free[k]])) for k in shapes}
    for count in range(len(shapes), 0, -1):
        for held in itertools.combinations(shapes, count):
            moved = sum(away[k] * values[free[k]] * rows[k] for k in held)
            others = orthonormal(rows[[k for k in range(len(free)) if k not in held]])
            moved = moved - others @ (others.T @ moved)
            if float(moved @ moved) < _ERRORS**2 * count * noise:
                return count
    return 0


def _has_usual(parameter: ModelParameter) -> bool:
    """Whether a law has a value for a number before any record is seen: it is no amplitude, and measured in nothing."""
    return parameter.kind == "shape" and parameter.unit == "1" and parameter.scale == "one" and bool(parameter.grid)


def _away(parameter: ModelParameter, value: float) -> float:
    """Logarithm of the nearest usual value over this one."""
    ratios = np.log(np.asarray(parameter.grid) / value)
    return float(ratios[np.argmin(np.abs(ratios))])


def _rows(regression: Regression, found: Minimum) -> np.ndarray:
    """(p, n) what the fitted parameters do to the readings, SI, whitened as the regression is."""
    evaluation, data, free = found.best.found, found.data, list(found.static.free)
    samples = zip(regression.whitenings, data.tape.slices, strict=True)
    traces = [whiten(one, evaluation.response.slopes[: len(free), own]) for one, own in samples]
    rows = np.concatenate([*traces, evaluation.by_x[:, data.tape.samples :]], axis=1)
    return rows / (slopes(evaluation.values[free], data.lower, data.upper) * data.scale)[:, None]
