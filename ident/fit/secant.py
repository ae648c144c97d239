"""What Gauss–Newton leaves out of the curvature of a fit, learned from its steps.

The Hessian of ½ Σ r² is JᵀJ + Σ r ∇²r. Where a model reaches the noise the second term is small. A model that lacks
something, or has kinks, has a valley that bends, along which JᵀJ alone promises what no step keeps: a search then
crawls for hundreds of steps. Every trial tells how the slope of the residuals that it found has changed, and with that
the second term along the step. It is used where JᵀJ crawls, as long as it foretells the falls better: far from a
minimum it speaks of residuals that the next steps take away, and a model that is right is found sooner without.

Source: J. E. Dennis, D. M. Gay, R. E. Welsch, An adaptive nonlinear least-squares algorithm, ACM Transactions on
Mathematical Software 7 (1981) 348, §§2-3.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from .normal import Normal

_KEPT = 2.0  # factor within which a fall that was foretold must have come for what is foretold next to be believed


class Secant(NamedTuple):
    """`matrix` (u, u), the second term as far as it is known; whether it is in `use`; and whether the last fall was as
    foretold, so that the quadratic model is `proven`."""

    matrix: np.ndarray
    use: bool = False
    proven: bool = False

    def bend(self, normal: Normal, units: np.ndarray) -> Normal:
        """Normal equations with the whole curvature, if it is in use, that along no direction is negative: uphill and
        downhill a step is as long; `units` of the unknowns, (u,)."""
        if not (self.use and np.all(np.isfinite(normal.matrix))):
            return normal
        scale = np.outer(units, units)
        curvature, directions = np.linalg.eigh((normal.matrix + self.matrix) / scale)
        return normal._replace(matrix=(directions * np.abs(curvature)) @ directions.T * scale)

    @np.errstate(over="ignore", invalid="ignore")  # a trial whose motion has next to no bound tells nothing
    def learn(self, step: np.ndarray, point: Normal, trial: Normal, turned: np.ndarray, crawls: bool) -> Secant:
        """What it is after a trial that lay a `step` (u,) from the point, both without the second term; `turned` (u,):
        by how much Jᵀr has changed for the residuals of the trial, (J_trial − J_point)ᵀ r_trial; `crawls`: whether the
        search does, so that it may be used."""
        if not (np.isfinite(trial.cost) and np.all(np.isfinite(trial.gradient)) and np.all(np.isfinite(turned))):
            return self._replace(proven=False)
        fell = float(point.cost - trial.cost)
        plain = -float(point.gradient @ step + 0.5 * step @ point.matrix @ step)
        whole = plain - 0.5 * float(step @ self.matrix @ step)
        told = whole if self.use else plain
        proven = told > 0 and 1 / _KEPT < fell / told < _KEPT
        use = crawls and abs(fell - whole) < abs(fell - plain)
        along = trial.gradient - point.gradient
        if not (curved := float(step @ along)) > 0:
            return Secant(self.matrix, use, proven)
        # An old term is shrunk to the size that the new slope shows: as residuals fall it would be too large.
        old = float(step @ self.matrix @ step)
        matrix = min(1.0, abs(float(step @ turned)) / abs(old)) * self.matrix if old else self.matrix
        left, along = turned - matrix @ step, along / curved
        matrix = matrix + np.outer(left, along) + np.outer(along, left) - float(step @ left) * np.outer(along, along)
        return Secant(matrix if np.all(np.isfinite(matrix)) else self.matrix, use, proven)
