"""The paper's formulas as printed beside their corrected forms, to show the slips (`slips`).

Source of everything here: Impacts of Residual Stress on Micro Vibratory Platform Used for Inertial Sensor Calibration,
2020, Sensors 20, 3959. Plain NumPy, SI units.
"""

from __future__ import annotations

from typing import Literal, NamedTuple

import numpy as np

Segment = Literal[1, 2]


class Coefficients(NamedTuple):
    """Coefficients of Table 1: `c1`, `c2` (m³), and C3 = `a3` F/EI + `b3` z(l), with `a3` in m and `b3` in 1/m²."""

    c1: float
    c2: float
    a3: float
    b3: float


def stress_profile(
    height: np.ndarray,
    stresses: tuple[float, float, float],
    silicon_thickness: float,
    pzt_thickness: float,
    *,
    printed: bool,
) -> np.ndarray:
    """Residual stress through the thickness, Eq. 1.

    Printed: mean stress + (σ1 − σ2)(z − Ts)/Tp above Ts, + (σ2 − σ3) z/Ts below: it jumps at the interface.
    Corrected: linear from σ3 (bottom) through σ2 (interface) to σ1 (top).

    `height` z (n,) from the bottom and thicknesses in m, `stresses` (σ1, σ2, σ3) in Pa; returns (n,) Pa.
    """
    top, interface, bottom = stresses
    ts, tp = silicon_thickness, pzt_thickness
    z = np.asarray(height, float)
    upper = (top - interface) * (z - ts) / tp
    lower = (interface - bottom) * z / ts
    if printed:
        mean = ((top + interface) * tp + (interface + bottom) * ts) / (2 * (tp + ts))
        return mean + np.where(z >= ts, upper, lower)
    return np.where(z >= ts, interface + upper, bottom + lower)


def free_deflection(
    length: float,
    sigma12: float,
    sigma23: float,
    silicon_thickness: float,
    pzt_thickness: float,
    width: float,
    bending: float,
    *,
    printed: bool,
) -> float:
    """Tip deflection of a free segment by residual stress, Eqs. 4-5 without C1 and C2.

    Printed: (b l²/EI) [σ12 g/Tp + σ23 Ts³/(3 Tp)],   g = (Tp+Ts)³/3 − Tp² Ts − Tp Ts²
    Corrected (same lever arms): (b l²/2EI) [σ12 g/Tp + σ23 Ts³/(3 Ts)]

    Lengths in m, stresses in Pa, `bending` EI in N·m²; returns m.
    """
    ts, tp = silicon_thickness, pzt_thickness
    lever = (tp + ts) ** 3 / 3 - tp**2 * ts - tp * ts**2
    if printed:
        return width * length**2 / bending * (sigma12 * lever / tp + sigma23 * ts**3 / (3 * tp))
    return width * length**2 / (2 * bending) * (sigma12 * lever / tp + sigma23 * ts**3 / (3 * ts))


def particular_solution(
    position: float, alpha: float, force: float, c3: float, tip: float, length: float, *, printed: bool
) -> float:
    """Particular solution of the deflection under axial force, Eqs. 9-10.

    Printed for α < 0: (f y − α z(l) − f l − C3)/(−α).   Corrected, and printed for α > 0: (f (y − l) + α z(l) − C3)/α

    `position` y, `tip` z(l), `length` l in m; `alpha` N/EI in 1/m²; `force` f = F/EI in 1/m²; `c3` in 1/m. Returns m.
    """
    if printed and alpha < 0:
        return (force * position - alpha * tip - force * length - c3) / -alpha
    return (force * (position - length) + alpha * tip - c3) / alpha


