"""A quadratic model of the cost, and the best move within limits.

Source: P. B. Stark, R. L. Parker, Bounded-variable least-squares, Computational Statistics 10 (1995) 129.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from scipy.optimize import lsq_linear

from .normal import Normal

_FLAT = 1e-11  # curvature, as a share of the steepest, below which the data leave a direction free


class Squares(NamedTuple):
    """The quadratic model of the cost, a constant and ½ |rows · y − pull|²: y a move (u,) in units of the unknowns,
    `rows` (k, u) of orthogonal directions, and `pull` (k,)."""

    rows: np.ndarray
    pull: np.ndarray

    def best(self, low: np.ndarray, high: np.ndarray) -> np.ndarray:
        """The y that promises most between limits (u,); the shortest where none is met.

        A longer one cut to the limits is no substitute: the unknowns that are free would answer a motion of the others
        that is not made.
        """
        free = self.rows.T @ (self.pull / np.sum(self.rows**2, axis=1))
        if np.all((low <= free) & (free <= high)):
            return free
        return np.clip(lsq_linear(self.rows, self.pull, (low, high), method="bvls").x, low, high)

    def fall(self, y: np.ndarray) -> float:
        """Fall of the cost that a move promises."""
        left = self.rows @ y - self.pull
        return 0.5 * float(self.pull @ self.pull - left @ left)


def squares_of(normal: Normal, units: np.ndarray, damping: float = 0.0) -> Squares:
    """The quadratic model of the cost, with ½ damping |y|² added; without directions that the data leave free."""
    curvature, directions = np.linalg.eigh(normal.matrix / np.outer(units, units))
    curvature = curvature + damping
    seen = curvature > _FLAT * curvature.max(initial=0.0)
    root, directions = np.sqrt(curvature[seen]), directions[:, seen]
    return Squares(root[:, None] * directions.T, -(directions.T @ (normal.gradient / units)) / root)
