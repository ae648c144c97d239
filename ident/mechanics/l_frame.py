"""The L beam as a frame in its own plane: forces from shortening, flexibility at the stage end."""

from __future__ import annotations

import jax
import jax.numpy as jnp

from .scalar import Scalar, library, vector
from .section import Section


def shortening_stiffness(section: Section, length_1: Scalar, length_2: Scalar) -> jax.Array:
    """Axial forces of the clamped-clamped L frame per shortening of its segments, N_i = A_ij Δ_j.

    A = diag(k) − D K⁻¹ Dᵀ,   k_j = EA/l_j,   K the 3×3 stiffness of the corner (u_x, u_y, θ) with EA and EI_z,
    D the corner forces per unit shortening

    Segment 2 runs along x from the substrate to the corner, segment 1 along y from there to the stage; lengths in m.
    Returns (2, 2), N/m, symmetric, order (segment 1, segment 2).

    Source: direct stiffness method; Przemieniecki, Theory of Matrix Structural Analysis, 1968, ch. 6.
    """
    k1, k2 = section.axial / length_1, section.axial / length_2
    i1, i2 = section.in_plane_bending / length_1**3, section.in_plane_bending / length_2**3
    # Seen from the corner, segment 2 lies towards −x and segment 1 towards +y.
    turn_1, turn_2 = -6 * i1 * length_1, -6 * i2 * length_2
    xp = library(k1, k2, i1, i2)
    corner = xp.stack(
        [
            vector(k2 + 12 * i1, 0.0, turn_1),
            vector(0.0, k1 + 12 * i2, turn_2),
            vector(turn_1, turn_2, 4 * (i1 * length_1**2 + i2 * length_2**2)),
        ]
    )
    # A shortened segment pulls the corner: 1 towards +y (its far end is held), 2 towards −x.
    pull = xp.stack([vector(0.0, k1, 0.0), vector(-k2, 0.0, 0.0)])
    return xp.diag(vector(k1, k2)) - pull @ xp.linalg.solve(corner, pull.T)


def _product(a: jax.Array, b: jax.Array) -> jax.Array:
    return (jnp.outer(a, b) + jnp.outer(b, a)) / 2


def in_plane_flexibility(
    section: Section,
    length_1: Scalar,
    length_2: Scalar,
    rise_1: Scalar = 0.0,
    rise_2: Scalar = 0.0,
    *,
    shear: bool = True,
    arch: bool = True,
) -> jax.Array:
    """Flexibility of the L at its stage end for forces (F_x, F_y, M_z), root clamped.

    C = Σ_j [ (l/EI_z) ∫ M Mᵀ + (l/EA) n nᵀ + (l/GA_y) v vᵀ
              + k² l⁵/(720 EI) n nᵀ + (k² l³/GJ)((a aᵀ + b bᵀ)/45 + 7/180 a∘b) ],   k_j = 2 z0_j/l_j²

    n, v: normal and shear force of the segment, a, b: its end moments, per unit end force. The second line is the arch
    softening: a segment of curvature k gives way by bending and twisting out of plane.
    `length_j`, `rise_j` (z0_j) in m; `shear`, `arch` leave these parts in (static). Returns (3, 3),
    symmetric, SI.

    Source: this project, checked against finite elements (data/fe_beam); unit-load method, Timoshenko & Young, Theory
    of Structures, 1965, ch. 7.
    """
    root, corner, stage = vector(-length_1, length_2, 1.0), vector(-length_1, 0.0, 1.0), vector(0.0, 0.0, 1.0)
    along_x, along_y = vector(1.0, 0.0, 0.0), vector(0.0, 1.0, 0.0)
    total = jnp.zeros((3, 3))
    for length, rise, a, b, normal, lateral in (
        (length_2, rise_2, root, corner, along_x, along_y),
        (length_1, rise_1, corner, stage, along_y, along_x),
    ):
        bend = _product(a, a) + _product(b, b)
        total += length / section.in_plane_bending * (bend + _product(a, b)) / 3
        total += length / section.axial * jnp.outer(normal, normal)
        if shear:
            total += length / section.in_plane_shear * jnp.outer(lateral, lateral)
        if arch:
            square = (2 * rise / length**2) ** 2
            total += square * length**5 / (720 * section.bending) * jnp.outer(normal, normal)
            total += square * length**3 / section.torsion * (bend / 45 + 7 / 180 * _product(a, b))
    return total
