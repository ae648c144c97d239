"""Least squares by optimistix: its Levenberg–Marquardt descent and trust region, on normal equations.

`optimistix.least_squares` would compile the whole simulation a second time inside its own loop, which costs a cold fit
several seconds; here its descent and its search run on the (u, u) normal equations, and the simulation is compiled
once. Every unknown is measured in units of the longest column of the Jacobian that it has had, so that one damping
suits all of them. Damping starts light, because what keeps a far start in its basin is another rule: no positive
parameter changes by more than a factor √e in one step.

A search ends by its Newton decrement, the fall of the cost that an undamped step promises. The size of a step says
nothing: along a narrow valley every damped step is small.

Sources: D. W. Marquardt, An algorithm for least-squares estimation of nonlinear parameters, J. SIAM 11 (1963) 431,
§III; J. J. Moré, The Levenberg–Marquardt algorithm, Lecture Notes in Mathematics 630 (1978) 105, §4 (units);
S. Boyd, L. Vandenberghe, Convex Optimization, 2004, §9.5.1 (decrement).
"""

from __future__ import annotations

from functools import partial
from typing import Any, NamedTuple

import equinox as eqx
import jax
import jax.numpy as jnp
import lineax as lx
import numpy as np
import optimistix as optx

from ..runtime import compiler_options
from .coordinates import slopes
from .normal import Normal, normal_equations, pack, unpack
from .problem import Data, Evaluation, Static, Unknowns, evaluate

MAX_STEPS = 400
_SMALL_GAIN = 1e-4  # of the cost ½χ²: no parameter is then further than 0.014 standard errors from its optimum
_SMALL_SHARE = 1e-9  # of the cost: more than that of a misfit is not worth a step
_FLAT = 1e-11  # curvature, as a share of the steepest, below which the data leave a direction free
_LEAST_STEP = 1e-12  # where damping has grown that much, rounding decides

_DESCENT = optx.DampedNewtonDescent(linear_solver=lx.Cholesky())
_SEARCH = optx.ClassicalTrustRegion(high_cutoff=0.75, low_cutoff=0.1)
_FIRST_STEP = 100.0  # the inverse of the first damping
_FARTHEST = 0.5  # in ln p, for positive parameters in one step


class Solution(NamedTuple):
    """Where one start ended: `unknowns`, the `cost` Σ r² there, the number of `steps`, and whether it `converged`."""

    unknowns: Unknowns
    cost: float
    steps: int
    converged: bool


class _Turn(NamedTuple):
    """After a trial: whether it was `accepted`, the `units` (u,) of the unknowns, the next `move` (u,)."""

    accepted: Any
    units: Any
    move: Any
    search: Any


def _info(normal: Normal, units: Any) -> Any:
    matrix = lx.MatrixLinearOperator(normal.matrix / jnp.outer(units, units), lx.positive_semidefinite_tag)
    return optx.FunctionInfo.EvalGradHessian(normal.cost, normal.gradient / units, matrix)


@partial(jax.jit, compiler_options=compiler_options())
def _advance(point: Normal, trial: Normal, moved: Any, last: _Turn, first: Any) -> _Turn:
    """Accept or reject a trial that lies `moved` away from the point, then propose the next move."""
    still = jnp.zeros_like(moved)
    old, new = _info(point, last.units), _info(trial, last.units)
    step, accept, _, search = _SEARCH.step(first, still, moved * last.units, old, new, last.search)
    accept = accept & jnp.isfinite(trial.cost)
    here = Normal(*(jnp.where(accept, b, a) for a, b in zip(point, trial, strict=True)))
    units = jnp.maximum(last.units, jnp.sqrt(jnp.diagonal(here.matrix)))
    info = _info(here, units)
    move, _ = _DESCENT.step(step, _DESCENT.query(still, info, _DESCENT.init(still, info)))
    return _Turn(accept, units, move / units, search)


def _decrement(normal: Normal, units: np.ndarray) -> float:
    """Fall of the cost that the undamped step promises, along the directions that the data determine; infinite where
    the model's motion is so large that it cannot be said."""
    if not (np.all(np.isfinite(normal.matrix)) and np.all(np.isfinite(normal.gradient))):
        return np.inf
    curvature, directions = np.linalg.eigh(normal.matrix / np.outer(units, units))
    slope = directions.T @ (normal.gradient / units)
    seen = curvature > _FLAT * curvature.max(initial=0.0)
    return float(0.5 * np.sum(slope[seen] ** 2 / curvature[seen]))


def rescale(static: Static, data: Data, unknowns: Unknowns) -> tuple[Data, Unknowns, Evaluation]:
    """Choose the unit of every x such that a unit step changes the residuals by one at this point; the model there."""
    found = evaluate(static, data, unknowns)
    squares = sum(np.sum(np.asarray(j) ** 2, axis=(1, 2)) for j in found.by_x)
    stretch = slopes(np.asarray(found.values)[list(static.free)], data.lower, data.upper) * np.asarray(data.scale)
    length = np.sqrt(squares + (np.asarray(data.prior_weight) * stretch) ** 2)
    coordinates = np.asarray(unknowns.x) * np.asarray(data.scale) + np.asarray(data.anchor)
    usable = np.isfinite(length) & (length > 0)
    share = 1.0 / np.where(usable, length, 1.0)
    found = found._replace(by_x=tuple(np.asarray(j) * share[:, None, None] for j in found.by_x))
    scale = np.asarray(data.scale) * share
    return data._replace(scale=scale, anchor=coordinates), Unknowns(np.zeros_like(scale), unknowns.starts), found


def _farthest(data: Data, start: Unknowns) -> np.ndarray:
    """How far each unknown may go in one step, (u,)."""
    reach = np.where(np.isfinite(np.asarray(data.lower)), _FARTHEST / np.asarray(data.scale), np.inf)
    return np.concatenate([reach, *(np.full(np.size(s), np.inf) for s in start.starts)])


def least_squares(
    static: Static, data: Data, start: Unknowns, robust: bool = False, most: int = MAX_STEPS
) -> tuple[Data, Solution]:
    """Minimise from one starting point in at most so many steps; the data as rescaled there, and the solution."""
    data, start, found = rescale(static, data, start)
    farthest = _farthest(data, start)
    data = data._replace(groups=jax.device_put(data.groups))
    y = pack(start)
    point = trial = normal_equations(static, data, y, found, robust)
    moved = np.zeros_like(y)
    search = _SEARCH.init(y, jax.eval_shape(_info, point, y))
    search = eqx.tree_at(lambda s: s.step_size, search, np.array(_FIRST_STEP))
    turn = _Turn(np.array(True), np.sqrt(np.diagonal(point.matrix)), moved, search)
    for steps in range(1, most + 1):
        turn = _advance(point, trial, moved, turn, np.array(steps == 1))
        if turn.accepted:
            y, point = y + moved, trial
        promised = _decrement(point, np.asarray(turn.units))
        if promised < _SMALL_GAIN + _SMALL_SHARE * float(point.cost):
            return data, Solution(unpack(y, start), 2 * float(point.cost), steps, True)
        if float(turn.search.step_size) < _LEAST_STEP:
            break
        moved = np.clip(turn.move, -farthest, farthest)
        found = evaluate(static, data, unpack(y + moved, start))
        trial = normal_equations(static, data, y + moved, found, robust)
    return data, Solution(unpack(y, start), 2 * float(point.cost), steps, False)
