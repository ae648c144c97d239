"""A law as a table: a cubic spline over one coordinate, level beyond its ends.

Source: C. de Boor, A Practical Guide to Splines, 1978, ch. IX (B-splines of evenly spaced knots).
"""

from __future__ import annotations

import jax.numpy as jnp
from jax import Array

from .effect import Scalar


def spline(x: Scalar, low: float, high: float, coefficients: Array) -> Array:
    """f(x) = Σ c_k B((x − x_k)/h), h = (high − low)/(K − 3), x_k = low + (k − 1) h

    with B the cubic B-spline of whole-numbered knots, 2/3 at its centre and 0 from ±2, and x clipped to [low, high].

    `x` of any shape, in the unit of `low` and `high`; `coefficients` (K,), K ≥ 4, in the unit of f. Only the four
    splines that are not zero at x are computed, so that a long table costs no more than a short one.
    """
    pieces = len(coefficients) - 3
    place = jnp.clip((x - low) / (high - low), 0.0, 1.0) * pieces
    first = jnp.clip(jnp.floor(place), 0, pieces - 1)
    u = place - first
    weights = ((1 - u) ** 3, 3 * u**3 - 6 * u**2 + 4, 1 + 3 * u + 3 * u**2 - 3 * u**3, u**3)
    k = first.astype(int)
    near = (coefficients.at[k + i].get(mode="promise_in_bounds") for i in range(4))
    first, *others = (weight * c for weight, c in zip(weights, near, strict=True))
    return sum(others, first) / 6
