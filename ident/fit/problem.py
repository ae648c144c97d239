"""A fit as arrays: residuals in units of the noise floor, and their Jacobian record by record.

The unknowns are x, the fitted parameters in unbounded coordinates (ln p for positive ones) divided by `scale`, and S, the
initial states of the records that do not start at rest. A record's initial state moves that record only, so the Jacobian
costs p + 2 tangent simulations whatever the number of records; the rule below hands it to optimistix ready made.
"""

from __future__ import annotations

from functools import partial
from typing import NamedTuple

import jax
import jax.numpy as jnp
from jax import Array

from ..response import Equation, Group, simulate_group


class Static(NamedTuple):
    """What decides the compiled program.

    **Arguments:** `equation`; `substeps` per group; `free`, positions of the fitted parameters in the model's list;
    `robust`, whether large residuals count less.
    """

    equation: Equation
    substeps: tuple[int, ...]
    free: tuple[int, ...]
    robust: bool = False


class Data(NamedTuple):
    """What changes without recompiling.

    **Arguments:**

    - `groups`: the records; `template`: (m,) SI values of all parameters, fitted or not.
    - `positive`, `scale`, `anchor`: (p,) of the fitted ones: fitted through the logarithm; unit and origin of x.
    - `prior_mean`, `prior_weight`: (p,) SI; weight 1/deviation, 0 without a prior.
    """

    groups: tuple[Group, ...]
    template: Array
    positive: Array
    scale: Array
    anchor: Array
    prior_mean: Array
    prior_weight: Array


class Unknowns(NamedTuple):
    """`x` (p,) and, per group, `starts` (lanes, 2) in units of the group's `start_scale`."""

    x: Array
    starts: tuple[Array, ...]


# A tenth of a millionth of a standard error: keeps the normal equations solvable along directions that the data leave
# free, and is far too weak to move any that they determine.
_RIDGE = 1e-5
_WORST = 1e8  # residual of a simulation that overflowed: finite, so that the step is rejected rather than the fit lost
_HUBER = 3.0  # robust loss: residuals beyond this many noise floors count linearly


def physical(static: Static, data: Data, x: Array) -> Array:
    """All parameters of the model in SI, (m,), from the unknowns x (p,)."""
    coordinates = x * data.scale + data.anchor
    values = jnp.where(data.positive, jnp.exp(jnp.where(data.positive, coordinates, 0.0)), coordinates)
    return jnp.asarray(data.template).at[jnp.array(static.free, int)].set(values)


def predict(static: Static, data: Data, unknowns: Unknowns) -> tuple[Array, ...]:
    """Sensor readings, one (lanes, n) array per group, m."""
    values = physical(static, data, unknowns.x)
    return tuple(
        simulate_group(static.equation, substeps, values, starts * group.free * group.start_scale, group.lanes)
        for substeps, starts, group in zip(static.substeps, unknowns.starts, data.groups, strict=True)
    )


def _misfit(static: Static, data: Data, unknowns: Unknowns) -> tuple[Array, ...]:
    readings = predict(static, data, unknowns)
    return tuple(
        _bounded((reading - group.response) * group.weight)
        for reading, group in zip(readings, data.groups, strict=True)
    )


def _bounded(residual: Array) -> Array:
    return jnp.where(jnp.abs(residual) < _WORST, residual, _WORST)


class Blocks(NamedTuple):
    """Residuals (lanes, n) per group; Jacobian by x (p, lanes, n) and by the initial states (2, lanes, n) per group."""

    residuals: tuple[Array, ...]
    by_x: tuple[Array, ...]
    by_start: tuple[Array, ...]


def blocks(static: Static, data: Data, unknowns: Unknowns) -> Blocks:
    """Residuals and Jacobian blocks in one pass of p + 2 tangents."""
    p = unknowns.x.shape[0]
    directions = jnp.eye(p + 2)
    primal_to_tangent = partial(jax.jvp, partial(_misfit, static, data), (unknowns,))

    def along(direction: Array) -> tuple[tuple[Array, ...], tuple[Array, ...]]:
        starts = tuple(jnp.broadcast_to(direction[p:], s.shape) for s in unknowns.starts)
        return primal_to_tangent((Unknowns(direction[:p], starts),))

    residuals, tangents = jax.vmap(along, out_axes=(None, 0))(directions)
    tangents = tuple(jnp.where(jnp.isfinite(t), t, 0.0) for t in tangents)
    return Blocks(residuals, tuple(t[:p] for t in tangents), tuple(t[p:] for t in tangents))


@partial(jax.custom_jvp, nondiff_argnums=(0,))
def data_residuals(static: Static, data: Data, unknowns: Unknowns) -> tuple[Array, ...]:
    """(model − measured)/σ of every sample, one (lanes, n) array per group."""
    return _misfit(static, data, unknowns)


@data_residuals.defjvp
def _data_residuals_jvp(static: Static, primals: tuple, tangents: tuple) -> tuple:
    data, unknowns = primals
    change: Unknowns = tangents[1]
    residuals, by_x, by_start = blocks(static, data, unknowns)
    moved = tuple(
        jnp.tensordot(change.x, jx, 1) + jnp.einsum("kln,lk->ln", js, ds)
        for jx, js, ds in zip(by_x, by_start, change.starts, strict=True)
    )
    return residuals, moved


def residuals(static: Static, data: Data, unknowns: Unknowns) -> tuple:
    """Everything that least squares minimises: data, priors, and a ridge that no determined parameter feels."""
    measured = data_residuals(static, data, unknowns)
    if static.robust:
        measured = tuple(soften(r) for r in measured)
    values = physical(static, data, unknowns.x)[jnp.array(static.free, int)]
    prior = (values - data.prior_mean) * data.prior_weight
    return measured, prior, _RIDGE * unknowns.x, tuple(_RIDGE * s for s in unknowns.starts)


def soften(residual: Array) -> Array:
    """Residual whose square is the pseudo-Huber loss 2c²(√(1+(r/c)²) − 1).

    Source: R. Hartley, A. Zisserman, Multiple View Geometry in Computer Vision, 2003, §A6.8.
    """
    return residual * jnp.sqrt(2.0 / (1.0 + jnp.sqrt(1.0 + (residual / _HUBER) ** 2)))
