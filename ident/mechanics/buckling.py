"""Buckling of the segments: when the platform fails, said as data."""

from __future__ import annotations

from typing import NamedTuple

import jax
import jax.numpy as jnp

from .scalar import Scalar
from .stage import Beam


class Buckling(NamedTuple):
    """How far axial forces are from buckling.

    - `margin_1`, `margin_2`: 1 − N/N_critical per segment; 1 without force, 0 at buckling, negative beyond.
    - `margin`: the smaller of them; `beyond`: True where it is not positive.
    """

    margin_1: Scalar
    margin_2: Scalar
    margin: Scalar
    beyond: jax.Array


def critical_reduced_force(r: Scalar) -> Scalar:
    """Reduced axial force x = N l²/EI at which a segment's stiffness passes through zero.

    x = −φ²,   φ + arctan(r φ) = π   (that is tan φ = −r φ, the first zero of sinh u + r u cosh u, u² = x)

    `r` = EI/(k_r l) ≥ 0, any shape; no unit. Lies between −π² (clamped root) and −π²/4 (root free to turn). The
    function is concave and rises, so that Newton's method from π/2 climbs to the root without overshooting.

    Source: Timoshenko & Gere, Theory of Elastic Stability, 1961, §2.3.
    """
    angle: Scalar = jnp.full_like(jnp.asarray(r, float), jnp.pi / 2)
    for _ in range(8):
        turned = r * angle
        angle = angle - (angle - jnp.pi + jnp.arctan(turned)) / (1 + r / (1 + turned * turned))
    return -angle * angle


def critical_force(r: Scalar, bending: Scalar, length: Scalar) -> Scalar:
    """Axial force at which a segment buckles.

    N_critical = x_critical(r) EI/l²

    `r` = EI/(k_r l), no unit; `bending` EI, N·m²; `length` m; broadcastable shapes. Returns N, negative.

    Source: as `critical_reduced_force`.
    """
    return critical_reduced_force(r) * bending / length**2


def buckling(beam: Beam, force_1: Scalar, force_2: Scalar) -> Buckling:
    """Distance of axial forces from buckling, never NaN for finite forces.

    m_j = 1 − N_j/N_critical,j

    `force_1`, `force_2` in N, tension positive, any broadcastable shapes (whole trajectories, for example).

    Source: Sensors 2020, 20, 3959, Fig. 12d ("the platform even failed").
    """
    margin_1 = 1 - force_1 * beam.per_force_1 / critical_reduced_force(beam.spring_1)
    margin_2 = 1 - force_2 * beam.per_force_2 / critical_reduced_force(beam.spring_2)
    margin = jnp.minimum(margin_1, margin_2)
    return Buckling(margin_1, margin_2, margin, margin <= 0)
