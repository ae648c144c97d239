"""How far a prediction may be off because the parameters are only known within their errors."""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from ..response import Equation
from .curves import lay_curves
from .passes import lay_passes
from .reading import read_with_slopes
from .result import Fit


@lru_cache(maxsize=8)  # the walk, its verdict and the page ask
@np.errstate(over="ignore", invalid="ignore")  # a motion without bound says nothing
def expected_error(fit: Fit) -> float:
    """Error over noise to expect on the held-out records if the model is right; infinite if the errors say nothing.

    √(1 + tr(J C Jᵀ)/n), with C the covariance of the parameters and J the derivatives of the held-out readings by them,
    in noise floors, unknown initial states being fitted anew.

    Source: G. A. F. Seber, C. J. Wild, Nonlinear Regression, 1989, §5.1.
    """
    records, sweeps = fit.campaign.heldout, fit.campaign.heldout_sweeps
    if not (records or sweeps) or not np.all(np.isfinite(fit.covariance)):
        return float("inf")
    steps, total, n = uncertain_steps(fit), 0.0, 0
    for record in records:
        reading, by_value, _ = read_with_slopes(fit.model, fit.values, record)
        if not np.all(np.isfinite(reading)):
            return float("inf")
        moved = by_value[record.counted] @ steps[:, list(fit.free)].T
        total, n = total + float(np.sum(moved**2)) / record.noise.sigma**2, n + len(moved)
    equation = Equation(fit.model)
    if slow := [sweep for sweep in sweeps if not sweep.fast]:
        curves = lay_curves(slow, fit.model).weighed(equation, fit.values)
        moved = curves.slopes(curves.solve(equation, fit.values), steps)
        total, n = total + float(np.sum(moved**2)), n + moved.shape[1]
    if fast := [sweep for sweep in sweeps if sweep.fast]:
        passes = lay_passes(fast, fit.model).weighed(equation, fit.values)
        moved = passes.slopes(passes.solve(equation, fit.values, steps))
        total, n = total + float(np.sum(moved**2)), n + moved.shape[1]
    expected = float(np.sqrt(1.0 + total / n))
    return expected if np.isfinite(expected) else float("inf")


def uncertain_steps(fit: Fit) -> np.ndarray:
    """(p, m) steps of the values along the axes of their correlation, one standard error each: their squares add up to
    the covariance. In units of SI its axes would be those of the largest unit, and what is left of the others rounding.
    """
    errors = np.sqrt(np.maximum(np.diag(fit.covariance), 0.0))
    known = np.where(errors > 0, errors, 1.0)
    sizes, axes = np.linalg.eigh(fit.covariance / np.outer(known, known))
    steps = np.zeros((len(sizes), len(fit.values)))
    steps[:, list(fit.free)] = np.sqrt(np.maximum(sizes, 0.0))[:, None] * axes.T * errors
    return steps
