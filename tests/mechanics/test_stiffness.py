"""The rational stiffness of a segment against the closed form, a boundary-value solver, and its own derivatives."""

from __future__ import annotations

import jax
import mpmath
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import solve_bvp

from ident.mechanics import segment_stiffness
from ident.mechanics.stiffness import LARGEST, SMALLEST, stiffness_fraction

SPRINGS = (0.0, 0.3, 0.7, 1.2, 50.0)
value = jax.jit(segment_stiffness)
slope = jax.jit(jax.grad(segment_stiffness))
spring_slope = jax.jit(jax.grad(segment_stiffness, argnums=1))
second = jax.jit(jax.grad(jax.grad(segment_stiffness)))
mixed = jax.jit(jax.grad(jax.grad(segment_stiffness), argnums=1))
spring_second = jax.jit(jax.grad(jax.grad(segment_stiffness, argnums=1), argnums=1))

finite = st.floats(allow_nan=False, allow_infinity=False)
springs = st.floats(0.0, 1e3)
any_spring = st.floats(0.0, allow_nan=False, allow_infinity=False)
usual = st.floats(-2.4, 30.0)  # unbuckled for every spring


def closed_form(x, r):
    """K l³/EI from hyperbolic functions of u = √x, in the precision of the mpmath context."""
    x, r = mpmath.mpf(x), mpmath.mpf(r)
    u = mpmath.sqrt(mpmath.mpc(x))
    sh, ch = mpmath.sinh(u), mpmath.cosh(u)
    return mpmath.re(x / (1 - sh / u + (ch - 1) * (ch - 1 + r * u * sh) / (u * (sh + r * u * ch))))


@pytest.mark.parametrize(
    "xs, tolerance",
    [
        ((-14.0, -9.0, -4.9, -1.0, -1e-3, -1e-9, 1e-9, 0.1, 3.0, 30.0), 5e-15),
        ((100.0,), 6e-13),
        ((1000.0,), 3e-6),
        ((1e5, 9.9e5), 1e-2),
    ],
)
@pytest.mark.parametrize("r", SPRINGS)
def test_equals_the_closed_form(xs, tolerance, r):
    for x in xs:
        with mpmath.workdps(900 if x > 1e4 else 80):
            expected = float(closed_form(x, r))
        assert float(value(x, r)) == pytest.approx(expected, rel=tolerance)


@pytest.mark.parametrize("r", (0.3, 0.7, 1.2))
def test_bounded_error_far_outside_for_a_platform(r):
    with mpmath.workdps(900):
        assert float(value(9.9e5, r)) == pytest.approx(float(closed_form(9.9e5, r)), rel=1e-3)


@pytest.mark.parametrize("r", SPRINGS)
def test_without_force(r):
    assert float(value(0.0, r)) == pytest.approx(12 * (1 + r) / (1 + 4 * r), rel=1e-15)


@pytest.mark.parametrize("r", SPRINGS)
@pytest.mark.parametrize("x", (-14.0, -9.0, -4.9, -0.1, -1e-8, 1e-8, 1.0, 10.0, 30.0))
def test_derivatives_equal_those_of_the_closed_form(x, r):
    with mpmath.workdps(120):
        step = mpmath.mpf(10) ** -20
        by_x = mpmath.diff(lambda t: closed_form(t, r), x, h=step)
        by_r = mpmath.diff(lambda t: closed_form(x, t), r, h=step)
        by_xx = mpmath.diff(lambda t: closed_form(t, r), x, 2, h=step)
        by_rr = mpmath.diff(lambda t: closed_form(x, t), r, 2, h=step)
        by_xr = mpmath.diff(lambda a, b: closed_form(a, b), (mpmath.mpf(x), mpmath.mpf(r)), (1, 1), h=step)
    assert float(slope(x, r)) == pytest.approx(float(by_x), rel=1e-14)
    assert float(spring_slope(x, r)) == pytest.approx(float(by_r), rel=1e-14)
    assert float(second(x, r)) == pytest.approx(float(by_xx), rel=1e-12)
    assert float(spring_second(x, r)) == pytest.approx(float(by_rr), rel=1e-12)
    assert float(mixed(x, r)) == pytest.approx(float(by_xr), rel=1e-12)


@pytest.mark.parametrize("x, r", [(-4.0, 0.6), (0.0, 0.6), (12.0, 0.6), (-7.0, 0.0), (5.0, 3.0)])
def test_equals_the_boundary_value_problem(x, r):
    # w'''' = x w'',  w(0) = 0,  r w''(0) = w'(0),  w'(1) = 0,  −w'''(1) = 1  →  K = 1/w(1)
    solution = solve_bvp(
        lambda y, w: np.array([w[1], w[2], w[3], x * w[2]]),
        lambda a, b: np.array([a[0], r * a[2] - a[1], b[1], b[3] + 1]),
        np.linspace(0, 1, 21),
        np.zeros((4, 21)),
        tol=1e-9,
        max_nodes=20000,
    )
    assert solution.success
    assert float(value(x, r)) == pytest.approx(1 / solution.y[0, -1], rel=1e-9)


@given(usual, usual, springs)
def test_tension_stiffens_and_a_softer_root_softens(a, b, r):
    low, high = min(a, b), max(a, b)
    assert float(value(high, r)) >= float(value(low, r))
    assert float(slope(a, r)) > 0
    assert float(spring_slope(a, r)) < 0


@given(springs, st.floats(1e-5, 1e-2))
def test_smooth_through_zero_force(r, x):
    for function, bound in ((value, 2.0), (slope, 0.1), (second, 0.1)):
        assert abs(float(function(x, r)) - float(function(-x, r))) <= bound * 2 * x
    taylor = float(value(0.0, r)) + x * float(slope(0.0, r)) + x**2 / 2 * float(second(0.0, r))
    assert float(value(x, r)) == pytest.approx(taylor, abs=0.01 * x**3 + 1e-14)


@given(finite, any_spring)
def test_finite_for_any_finite_input(x, r):
    for function in (value, slope, spring_slope, second, mixed, spring_second):
        assert np.isfinite(float(function(x, r)))


@given(st.floats(SMALLEST, LARGEST), any_spring)
def test_the_denominator_never_vanishes(x, r):
    assert float(stiffness_fraction(x, r)[1]) > 0


@pytest.mark.parametrize("x", (SMALLEST, LARGEST))
def test_held_outside_its_range(x):
    beyond = x + np.sign(x)
    assert float(value(beyond, 0.7)) == float(value(x, 0.7))
    assert float(slope(beyond, 0.7)) == 0.0
