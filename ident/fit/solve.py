"""Least squares by optimistix: Levenberg–Marquardt with Marquardt's scaling and normal equations.

Every column of the Jacobian is scaled to unit length at the starting point, so that one damping parameter suits all
parameters whatever their units. Source: D. W. Marquardt, An algorithm for least-squares estimation of nonlinear
parameters, J. SIAM 11 (1963) 431, §III.
"""

from __future__ import annotations

from typing import NamedTuple

import equinox as eqx
import lineax as lx
import numpy as np
import optimistix as optx
from jax import Array

from . import problem
from .problem import Blocks, Data, Static, Unknowns

MAX_STEPS = 400


class Solution(NamedTuple):
    """Where one start ended: `unknowns`, the `cost` Σ r² there, the number of `steps`, and whether it `converged`."""

    unknowns: Unknowns
    cost: float
    steps: int
    converged: bool


@eqx.filter_jit
def _least_squares(static: Static, data: Data, start: Unknowns) -> tuple[Unknowns, Array, Array, Array]:
    solver = optx.LevenbergMarquardt(rtol=1e-10, atol=1e-4, linear_solver=lx.Normal(lx.Cholesky()))
    residuals = lambda unknowns, arrays: problem.residuals(static, arrays, unknowns)
    found = optx.least_squares(residuals, solver, start, args=data, max_steps=MAX_STEPS, throw=False)
    cost = 2 * found.state.f_info.as_min()
    return found.value, cost, found.stats["num_steps"], found.result == optx.RESULTS.successful


@eqx.filter_jit
def evaluate(static: Static, data: Data, unknowns: Unknowns) -> Blocks:
    """Residuals and Jacobian blocks, compiled."""
    return problem.blocks(static, data, unknowns)


@eqx.filter_jit
def readings(static: Static, data: Data, unknowns: Unknowns) -> tuple[Array, tuple[Array, ...]]:
    """All parameters in SI, and the model's readings per group, compiled."""
    return problem.physical(static, data, unknowns.x), problem.predict(static, data, unknowns)


def rescale(static: Static, data: Data, unknowns: Unknowns) -> tuple[Data, Unknowns]:
    """Choose the unit of every x such that a unit step changes the residuals by one at this point."""
    found = evaluate(static, data, unknowns)
    squares = sum(np.sum(np.asarray(j) ** 2, axis=(1, 2)) for j in found.by_x)
    length = np.sqrt(squares + np.asarray(data.prior_weight) ** 2)
    coordinates = np.asarray(unknowns.x) * np.asarray(data.scale) + np.asarray(data.anchor)
    usable = np.isfinite(length) & (length > 0)
    scale = np.where(usable, np.asarray(data.scale) / np.where(usable, length, 1.0), data.scale)
    rescaled = data._replace(scale=scale, anchor=coordinates)
    return rescaled, Unknowns(np.zeros_like(scale), unknowns.starts)


def least_squares(static: Static, data: Data, start: Unknowns) -> tuple[Data, Solution]:
    """Minimise from one starting point; returns the data as rescaled there, and the solution."""
    data, start = rescale(static, data, start)
    unknowns, cost, steps, converged = _least_squares(static, data, start)
    solution = Solution(unknowns, float(cost), int(steps), bool(converged))
    return data, solution
