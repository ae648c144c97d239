"""Normal equations of a fit: the cost, its gradient and its Gauss–Newton matrix, from one evaluation.

The unknowns in one vector: x first, then the initial state of every record that does not start at rest.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from .coordinates import slopes
from .problem import Data, Evaluation, Static, Unknowns

# A hundred-thousandth of a standard error: keeps the equations solvable along directions that the data leave free, and
# is far too weak to move any that they determine.
_RIDGE = 1e-5
_SOFT = 3.0  # robust loss: residuals beyond this many noise floors count linearly


class Normal(NamedTuple):
    """`cost` ½ Σ r², `gradient` (u,) Jᵀr and `matrix` (u, u) JᵀJ, in the one vector of unknowns."""

    cost: Any
    gradient: Any
    matrix: Any


def moving(data: Data) -> np.ndarray:
    """Which records' initial states are unknown, (k,)."""
    return np.flatnonzero(data.start_scale[:, 0] > 0)


def pack(unknowns: Unknowns, data: Data) -> np.ndarray:
    """Unknowns as one vector."""
    return np.concatenate([unknowns.x, unknowns.starts[moving(data)].ravel()])


def unpack(vector: np.ndarray, like: Unknowns, data: Data) -> Unknowns:
    """One vector as unknowns; what is not unknown as in `like`."""
    p, starts = len(like.x), like.starts.copy()
    starts[moving(data)] = vector[p:].reshape(-1, starts.shape[1])
    return Unknowns(vector[:p], starts)


def pulls(residuals: np.ndarray, robust: bool) -> np.ndarray:
    """How the cost ½χ² changes with each residual, (n,)."""
    if not robust:
        return residuals
    soft, slope = _soften(residuals)
    return soft * slope


@np.errstate(over="ignore", invalid="ignore")
def slope_by(static: Static, data: Data, found: Evaluation, pull: np.ndarray) -> np.ndarray:
    """Jᵀ pull, (u,): how the cost of the data changes with each unknown, with the Jacobian that was found."""
    p, s, starts = len(static.free), data.start_scale.shape[1], moving(data)
    slope = np.zeros(p + s * len(starts))
    slope[:p] = found.by_x @ pull
    for k, record in enumerate(starts):
        part = data.tape.slices[record]
        slope[p + s * k : p + s * (k + 1)] = found.by_start[:, part] @ pull[part]
    return slope


@np.errstate(over="ignore", invalid="ignore")  # a trial whose motion has no bound is refused for its cost
def normal_equations(static: Static, data: Data, vector: np.ndarray, found: Evaluation, robust: bool) -> Normal:
    """Normal equations of data, priors and ridge at one point, the unknowns in one `vector`."""
    p, s = len(static.free), data.start_scale.shape[1]
    matrix = np.zeros((len(vector),) * 2)
    r, jx, js = found.residuals, found.by_x, found.by_start
    gradient = slope_by(static, data, found, pulls(r, robust))
    if robust:
        r, slope = _soften(r)
        jx, js = jx * slope, js * slope[: js.shape[1]]  # starts move traces alone
    matrix[:p, :p] = jx @ jx.T
    for k, record in enumerate(moving(data)):
        own, part = slice(p + s * k, p + s * (k + 1)), data.tape.slices[record]
        matrix[own, own] = js[:, part] @ js[:, part].T
        matrix[:p, own] = jx[:, part] @ js[:, part].T
        matrix[own, :p] = matrix[:p, own].T
    return _with_prior(Normal(np.asarray(float(r @ r)), gradient, matrix), found, static, data, vector)


def weights(static: Static, data: Data) -> np.ndarray:
    """1/deviation of every unknown from zero, (u,), in what counts as noise: next to nothing, but the misfit of hidden
    states at the start, which are about as large as their unit. Displacement and velocity are held by the first
    samples."""
    histories = np.full(data.start_scale.shape[1], data.misfit)
    histories[:2] = _RIDGE
    return np.concatenate([np.full(len(static.free), _RIDGE), np.tile(histories, len(moving(data)))])


def _with_prior(data_part: Normal, found: Evaluation, static: Static, data: Data, vector: np.ndarray) -> Normal:
    cost, gradient, matrix = data_part
    p = len(static.free)
    values = np.asarray(found.values)[list(static.free)]
    weight = np.asarray(data.prior_weight)
    off = (values - data.prior_mean) * weight
    slope = weight * np.asarray(data.scale) * slopes(values, data.lower, data.upper)
    gradient[:p] += slope * off
    matrix[np.arange(p), np.arange(p)] += slope**2
    light = weights(static, data)
    matrix[np.diag_indices_from(matrix)] += light**2
    gradient += light**2 * vector
    # As an array: a Python number would be compiled into the program that receives it.
    total = 0.5 * (cost + off @ off + float(np.sum((light * vector) ** 2)))
    return Normal(np.asarray(total), gradient, matrix)


def _soften(residual: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Residual whose square is the pseudo-Huber loss 2c²(√(1+(r/c)²) − 1), and its derivative by r.

    Source: R. Hartley, A. Zisserman, Multiple View Geometry in Computer Vision, 2003, §A6.8.
    """
    root = np.sqrt(1.0 + (residual / _SOFT) ** 2)
    factor = np.sqrt(2.0 / (1.0 + root))
    return residual * factor, 1.0 / (root * factor)
