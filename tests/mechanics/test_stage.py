"""Two segments in series and four beams: symmetry, monotony, boundedness, derivatives."""

from __future__ import annotations

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ident.mechanics import segment_stiffness, series_stiffness, stage_stiffness

series = jax.jit(series_stiffness)
gradient = jax.jit(jax.grad(series_stiffness, argnums=(0, 1, 2, 3, 4, 5)))
hessian = jax.jit(jax.hessian(lambda x: series_stiffness(x[0], x[1], x[2], x[3], x[4], x[5])))

finite = st.floats(allow_nan=False, allow_infinity=False)
springs, scales = st.floats(0.0, 20.0), st.floats(1.0, 200.0)
unbuckled = st.floats(-2.4, 30.0)


def _parts(x1, x2, r1, r2, scale_1, scale_2):
    return float(scale_1 * segment_stiffness(x1, r1)), float(scale_2 * segment_stiffness(x2, r2))


@given(unbuckled, unbuckled, springs, springs, scales, scales)
def test_is_the_series_of_the_segments_and_symmetric(x1, x2, r1, r2, s1, s2):
    k1, k2 = _parts(x1, x2, r1, r2, s1, s2)
    assert float(series(x1, x2, r1, r2, s1, s2)) == pytest.approx(k1 * k2 / (k1 + k2), rel=1e-13)
    assert float(series(x2, x1, r2, r1, s2, s1)) == pytest.approx(k1 * k2 / (k1 + k2), rel=1e-13)


@given(unbuckled, unbuckled, unbuckled, springs, springs)
def test_rises_with_tension(x1, other, x2, r1, r2):
    low, high = min(x1, other), max(x1, other)
    assert float(series(high, x2, r1, r2, 60.0, 40.0)) >= float(series(low, x2, r1, r2, 60.0, 40.0)) * (1 - 1e-14)


@given(finite, finite, springs, springs, scales, scales)
def test_finite_and_bounded_for_any_force(x1, x2, r1, r2, s1, s2):
    k1, k2 = _parts(x1, x2, r1, r2, s1, s2)
    k = float(series(x1, x2, r1, r2, s1, s2))
    assert abs(k) <= max(k1, k2, 0.0) * (1 + 1e-12)
    assert np.all(np.isfinite(gradient(x1, x2, r1, r2, s1, s2)))
    assert np.all(np.isfinite(hessian(jnp.array([x1, x2, r1, r2, s1, s2]))))


@given(st.floats(-14.9, -2.5), st.floats(-14.9, 10.0))
def test_continuous_through_buckling(x1, x2):
    step = 1e-9
    jump = abs(float(series(x1 + step, x2, 0.6, 0.5, 60.0, 40.0)) - float(series(x1, x2, 0.6, 0.5, 60.0, 40.0)))
    # Slopes stay below 4 |K_x| scale on the regular side and |K_x| scale beyond it.
    assert jump <= 1e-4


@pytest.mark.parametrize(
    "point",
    [
        (0.0, 0.0, 0.58, 0.43, 64.7, 40.7),
        (-2.0, 3.0, 0.58, 0.43, 64.7, 40.7),
        (1.0, 1.0, 0.5, 0.5, 50.0, 50.0),  # equal segments: a tie
        (-6.5, 9.0, 0.58, 0.43, 64.7, 40.7),  # segment 1 buckled, beam regular
        (-6.5, 0.0, 0.58, 0.43, 64.7, 10.0),  # beyond, held at −max
    ],
)
def test_derivatives_equal_finite_differences(point):
    point = np.array(point)
    exact = np.array(gradient(*point))
    curvature = np.array(hessian(jnp.array(point)))
    for i in range(6):
        step = 1e-5 * max(1.0, abs(point[i]))
        up, down = point.copy(), point.copy()
        up[i] += step
        down[i] -= step
        slope = (float(series(*up)) - float(series(*down))) / (2 * step)
        row = (np.array(gradient(*up)) - np.array(gradient(*down))) / (2 * step)
        assert exact[i] == pytest.approx(slope, rel=1e-6, abs=1e-7)
        np.testing.assert_allclose(curvature[i], row, rtol=1e-5, atol=1e-6)


def test_reverse_and_forward_mode_agree_under_vmap_and_scan(device):
    beam = device.beam

    def pushed(parameters):
        def step(total, z):
            return total + stage_stiffness(beam, parameters[0] * z, parameters[1] * z**2), None

        return jax.lax.scan(step, 0.0, jnp.linspace(-1.0, 1.0, 7))[0]

    points = jnp.array([[0.1, -0.2], [0.0, 0.0], [0.4, 0.3]])
    forward = jax.jit(jax.vmap(jax.jacfwd(pushed)))(points)
    reverse = jax.jit(jax.vmap(jax.grad(pushed)))(points)
    np.testing.assert_allclose(forward, reverse, rtol=1e-12, atol=1e-9)
    second = jax.jit(jax.vmap(jax.hessian(pushed)))(points)
    np.testing.assert_allclose(second, np.swapaxes(second, 1, 2), rtol=1e-10, atol=1e-10)
