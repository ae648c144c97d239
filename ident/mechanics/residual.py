"""Residual stress of the layers: the bending moment, the mean force and the deflections that it causes."""

from __future__ import annotations

from typing import Literal, NamedTuple

from .scalar import Scalar
from .section import Section

Moment = Literal["neutral-axis", "paper-integral", "paper-printed"]


class InitialShape(NamedTuple):
    """Deflection of the stress-free-supported beam by residual stress, m.

    - `rise_1` z01: corner → stage; `rise_2` z02: substrate → corner. Their sum is the stage's initial displacement.
    - `curvature` κ: free curvature, 1/m.
    """

    rise_1: Scalar
    rise_2: Scalar
    curvature: Scalar


def residual_moment(
    section: Section,
    sigma12: Scalar,
    sigma23: Scalar,
    sigma2: Scalar = 0.0,
    *,
    moment: Moment = "neutral-axis",
) -> Scalar:
    """Bending moment of a stress that is linear in each layer.

    "neutral-axis":   M = b {σ2 [Tp(z̄_p − z_n) + Ts(Ts/2 − z_n)] + σ12 [Tp(z̄_p − z_n)/2 + Tp²/12]
                             + σ23 [z_n Ts/2 − Ts²/6]}
    "paper-integral": M = b σ12 Tp²/3 + b σ23 Ts²/3     (second line of Eq. 2; lever arms from each layer's bottom)
    "paper-printed":  M = b σ12 ((Tp+Ts)³/3 − Tp²Ts − TpTs²)/Tp + b σ23 Ts²/3     (third line of Eq. 2)

    `sigma12` = σ1 − σ2 (PZT top minus interface), `sigma23` = σ2 − σ3 (interface minus silicon bottom), `sigma2` at
    the interface, all Pa and scalar. The paper's readings ignore `sigma2`. Returns N·m.

    Source: Impacts of Residual Stress on Micro Vibratory Platform…, 2020, Sensors 20, 3959, Eqs. 1-2.
    """
    ts, tp, b, zn = section.silicon_thickness, section.pzt_thickness, section.width, section.neutral_axis
    if moment == "paper-integral":
        return b * (sigma12 * tp**2 / 3 + sigma23 * ts**2 / 3)
    if moment == "paper-printed":
        return b * (sigma12 * ((tp + ts) ** 3 / 3 - tp**2 * ts - tp * ts**2) / tp + sigma23 * ts**2 / 3)
    if moment != "neutral-axis":
        raise ValueError(f"unknown moment {moment!r}: choose neutral-axis, paper-integral or paper-printed")
    d = section.pzt_arm
    return b * (
        sigma2 * (tp * d + ts * (ts / 2 - zn))
        + sigma12 * (tp * d / 2 + tp**2 / 12)
        + sigma23 * (zn * ts / 2 - ts**2 / 6)
    )


def mean_force(section: Section, sigma12: Scalar, sigma23: Scalar, sigma2: Scalar = 0.0) -> Scalar:
    """Axial force of the residual stress.

    N_res = b ∫ σ dz = b [σ2 (Tp + Ts) + σ12 Tp/2 − σ23 Ts/2]

    Stresses as in `residual_moment` (Pa, scalar); returns N, tension positive.

    Source: Sensors 2020, 20, 3959, Eq. 1 (the uniform part).
    """
    ts, tp = section.silicon_thickness, section.pzt_thickness
    return section.width * (sigma2 * (tp + ts) + sigma12 * tp / 2 - sigma23 * ts / 2)


def initial_shape(section: Section, length_1: Scalar, length_2: Scalar, moment: Scalar) -> InitialShape:
    """Initial deflection of the two segments of an L beam under a residual moment.

    κ = M/EI,   z01 = −(κ l1²/2)/(1 + k_r1 l1/EI),   z02 = +(κ l2²/2)/(1 + k_r2 l2/EI),   k_r1 = GJ/l2,  k_r2 = GJ/l1

    `length_1`, `length_2` in m, `moment` in N·m, scalars.

    Source: Sensors 2020, 20, 3959, Eqs. 3-5 with y²/(2EI), and the constants C1, C2 from the corner's torsion.
    """
    curvature = moment / section.bending
    stiffening_1 = section.torsion * length_1 / (length_2 * section.bending)
    stiffening_2 = section.torsion * length_2 / (length_1 * section.bending)
    return InitialShape(
        rise_1=-curvature * length_1**2 / 2 / (1 + stiffening_1),
        rise_2=curvature * length_2**2 / 2 / (1 + stiffening_2),
        curvature=curvature,
    )
