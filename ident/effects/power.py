"""What grows with a power of itself, measured from what is proportional to it."""

from __future__ import annotations

import jax.numpy as jnp

from .effect import Scalar

# Of the reference: below, the ratio is constant, for powers under one have no slope at zero. The reference is of the
# largest record, and off its resonance a device at a tenth of the drive moves a thousand times less: with a hundredth
# here |x|^1.5 was 6 % off in a record a hundred times weaker.
_SMALL = 1e-5
_LINEAR = 1e-3  # of the logarithm of the ratio: below, (eˣ − 1)/x is 1 + x/2 to the last digit but one


def beyond_linear(x: Scalar, exponent: Scalar) -> Scalar:
    """x (|x|ⁿ⁻¹ − 1)/(n − 1), x in units of its reference: zero there, and x ln |x| where n goes to one, so that no
    power leans against the linear law beside it. Below a hundred-thousandth of the reference |x| stands still."""
    length = 0.5 * jnp.log(x**2 + _SMALL**2)
    growth = (exponent - 1.0) * length
    small = jnp.abs(growth) < _LINEAR
    return x * length * jnp.where(small, 1.0 + growth / 2.0, jnp.expm1(growth) / jnp.where(small, 1.0, growth))
