"""What the data determine, said in combinations of parameters that a person can read.

Directions along which the scaled Jacobian has no length are found by its singular vectors; the combinations of the
parameters involved that are orthogonal to them are determined, and are printed with value and uncertainty.

Source: G. A. F. Seber, C. J. Wild, Nonlinear Regression, 1989, §3.4.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from ..model import ModelParameter
from .uncertainty import Covariance

_INVOLVED = 0.1  # share of a null direction that makes a parameter part of it


class Combination(NamedTuple):
    """A determined combination Σ weights·names = `value` ± `deviation` in `unit` (ln of a product where
    `logarithmic`)."""

    names: tuple[str, ...]
    weights: tuple[float, ...]
    value: float
    deviation: float
    unit: str
    logarithmic: bool


class Identifiability(NamedTuple):
    """`determined` (p,) True where a parameter's own value is determined; `combinations` that are, of the others."""

    determined: np.ndarray
    combinations: tuple[Combination, ...]


def identifiability(
    parameters: Sequence[ModelParameter], values: np.ndarray, stretch: np.ndarray, found: Covariance
) -> Identifiability:
    """Judge each fitted parameter: (p,) `values` SI, `stretch` dp/dc of each coordinate."""
    if found.null.shape[1] == 0:
        return Identifiability(np.ones(len(parameters), bool), ())
    involved = np.linalg.norm(found.null, axis=1) > _INVOLVED
    index = [int(i) for i in np.flatnonzero(involved)]
    same_unit = len({parameters[i].unit for i in index}) == 1
    logarithmic = not same_unit
    # Coordinates of the optimiser → physical values (or their logarithms where the units differ).
    to_physical = stretch[index]
    if logarithmic:
        to_physical = to_physical / np.where(values[index] == 0, 1.0, values[index])
    lengths = np.where(found.lengths > 0, found.lengths, 1.0)[index]  # a parameter without any effect has no length
    null = found.null[index] / lengths[:, None] * to_physical[:, None]
    basis, _, _ = np.linalg.svd(null)
    complement = basis[:, found.null.shape[1] :]
    matrix = found.matrix[np.ix_(index, index)] * np.outer(to_physical, to_physical)
    at = np.log(np.abs(np.where(values[index] == 0, 1.0, values[index]))) if logarithmic else values[index]
    combinations = []
    for weights in complement.T:
        weights = weights * np.sign(weights[np.argmax(np.abs(weights))])
        shown = np.abs(weights) > 0.005
        combinations.append(
            Combination(
                tuple(parameters[i].name for i, keep in zip(index, shown, strict=True) if keep),
                tuple(float(w) for w in weights[shown]),
                float(weights @ at),
                float(np.sqrt(max(weights @ matrix @ weights, 0.0))),
                parameters[index[0]].unit if same_unit else "",
                logarithmic,
            )
        )
    return Identifiability(~involved, tuple(combinations))
