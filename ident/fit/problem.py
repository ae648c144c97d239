"""A fit as arrays: residuals in units of the noise floor, and their Jacobian record by record.

The unknowns are x, the fitted parameters in unbounded coordinates (ln p for positive ones) divided by `scale`, and the
initial states of the records that do not start at rest. A record's initial state moves that record only, so the
Jacobian costs p + 2 tangent simulations whatever the number of records (p if all start at rest).
"""

from __future__ import annotations

from functools import partial
from typing import NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jax import Array

from ..response import Equation, Group, simulate_group
from ..runtime import compiler_options
from .coordinates import to_values

Numbers = Array | np.ndarray


class Static(NamedTuple):
    """What decides the compiled program.

    **Arguments:** `equation`; `substeps` per group; `free`, positions of the fitted parameters in the model's list;
    `starts_free`, whether any record's initial state is fitted.
    """

    equation: Equation
    substeps: tuple[int, ...]
    free: tuple[int, ...]
    starts_free: bool


class Data(NamedTuple):
    """What changes without recompiling.

    **Arguments:**

    - `groups`: the records; `template`: (m,) SI values of all parameters, fitted or not.
    - `lower`, `upper`: (p,) bounds of the fitted ones (see coordinates); `scale`, `anchor`: (p,) unit and origin of x.
    - `prior_mean`, `prior_weight`: (p,) SI; weight 1/deviation, 0 without a prior.
    """

    groups: tuple[Group, ...]
    template: Numbers
    lower: Numbers
    upper: Numbers
    scale: Numbers
    anchor: Numbers
    prior_mean: Numbers
    prior_weight: Numbers


class Unknowns(NamedTuple):
    """`x` (p,) and, per group, `starts` (lanes, 2) in units of the group's `start_scale`."""

    x: Numbers
    starts: tuple[Numbers, ...]


_WORST = 1e8  # residual of a simulation that overflowed: finite, so that the step is rejected rather than the fit lost


def physical(static: Static, data: Data, x: Numbers) -> Array:
    """All parameters of the model in SI, (m,), from the unknowns x (p,)."""
    values = to_values(x * data.scale + data.anchor, data.lower, data.upper)
    return jnp.asarray(data.template).at[jnp.array(static.free, int)].set(values)


def predict(static: Static, data: Data, unknowns: Unknowns) -> tuple[Array, ...]:
    """Sensor readings, one (lanes, n) array per group, m."""
    values = physical(static, data, unknowns.x)
    return tuple(
        simulate_group(static.equation, substeps, values, starts * group.free * group.start_scale, group.lanes)
        for substeps, starts, group in zip(static.substeps, unknowns.starts, data.groups, strict=True)
    )


class Evaluation(NamedTuple):
    """A model at one point.

    **Arguments:** `values`, (m,) SI; per group `readings` and `residuals` (model − measured)/σ, (lanes, n), and the
    residuals' derivatives `by_x` (p, lanes, n) and `by_start` (2, lanes, n), the latter empty if all start at rest.
    """

    values: Array
    readings: tuple[Array, ...]
    residuals: tuple[Array, ...]
    by_x: tuple[Array, ...]
    by_start: tuple[Array, ...]


@partial(jax.jit, static_argnums=0, compiler_options=compiler_options())
def evaluate(static: Static, data: Data, unknowns: Unknowns) -> Evaluation:
    """Residuals and Jacobian in one pass of tangent simulations."""
    p = unknowns.x.shape[0]
    directions = jnp.eye(p + 2 * static.starts_free)

    def misfit(at: Unknowns) -> tuple[tuple[Array, ...], tuple[Array, ...]]:
        readings = predict(static, data, at)
        residuals = ((r - g.response) * g.weight for r, g in zip(readings, data.groups, strict=True))
        return tuple(jnp.where(jnp.abs(r) < _WORST, r, _WORST) for r in residuals), readings

    def along(direction: Array) -> tuple[tuple[Array, ...], tuple[Array, ...], tuple[Array, ...]]:
        step = direction[p:] if static.starts_free else jnp.zeros(2)
        starts = tuple(jnp.broadcast_to(step, s.shape) for s in unknowns.starts)
        return jax.jvp(misfit, (unknowns,), (Unknowns(direction[:p], starts),), has_aux=True)

    residuals, tangents, readings = jax.vmap(along, out_axes=(None, 0, None))(directions)
    tangents = tuple(jnp.where(jnp.isfinite(t), t, 0.0) for t in tangents)
    values = physical(static, data, unknowns.x)
    return Evaluation(values, readings, residuals, tuple(t[:p] for t in tangents), tuple(t[p:] for t in tangents))


@partial(jax.jit, static_argnums=0, compiler_options=compiler_options())
def read_groups(static: Static, data: Data, unknowns: Unknowns) -> tuple[Array, ...]:
    """Model readings alone, per group."""
    return predict(static, data, unknowns)
