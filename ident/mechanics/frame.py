"""The "frame" closure: restoring force of an L beam from the geometric mismatch of its in-plane frame."""

from __future__ import annotations

from typing import Literal, NamedTuple

import jax
import jax.numpy as jnp

from .l_frame import in_plane_flexibility
from .residual import InitialShape
from .scalar import Scalar, vector
from .section import Section
from .stage import l_beam

InPlane = Literal["yaw", "clamped", "free", "translation"]

NEWTON_STEPS = 8  # from zero; the last two carry the derivatives


class FrameLaw(NamedTuple):
    """Restoring force of one beam, F = k1 z + k2 z² + k3 z³, z from the stressed equilibrium.

    `k1` N/m, `k2` N/m², `k3` N/m³; `rise` z0, m: height of the stage above its stress-free position.
    """

    k1: Scalar
    k2: Scalar
    k3: Scalar
    rise: Scalar


def _mismatch(length_1: Scalar, length_2: Scalar) -> jax.Array:
    """Quadratic forms (3, 4, 4) of the end mismatch: e(v) = vᵀ E v, v = (w, D, b1, b2), e = (e_x, e_y, e_ψ).

    e_x = −[3w²/(5 l2) − w b2/10 + l2 b2²/15] − [l1 b1 w/l2 + b2 D − (5/6) l1 b1 b2]
    e_y = −[3D²/(5 l1) − D b1/10 + l1 b1²/15] − l2 b1 b2/6
    e_ψ = b1 w/l2 + b2 D/l1 − b1 b2
    """
    l1, l2 = length_1, length_2
    return jnp.array(
        [
            [
                [-3 / (5 * l2), 0, -l1 / (2 * l2), 1 / 20],
                [0, 0, 0, -1 / 2],
                [-l1 / (2 * l2), 0, 0, 5 * l1 / 12],
                [1 / 20, -1 / 2, 5 * l1 / 12, -l2 / 15],
            ],
            [
                [0, 0, 0, 0],
                [0, -3 / (5 * l1), 1 / 20, 0],
                [0, 1 / 20, -l1 / 15, -l2 / 12],
                [0, 0, -l2 / 12, 0],
            ],
            [
                [0, 0, 1 / (2 * l2), 0],
                [0, 0, 0, 1 / (2 * l1)],
                [1 / (2 * l2), 0, 0, -1 / 2],
                [0, 1 / (2 * l1), -1 / 2, 0],
            ],
        ]
    )


def _equilibrium(c0: Scalar, c1: Scalar, c2: Scalar, c3: Scalar, least_slope: Scalar) -> Scalar:
    """Root of c0 + c1 Z + c2 Z² + c3 Z³ near zero, by a fixed count of Newton steps.

    Only the last two steps are differentiated: at the root each doubles the order to which derivatives are right, so
    that they are exact to third order at a quarter of the work.
    """

    def step(z: Scalar, coefficients: tuple[Scalar, ...]) -> Scalar:
        a0, a1, a2, a3 = coefficients
        slope = a1 + z * (2 * a2 + 3 * a3 * z)
        # Near buckling the slope may vanish: the floor keeps the step finite and leaves the root where it is.
        return z - (a0 + z * (a1 + z * (a2 + z * a3))) / jnp.maximum(slope, least_slope)

    frozen = jax.lax.stop_gradient((c0, c1, c2, c3))
    z: Scalar = jax.lax.fori_loop(0, NEWTON_STEPS - 2, lambda _, z: step(z, frozen), jnp.zeros_like(jnp.asarray(c0)))
    return step(step(jax.lax.stop_gradient(z), (c0, c1, c2, c3)), (c0, c1, c2, c3))


