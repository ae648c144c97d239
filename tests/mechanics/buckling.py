"""Where a segment buckles, in closed form: the stiffness must pass through zero there."""

from __future__ import annotations

import jax.numpy as jnp

from ident.mechanics import Scalar


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
