"""Stiffness of one segment under axial force, from the hyperbolic and circular closed form.

With x = N l²/EI, u = √x and r = EI/(k_r l) the closed form

    K l³/EI = x / [1 − sinh u/u + (cosh u − 1)(cosh u − 1 + r u sinh u)/(u (sinh u + r u cosh u))]

is written with S = sinh u/u, C = cosh u, c = (C − 1)/x and s = (S − 1)/x, which are circular functions for x < 0:

    K l³/EI = 1 / [c (c + r S)/(S + r C) − s].

Close to x = 0, where c and s would lose digits, they are summed as the power series of those functions.
"""

from __future__ import annotations

import math

from numba import njit


@njit(cache=False)
def segment_stiffness(x: float, r: float) -> float:
    """Dimensionless stiffness K l³/EI at the dimensionless axial force x = N l²/EI (tension positive)."""
    if abs(x) < 0.3:
        c, s, term_c, term_s = 0.5, 1.0 / 6.0, 0.5, 1.0 / 6.0
        for k in range(1, 9):
            term_c *= x / ((2 * k + 1) * (2 * k + 2))
            term_s *= x / ((2 * k + 2) * (2 * k + 3))
            c += term_c
            s += term_s
        cosh, sinh = 1.0 + x * c, 1.0 + x * s
    else:
        u = math.sqrt(abs(x))
        if x > 0:
            cosh, sinh = math.cosh(u), math.sinh(u) / u
        else:
            cosh, sinh = math.cos(u), math.sin(u) / u
        c, s = (cosh - 1.0) / x, (sinh - 1.0) / x
    return 1.0 / (c * (c + r * sinh) / (sinh + r * cosh) - s)
