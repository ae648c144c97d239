"""How far a prediction may be off because the parameters are only known within their errors."""

from __future__ import annotations

import numpy as np

from .reading import read
from .result import Fit


def expected_error(fit: Fit) -> float:
    """Error over noise to expect on the held-out records if the model is right; infinite if the errors say nothing.

    √(1 + tr(J C Jᵀ)/n), with C the covariance of the parameters and J the derivatives of the held-out readings by them,
    in noise floors; differences along the axes of C, one standard error to each side.

    Source: G. A. F. Seber, C. J. Wild, Nonlinear Regression, 1989, §5.1.
    """
    records = fit.campaign.heldout
    if not records or not np.all(np.isfinite(fit.covariance)):
        return float("inf")
    sizes, axes = np.linalg.eigh(fit.covariance)
    total = 0.0
    for size, axis in zip(np.maximum(sizes, 0.0), axes.T, strict=True):
        step = np.zeros_like(fit.values)
        step[list(fit.free)] = np.sqrt(size) * axis
        sides = [read(fit.model, fit.values + sign * step, records) for sign in (1.0, -1.0)]
        with np.errstate(over="ignore", invalid="ignore"):  # a motion without bound, which says nothing
            total += sum(
                float(np.sum((0.5 * (up - down)[r.counted]) ** 2)) / r.noise.sigma**2
                for up, down, r in zip(*sides, records, strict=True)
            )
    expected = float(np.sqrt(1.0 + total / sum(np.count_nonzero(r.counted) for r in records)))
    return expected if np.isfinite(expected) else float("inf")
