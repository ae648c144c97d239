"""Two-layer cross-section of a beam: PZT on silicon."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from .scalar import Scalar, library

_ZETA_5 = 1.03692775514336992633  # Riemann's zeta(5)


class Section(NamedTuple):
    """Stiffnesses of the section and what the loads need of its geometry (SI).

    - `silicon_thickness` Ts, `pzt_thickness` Tp, `width` b: m; `pzt_modulus` E_p: Pa.
    - `neutral_axis` z_n: m, from the bottom of the silicon; `pzt_arm` d: m, PZT centre above the neutral axis.
    - `bending` EI: N·m², out of plane; `in_plane_bending` EI_z: N·m²; `torsion` GJ: N·m².
    - `axial` EA: N; `in_plane_shear` GA_y = 5/6 G b h: N.
    """

    silicon_thickness: Scalar
    pzt_thickness: Scalar
    width: Scalar
    pzt_modulus: Scalar
    neutral_axis: Scalar
    pzt_arm: Scalar
    bending: Scalar
    in_plane_bending: Scalar
    torsion: Scalar
    axial: Scalar
    in_plane_shear: Scalar


def torsion_constant(width: Scalar, height: Scalar) -> Scalar:
    """Torsion constant of a rectangle.

    J = b h³/3 · (1 − (192/π⁵)(h/b) Σ_{n odd} tanh(nπb/2h)/n⁵)

    `width` b and `height` h in m, any broadcastable shape; returns m⁴. The series is split at tanh = 1, whose sum is
    31 ζ(5)/32, because the remainder converges exponentially.

    Source: Timoshenko & Goodier, Theory of Elasticity, 1970, §109.
    """
    ratio = width / height
    n = np.arange(1.0, 40.0, 2.0)
    xp = library(ratio)
    decay = xp.exp(-np.pi * n * xp.asarray(ratio)[..., None])
    remainder = (2.0 / n**5 * decay / (1.0 + decay)).sum(axis=-1)
    series = 31.0 / 32.0 * _ZETA_5 - remainder
    return width * height**3 / 3.0 * (1.0 - 192.0 / np.pi**5 / ratio * series)


def section(
    *,
    silicon_modulus: Scalar,
    silicon_poisson: Scalar,
    pzt_modulus: Scalar,
    pzt_poisson: Scalar,
    silicon_thickness: Scalar,
    pzt_thickness: Scalar,
    width: Scalar,
) -> Section:
    """Stiffnesses of a two-layer section, silicon below (0..Ts), PZT above (Ts..Ts+Tp).

    z_n = Σ E_i t_i z̄_i / Σ E_i t_i,   EI = b Σ E_i (t_i³/12 + t_i (z̄_i − z_n)²),   EA = b Σ E_i t_i,
    EI_z = EA b²/12,   GJ = Ḡ J,   GA_y = 5/6 Ḡ b h,   d = Ts + Tp/2 − z_n,
    with h = Ts + Tp and Ḡ the thickness-weighted mean of E_i/(2(1+ν_i)).

    Moduli in Pa, lengths in m, each a scalar (or arrays of one shape).

    Source: Weinberg, Working equations for piezoelectric actuators and sensors, 1999, JMEMS 8(4), 529-533.
    """
    height = silicon_thickness + pzt_thickness
    silicon_centre, pzt_centre = silicon_thickness / 2, silicon_thickness + pzt_thickness / 2
    silicon, pzt = silicon_modulus * silicon_thickness, pzt_modulus * pzt_thickness
    neutral_axis = (silicon * silicon_centre + pzt * pzt_centre) / (silicon + pzt)
    bending = width * (
        silicon * (silicon_thickness**2 / 12 + (silicon_centre - neutral_axis) ** 2)
        + pzt * (pzt_thickness**2 / 12 + (pzt_centre - neutral_axis) ** 2)
    )
    axial = width * (silicon + pzt)
    shear_modulus = (silicon / (1 + silicon_poisson) + pzt / (1 + pzt_poisson)) / (2 * height)
    return Section(
        silicon_thickness=silicon_thickness,
        pzt_thickness=pzt_thickness,
        width=width,
        pzt_modulus=pzt_modulus,
        neutral_axis=neutral_axis,
        pzt_arm=pzt_centre - neutral_axis,
        bending=bending,
        in_plane_bending=axial * width**2 / 12,
        torsion=shear_modulus * torsion_constant(width, height),
        axial=axial,
        in_plane_shear=5.0 / 6.0 * shear_modulus * width * height,
    )
