"""Stiffness of one segment under axial force: one rational function for tension, compression and zero."""

from __future__ import annotations

from fractions import Fraction
from typing import Any

import jax
import jax.numpy as jnp

from .scalar import Scalar, library

LAST_LEVEL = 25
"""Last denominator of the continued fraction, 3, 5, …, 25."""

SMALLEST, LARGEST = -15.0, 1.0e6
"""Range of x = N l²/EI; beyond it the stiffness is held. A segment buckles between −2.5 and −9.9 and its first pole
lies below −20.1, so that −15 is in the buckled range and off every pole; the upper end keeps powers from
overflowing."""


def _coefficients() -> tuple[tuple[float, ...], tuple[float, ...]]:
    """Coefficients, lowest power first, of A and B in 1/(5 + s/(7 + … s/25)) = A/B, in exact arithmetic, B(0) = 1."""
    numerator, denominator = [Fraction(LAST_LEVEL)], [Fraction(1)]
    for level in range(LAST_LEVEL - 2, 3, -2):  # tail ← level + s / tail
        size = max(len(numerator), len(denominator) + 1)
        above = [level * c for c in numerator] + [Fraction(0)] * (size - len(numerator))
        for power, c in enumerate(denominator):
            above[power + 1] += c
        numerator, denominator = above, numerator
    return tuple(float(c / numerator[0]) for c in denominator), tuple(float(c / numerator[0]) for c in numerator)


_A, _B = _coefficients()


def _polynomial(coefficients: tuple[float, ...], s: Scalar) -> Scalar:
    value: Scalar = coefficients[-1]
    for c in reversed(coefficients[:-1]):
        value = value * s + c
    return value


def _parts(x: Scalar) -> tuple[Scalar, Scalar, Scalar, Scalar]:
    """s = x/4 and A, B, Q with h = A/B, g = 1/(3 + s h) = B/Q."""
    s = library(x).clip(x, SMALLEST, LARGEST) / 4
    a, b = _polynomial(_A, s), _polynomial(_B, s)
    return s, a, b, 3 * b + s * a


def stiffness_fraction(x: Scalar, r: Scalar) -> tuple[Scalar, Scalar]:
    """Numerator and denominator of K l³/EI = x + 4 Q T/(B T + c Q²), T = Q + c s B, c = r/(1 + r).

    The form of `segment_stiffness` with q = 1 + s g put in, g = B/Q. The denominator is positive. Kept apart so that
    segments in series need one division in all. Arguments as in `segment_stiffness`.
    """
    s, _, b, q = _parts(x)
    spring = 1 - 1 / (1 + r)  # r/(1 + r), and right even where r overflows
    t = q + spring * (s * b)
    bottom = b * t + spring * q * q
    return 4 * (q * t + s * bottom), bottom


def stiffness_slopes(x: Scalar, r: Scalar) -> tuple[Scalar, Scalar]:
    """Derivatives of K l³/EI = 4 s + 4 y/(g y + c), y = 1 + c s g, c = r/(1 + r), with respect to x and to r.

    K_x = 1 + (c y' − g' y²)/(g y + c)²,   K_r = −4/((1 + r)² (g y + c)²),
    y' = c (1 − q g)/2,   g' = g (h − g)/2   (derivatives in s = x/4, from the Riccati equation of tanh)

    An ordinary rational function, so that it can be differentiated again. K_x is zero outside SMALLEST..LARGEST.
    """
    s, a, b, q_scaled = _parts(x)
    inside = (x > SMALLEST) & (x < LARGEST)
    inverse = 1 / q_scaled
    g = b * inverse
    slope_g = (a * inverse - g * g) / 2
    share = 1 / (1 + r)
    spring = 1 - share
    y = 1 + spring * s * g
    slope_y = spring * (1 - g - s * g * g) / 2
    inverse_square = 1 / (g * y + spring) ** 2
    slope_x = jnp.where(inside, 1 + (spring * slope_y - slope_g * y * y) * inverse_square, 0.0)
    return slope_x, -4 * share * share * inverse_square


@jax.custom_jvp
def segment_stiffness(x: Scalar, r: Scalar) -> Scalar:
    """Dimensionless stiffness of a segment: root on a torsion spring, guided tip, axial force.

    K l³/EI = 4 (q + r q² + r s)/(g (1 + r q) + r),   s = x/4,   g = 1/(3 + s/(5 + s/(7 + … s/25))),   q = 1 + s g

    `x` = N l²/EI (tension positive, any sign), `r` = EI/(k_r l) ≥ 0, any broadcastable shapes; no unit. Equal to
    x/[1 − sinh u/u + (cosh u − 1)(cosh u − 1 + r u sinh u)/(u (sinh u + r u cosh u))], u = √x, to double precision for
    −9 ≤ x ≤ 30, to 5e-13 at 100 and 2e-6 at 1000. Finite for every finite input; held outside −15 ≤ x ≤ 1e6.

    Source: Sensors 2020, 20, 3959, Eqs. 6-11 and Table 1 (corrected); continued fraction of tanh: Abramowitz & Stegun,
    Handbook of Mathematical Functions, 1964, 4.5.70.
    """
    numerator, denominator = stiffness_fraction(x, r)
    return numerator / denominator


def _segment_rule(primals: Any, tangents: Any) -> tuple[Scalar, Scalar]:
    # A scalar slope costs each tangent one multiplication; differentiating the polynomials would cost a whole pass.
    x, r = primals
    slope_x, slope_r = stiffness_slopes(x, r)
    return segment_stiffness(x, r), slope_x * tangents[0] + slope_r * tangents[1]


segment_stiffness.defjvp(_segment_rule)