def end_stiffness(flexibility: jax.Array, in_plane: InPlane, beam_end: tuple[float, float] = (0.0, 0.0)) -> jax.Array:
    """In-plane stiffness that the stage's end offers, without the directions in which the stage is free.

    G = C⁻¹,   G ← G − G T (TᵀG T)⁻¹ TᵀG

    `flexibility` C (3, 3) for (F_x, F_y, M_z). `in_plane`: "clamped" (no T), "yaw" (the stage turns about its centre,
    T = (−R_y, R_x, 1) with R = `beam_end` in m), "translation" (moves, does not turn), "free" (G = 0). Returns (3, 3).

    Source: static condensation, Guyan, 1965, AIAA J. 3(2), 380.
    """
    if in_plane == "free":
        return jnp.zeros_like(flexibility)
    stiffness = jnp.linalg.inv(flexibility)
    if in_plane == "clamped":
        return stiffness
    if in_plane == "yaw":
        free = [jnp.array([-beam_end[1], beam_end[0], 1.0])]
    elif in_plane == "translation":
        free = [jnp.array([1.0, 0.0, 0.0]), jnp.array([0.0, 1.0, 0.0])]
    else:
        raise ValueError(f"unknown in-plane freedom {in_plane!r}: choose yaw, clamped, free or translation")
    for direction in free:  # one after the other: what is left resists no direction already free
        resisted = stiffness @ direction
        stiffness = stiffness - jnp.outer(resisted, resisted) / (direction @ resisted)
    return stiffness


def frame_law(
    section: Section,
    length_1: Scalar,
    length_2: Scalar,
    shape: InitialShape,
    force: Scalar = 0.0,
    *,
    in_plane: InPlane = "yaw",
    beam_end: tuple[float, float] = (0.0, -1.5e-3),
    shear: bool = True,
    arch: bool = True,
) -> FrameLaw:
    """Restoring force of one beam from the in-plane frame, nothing fitted but the stress.

    F(Z) = K_L Z + (q + 2 p Z)ᵀ G (e0 + q Z + p Z²),   F(Z_e) = 0,
    k3 = 2 pᵀG p,   k2 = 3 pᵀG q + 3 k3 Z_e,   k1 = F′(Z_e),   z0 = z01 + z02 + Z_e

    p = e(φ), q = 2 e(ω, φ), e0 = e(ω) − (N_res/EA)(l2, l1, 0): end mismatch of the elastic direction φ on the residual
    state ω. Lengths in m, `shape` from `initial_shape`, `force` N_res in N, `beam_end` in m; scalars. `in_plane`,
    `shear`, `arch` are static. Within 0.1-1 % of finite elements on a flat beam, 1-2 % at (90, 20, −10) MPa over
    ±60 µm; legs of unequal length (1.5 and 3.5 mm) cost up to 10 % at double stress. Beam theory: no plate effects, no
    finite corner.

    Source: this project; finite elements in data/fe_beam.
    """
    beam = l_beam(section, length_1, length_2)
    bend_1, bend_2 = (6 * r / (1 + 4 * r) for r in (beam.spring_1, beam.spring_2))
    elastic = vector(beam.share_2, beam.share_1, beam.share_1 * bend_1 / length_1, beam.share_2 * bend_2 / length_2)
    residual = vector(shape.rise_2, shape.rise_1, 2 * shape.rise_1 / length_1, 2 * shape.rise_2 / length_2)
    mismatch = _mismatch(length_1, length_2)
    p, q = mismatch @ elastic @ elastic, 2 * (mismatch @ elastic @ residual)
    e0 = mismatch @ residual @ residual - force / section.axial * vector(length_2, length_1, 0.0)
    flexibility = in_plane_flexibility(section, length_1, length_2, shape.rise_1, shape.rise_2, shear=shear, arch=arch)
    g = end_stiffness(flexibility, in_plane, beam_end)

    linear_1, linear_2 = (
        12 * scale * (1 + r) / (1 + 4 * r)
        for scale, r in ((beam.scale_1, beam.spring_1), (beam.scale_2, beam.spring_2))
    )
    unstressed = linear_1 * linear_2 / (linear_1 + linear_2)
    c0, c1, c2, c3 = q @ g @ e0, unstressed + q @ g @ q + 2 * (p @ g @ e0), 3 * (p @ g @ q), 2 * (p @ g @ p)
    z = _equilibrium(c0, c1, c2, c3, 0.02 * unstressed)
    return FrameLaw(k1=c1 + z * (2 * c2 + 3 * c3 * z), k2=c2 + 3 * c3 * z, k3=c3, rise=shape.rise_1 + shape.rise_2 + z)
