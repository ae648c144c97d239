"""Stiffness of the L beam and of the stage: two segments in series, four beams."""

from __future__ import annotations

from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jax.custom_derivatives import SymbolicZero

from .scalar import Scalar, library
from .section import Section
from .stiffness import stiffness_fraction, stiffness_slopes

BEAMS = 4
"""Number of beams that carry the stage."""


class Beam(NamedTuple):
    """What the stiffness of an L beam needs; constant along a trajectory.

    Per segment j (1: corner → stage, 2: substrate → corner): `length_j` l, m; `per_force_j` l²/EI, 1/N, which turns an
    axial force into x; `spring_j` r = EI/(k_r l), no unit; `scale_j` EI/l³, N/m; `share_j`, the part of the stage's
    displacement that the segment takes at N = 0.
    """

    length_1: Scalar
    length_2: Scalar
    per_force_1: Scalar
    per_force_2: Scalar
    spring_1: Scalar
    spring_2: Scalar
    scale_1: Scalar
    scale_2: Scalar
    share_1: Scalar
    share_2: Scalar


def l_beam(section: Section, length_1: Scalar, length_2: Scalar) -> Beam:
    """Constants of an L beam from its section and the lengths of its segments.

    r_1 = EI l2/(GJ l1),   r_2 = EI l1/(GJ l2),   K_j⁰ = 12 (EI/l_j³)(1 + r_j)/(1 + 4 r_j),   s_1 = K_2⁰/(K_1⁰ + K_2⁰)

    Lengths in m, scalars. Each segment bends against the other one's twist, hence the crossed lengths.

    Source: Sensors 2020, 20, 3959, Eqs. 6-7.
    """
    r1 = section.bending * length_2 / (section.torsion * length_1)
    r2 = section.bending * length_1 / (section.torsion * length_2)
    scale_1, scale_2 = section.bending / length_1**3, section.bending / length_2**3
    k1, k2 = scale_1 * (1 + r1) / (1 + 4 * r1), scale_2 * (1 + r2) / (1 + 4 * r2)
    return Beam(
        length_1=length_1,
        length_2=length_2,
        per_force_1=length_1**2 / section.bending,
        per_force_2=length_2**2 / section.bending,
        spring_1=r1,
        spring_2=r2,
        scale_1=scale_1,
        scale_2=scale_2,
        share_1=k2 / (k1 + k2),
        share_2=k1 / (k1 + k2),
    )


def series_stiffness(x1: Scalar, x2: Scalar, r1: Scalar, r2: Scalar, scale_1: Scalar, scale_2: Scalar) -> Scalar:
    """Stiffness of two segments in series, with a single division.

    K_L = K1 K2/(K1 + K2)

    `x1`, `x2`: N l²/EI; `r1`, `r2`: EI/(k_r l); `scale_1`, `scale_2`: EI/l³ in N/m; any broadcastable shapes; N/m.
    A buckled segment has a negative stiffness. K_L then has a pole at K1 + K2 = 0, where the beam snaps even with its
    end held; from K_j = −K_i/2 on the value is held at −max(K1, K2, 0), continuous and bounded: nothing there is
    physical.

    Source: Sensors 2020, 20, 3959, Eq. 11.
    """
    rule = _series if library(x1, x2, r1, r2, scale_1, scale_2) is np else _differentiable
    return rule(x1, x2, r1, r2, scale_1, scale_2)


def _series(x1: Scalar, x2: Scalar, r1: Scalar, r2: Scalar, scale_1: Scalar, scale_2: Scalar) -> Scalar:
    n1, d1 = stiffness_fraction(x1, r1)
    n2, d2 = stiffness_fraction(x2, r2)
    top_1, top_2 = scale_1 * n1, scale_2 * n2
    k1, k2 = top_1 * d2, top_2 * d1  # the stiffnesses times d1 d2
    regular = (2 * k1 + k2 > 0) & (k1 + 2 * k2 > 0)
    xp = library(k1, k2)
    numerator = xp.where(regular, top_1 * top_2, -xp.maximum(xp.maximum(k1, k2), 0.0))
    return numerator / xp.where(regular, k1 + k2, d1 * d2)


def _series_rule(primals: Any, tangents: Any) -> tuple[Scalar, Scalar]:
    x1, x2, r1, r2, scale_1, scale_2 = primals
    n1, d1 = stiffness_fraction(x1, r1)
    n2, d2 = stiffness_fraction(x2, r2)
    k1, k2 = n1 / d1, n2 / d2
    full_1, full_2 = scale_1 * k1, scale_2 * k2
    regular = (2 * full_1 + full_2 > 0) & (full_1 + 2 * full_2 > 0)
    inverse = 1 / jnp.where(regular, full_1 + full_2, 1.0)
    first = jnp.where((full_1 >= full_2) & (full_1 > 0), -1.0, 0.0)
    second = jnp.where((full_2 > full_1) & (full_2 > 0), -1.0, 0.0)
    weight_1 = jnp.where(regular, (full_2 * inverse) ** 2, first)
    weight_2 = jnp.where(regular, (full_1 * inverse) ** 2, second)
    slope_x1, slope_r1 = stiffness_slopes(x1, r1)
    slope_x2, slope_r2 = stiffness_slopes(x2, r2)
    slopes = (
        weight_1 * scale_1 * slope_x1,
        weight_2 * scale_2 * slope_x2,
        weight_1 * scale_1 * slope_r1,
        weight_2 * scale_2 * slope_r2,
        weight_1 * k1,
        weight_2 * k2,
    )
    # Geometry is rarely fitted: its tangents are symbolic zeros and cost nothing.
    terms = [slope * t for slope, t in zip(slopes, tangents, strict=True) if not isinstance(t, SymbolicZero)]
    primal = _differentiable(*primals)
    return primal, sum(terms[1:], terms[0]) if terms else jnp.zeros_like(primal)


_differentiable = jax.custom_jvp(_series)
_differentiable.defjvp(_series_rule, symbolic_zeros=True)


def stage_stiffness(beam: Beam, force_1: Scalar, force_2: Scalar) -> Scalar:
    """Stiffness of the stage on four beams under axial forces in their segments.

    K_stage = 4 K1(N1) K2(N2)/(K1(N1) + K2(N2))

    `force_1`, `force_2` in N, tension positive, any broadcastable shapes; returns N/m.

    Source: Sensors 2020, 20, 3959, Eqs. 11 and 13.
    """
    return BEAMS * series_stiffness(
        force_1 * beam.per_force_1, force_2 * beam.per_force_2, beam.spring_1, beam.spring_2, beam.scale_1, beam.scale_2
    )
