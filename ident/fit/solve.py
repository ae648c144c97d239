"""Least squares by optimistix: its Levenberg–Marquardt descent and trust region, on normal equations.

`optimistix.least_squares` would compile the whole simulation a second time inside its own loop, which costs a cold fit
several seconds; here its descent and its search run on the (u, u) normal equations, and the simulation is compiled
once. Every parameter is scaled by the length of its column of the Jacobian, so that one damping suits all units.

Source: D. W. Marquardt, An algorithm for least-squares estimation of nonlinear parameters, J. SIAM 11 (1963) 431, §III.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import equinox as eqx
import jax
import jax.numpy as jnp
import lineax as lx
import numpy as np
import optimistix as optx
from jax import Array

from .coordinates import slopes
from .normal import Normal, normal_equations, pack, unpack
from .problem import Data, Static, Unknowns, evaluate

MAX_STEPS = 400
_SMALL_STEP = 1e-4  # in standard errors of the single parameter
_SMALL_GAIN = 1e-9  # of the cost

_DESCENT = optx.DampedNewtonDescent(linear_solver=lx.Cholesky())
# The damping may fall as soon as nine tenths of the promised gain come true: with the default, 99 %, a start far from
# the
# minimum crawls (mean of 20 starts at ±30 %: 83 steps, one not there after 400; so 51 steps, all there).
_SEARCH = optx.ClassicalTrustRegion(high_cutoff=0.9, low_cutoff=0.1)


class Solution(NamedTuple):
    """Where one start ended: `unknowns`, the `cost` Σ r² there, the number of `steps`, and whether it `converged`."""

    unknowns: Unknowns
    cost: float
    steps: int
    converged: bool


class _Point(NamedTuple):
    y: Array
    info: Any
    search: Any


def _info(normal: Normal) -> Any:
    matrix = lx.MatrixLinearOperator(jnp.asarray(normal.matrix), lx.positive_semidefinite_tag)
    return optx.FunctionInfo.EvalGradHessian(jnp.asarray(normal.cost), jnp.asarray(normal.gradient), matrix)


@eqx.filter_jit
def _advance(first: Array, point: _Point, trial: Array, found: Normal) -> tuple[_Point, Array, Array, Array]:
    """Accept or reject a trial, then propose the next; returns (point, next trial, accepted, predicted gain)."""
    trial_info = _info(found)
    step, accept, _, search = _SEARCH.step(first, point.y, trial, point.info, trial_info, point.search)
    accept = accept & jnp.isfinite(found.cost)
    y = jnp.where(accept, trial, point.y)
    info = jax.tree.map(lambda new, old: jnp.where(accept, new, old), trial_info, point.info)
    move, _ = _DESCENT.step(step, _DESCENT.query(y, info, _DESCENT.init(y, info)))
    gain = -(info.grad @ move + 0.5 * move @ info.hessian.mv(move))
    return _Point(y, info, search), y + move, accept, gain


def rescale(static: Static, data: Data, unknowns: Unknowns) -> tuple[Data, Unknowns]:
    """Choose the unit of every x such that a unit step changes the residuals by one at this point."""
    found = evaluate(static, data, unknowns)
    squares = sum(np.sum(np.asarray(j) ** 2, axis=(1, 2)) for j in found.by_x)
    stretch = slopes(np.asarray(found.values)[list(static.free)], data.lower, data.upper) * np.asarray(data.scale)
    length = np.sqrt(squares + (np.asarray(data.prior_weight) * stretch) ** 2)
    coordinates = np.asarray(unknowns.x) * np.asarray(data.scale) + np.asarray(data.anchor)
    usable = np.isfinite(length) & (length > 0)
    scale = np.where(usable, np.asarray(data.scale) / np.where(usable, length, 1.0), data.scale)
    return data._replace(scale=scale, anchor=coordinates), Unknowns(np.zeros_like(scale), unknowns.starts)


def least_squares(static: Static, data: Data, start: Unknowns, robust: bool = False) -> tuple[Data, Solution]:
    """Minimise from one starting point; returns the data as rescaled there, and the solution."""
    data, start = rescale(static, data, start)
    at = lambda vector: normal_equations(static, data, unpack(np.asarray(vector), start), robust)
    trial = jnp.asarray(pack(start))
    normal = at(trial)
    info = _info(normal)
    point = _Point(trial, info, _SEARCH.init(trial, info))
    first, quiet = jnp.asarray(True), 0
    for steps in range(1, MAX_STEPS + 1):
        before = float(point.info.f)
        point, trial, accept, gain = _advance(first, point, trial, normal)
        cost = float(point.info.f)
        # Done when the model of the cost promises nothing more, twice running: a single small step may only be a
        # damped one.
        moved = float(jnp.max(jnp.abs(trial - point.y), initial=0.0))
        settled = float(gain) < _SMALL_GAIN * cost + 1e-6 or moved < _SMALL_STEP
        quiet = quiet + 1 if bool(accept) and settled and (bool(first) or before - cost < 1e-3 + 1e-7 * cost) else 0
        if quiet >= 2:
            return data, Solution(unpack(np.asarray(point.y), start), 2 * cost, steps, True)
        first = jnp.asarray(False)
        normal = at(trial)
    return data, Solution(unpack(np.asarray(point.y), start), 2 * float(point.info.f), MAX_STEPS, False)
