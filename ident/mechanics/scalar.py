"""The type of a physical quantity inside the mechanics: a plain number or a JAX array, in SI units."""

from __future__ import annotations

import jax
import jax.numpy as jnp

Scalar = jax.Array | float


def vector(*components: Scalar) -> jax.Array:
    """A vector from scalars, plain numbers or traced ones: (n,) in their common unit."""
    return jnp.stack([jnp.asarray(c, float) for c in components])