def _compressed(segment: Segment, alpha: float, length: float, spring: float, printed: bool) -> Coefficients:
    u = np.sqrt(-alpha)
    sine, cosine = np.sin(u * length), np.cos(u * length)
    bottom = sine + u * spring * cosine
    sign = 1 if printed else -1
    b3 = (-(u**3) * sine + sign * u**4 * spring * cosine) / (u * bottom)
    own = u * length * sine + u**2 * length * spring * cosine
    if segment == 1:
        return Coefficients(
            c1=(cosine - 1) / (u**3 * bottom),
            c2=(sine + u * spring) / (u**3 * bottom),
            a3=(1 - cosine - own) / (u * bottom),
            b3=b3,
        )
    lifted = 1 - cosine + u * spring * sine
    return Coefficients(c1=-lifted / (u**3 * bottom), c2=1 / u**3, a3=(lifted - own) / (u * bottom), b3=b3)


def _stretched(segment: Segment, alpha: float, length: float, spring: float, printed: bool) -> Coefficients:
    u = np.sqrt(alpha)
    e = np.exp(u * length)
    s = u * spring
    bottom = e**2 + s + s * e**2 - 1
    right = (u**3 * (e**2 - 1) + u**4 * spring * (1 + e**2)) / (u * bottom)
    if segment == 1:
        slipped = (u**3 * (1 - e**2) + alpha**2 * spring + alpha * spring * e**2) / (u * bottom)
        own = u * length * (1 - e**2) - alpha * length * spring * (1 + e**2)
        return Coefficients(
            c1=-(e - 1 + s * e) / (u**3 * bottom),
            c2=e * (e + s - 1) / (u**3 * bottom),
            a3=((e - 1) ** 2 + own) / (u * bottom),
            b3=slipped if printed else right,
        )
    sign = 1 if printed else -1
    a3 = (e - 1) ** 2 + (s - u * length) * (e**2 - 1) + sign * alpha * length * spring * (e**2 + 1)
    return Coefficients(
        c1=-(e - 1 + s) / (u**3 * bottom),
        c2=(e**2 - e + s * (e if printed else e**2)) / (u**3 * bottom),
        a3=a3 / (u * bottom),
        b3=right,
    )


def table_1(segment: Segment, alpha: float, length: float, spring: float, *, printed: bool) -> Coefficients:
    """Coefficients of Table 1, as printed or corrected.

    z(y) = f C1 cos(uy) + f C2 sin(uy) + (f (y − l) + α z(l) − C3)/α for α = −u² < 0, with exp(±uy) for α = u² > 0;
    C3 = A3 f + B3 z(l), f = F/EI

    Slips: B3 is α for every segment and sign, but is printed otherwise in C13 (both signs) and C23 (α < 0); C22 (α > 0)
    has s e^u for s e^{2u}; A3 of C23 (α > 0) has + for −. Here s = u EI/k_r.

    `segment` 1 (root on a torsion spring, guided tip) or 2 (clamped root, tip on a spring); `alpha` N/EI ≠ 0 in 1/m²;
    `length` l and `spring` EI/k_r in m.
    """
    solve = _compressed if alpha < 0 else _stretched
    return solve(segment, alpha, length, spring, printed)


def stiffness(
    segment: Segment, force: float, bending: float, length: float, torsion_spring: float, *, printed: bool
) -> float:
    """Stiffness of a segment by Eq. 11 with Table 1, as printed or corrected.

    F/z = B3 / [α (C1 cos(ul)/EI + C2 sin(ul)/EI − A3/(EI α))], with exp(±ul) for α > 0

    `force` N ≠ 0 in N, tension positive; `bending` EI in N·m²; `length` in m; `torsion_spring` k_r in N·m/rad. N/m.
    """
    alpha = force / bending
    c1, c2, a3, b3 = table_1(segment, alpha, length, bending / torsion_spring, printed=printed)
    u = np.sqrt(abs(alpha)) * length
    shapes = (np.cos(u), np.sin(u)) if alpha < 0 else (np.exp(u), np.exp(-u))
    return float(b3 * bending / (alpha * (c1 * shapes[0] + c2 * shapes[1] - a3 / alpha)))
