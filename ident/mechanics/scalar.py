"""The type of a physical quantity inside the mechanics: a plain number or a JAX array, in SI units."""

from __future__ import annotations

from typing import Any

import jax
import jax.numpy as jnp
import numpy as np

Scalar = jax.Array | float


def library(*numbers: Scalar) -> Any:
    """numpy if all are plain numbers, otherwise jax.numpy: what geometry alone decides is not traced and compiled."""
    return jnp if any(isinstance(number, jax.Array) for number in numbers) else np


def vector(*components: Scalar) -> jax.Array:
    """A vector from scalars, plain numbers or traced ones: (n,) in their common unit."""
    xp = library(*components)
    return xp.stack([xp.asarray(c, float) for c in components])
