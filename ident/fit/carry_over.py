"""How far a prediction may be off because the parameters are only known within their errors."""

from __future__ import annotations

import numpy as np

from ..response import Equation
from .curves import lay_curves
from .passes import lay_passes
from .reading import read
from .result import Fit

_FARTHEST = 3.0  # of the logarithm of a parameter: of one that may be twenty times as large the records say nothing


def expected_error(fit: Fit) -> float:
    """Error over noise to expect on the held-out records if the model is right; infinite if the errors say nothing.

    √(1 + tr(J C Jᵀ)/n), with C the covariance of the parameters and J the derivatives of the held-out readings by them,
    in noise floors; differences along the axes of C's correlation, one standard error to each side, of positive
    parameters in their logarithm: a quality factor of 10 ± 20 is not negative.

    Source: G. A. F. Seber, C. J. Wild, Nonlinear Regression, 1989, §5.1.
    """
    records, sweeps = fit.campaign.heldout, fit.campaign.heldout_sweeps
    if not (records or sweeps) or not np.all(np.isfinite(fit.covariance)):
        return float("inf")
    total, n = 0.0, sum(np.count_nonzero(r.counted) for r in records)
    for step in uncertain_steps(fit):
        sides = [read(fit.model, _moved(fit, sign * step), records) for sign in (1.0, -1.0)] if records else [[], []]
        with np.errstate(over="ignore", invalid="ignore"):  # a motion without bound, which says nothing
            total += sum(
                float(np.sum((0.5 * (up - down)[r.counted]) ** 2)) / r.noise.sigma**2
                for up, down, r in zip(*sides, records, strict=True)
            )
    equation, steps = Equation(fit.model), uncertain_steps(fit)
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


def _moved(fit: Fit, step: np.ndarray) -> np.ndarray:
    values = fit.values
    positive = np.array([p.positive for p in fit.model.parameters]) & (values > 0)
    factor = np.exp(np.clip(step / np.where(positive, values, 1.0), -_FARTHEST, _FARTHEST))
    return np.where(positive, values * factor, values + step)


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
