"""What a small change of a model does to the points of sweeps that were run fast: by the simulation itself.

Between such points the motion is known where the phase was measured at best, so that no force can be evaluated along
it. A candidate is added to the model with an amplitude of zero, and the march gives the slope there. One that acts by
its square (an even force) has none: what it does at a size at which it is a part of the spring's force stands for it.
These are slopes at the fit and not along what was measured; the candidates are ranked by refits (`ranking.refits`).

Source: C. R. Rao, 1948, Proc. Camb. Phil. Soc. 44, 50.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ...fit.start_scale import small_size
from ...model import Model
from ...response import Equation

if TYPE_CHECKING:
    from .regression import Regression

_NONE = 1e-6  # of what it does at that size: a slope that is smaller is none


def pass_columns(regression: Regression, model: Model, values: np.ndarray, amplitudes: list[int]) -> np.ndarray:
    """Rows (p q, numbers), sweep by sweep: what a unit of each of q amplitudes does at each of p places.

    **Arguments:** `model`: that of the fit with the candidate at its end; `values`: (p, m) SI, the amplitudes at zero;
    `amplitudes`: their places among the values.
    """
    passes, equation = regression.passes, Equation(model)
    assert passes is not None  # there are such sweeps
    directions = np.eye(values.shape[1])[amplitudes]
    scales, mass = regression.fit.scales, model.linear.mass
    sizes = np.array([small_size(model.parameters[a].unit, scales, mass) for a in amplitudes])
    width, found = len(model.parameters), []
    for at in values:
        here = passes.solve(equation, at, directions, width)
        rows, nothing = passes.slopes(here), passes.residuals(here)
        for k, (size, axis) in enumerate(zip(sizes, directions, strict=True)):
            if np.linalg.norm(rows[k]) * size < 1.0:  # noise floors: no slope, or none that could be told
                there = passes.residuals(passes.solve(equation, at + size * axis, directions[:0], width))
                square = (there - nothing) / size
                if np.all(np.isfinite(square)) and np.linalg.norm(rows[k]) < _NONE * np.linalg.norm(square) + 1 / size:
                    rows[k] = square
        found.append(rows[:, passes.order])
    return np.nan_to_num(np.concatenate(found))
