"""The stiffness passes through zero where a segment buckles."""

from __future__ import annotations

import jax
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ident.mechanics import restoring, restoring_stiffness, segment_stiffness
from tests.mechanics.buckling import critical_reduced_force

critical = jax.jit(critical_reduced_force)


@given(st.floats(0.0, 1e6))
def test_the_stiffness_is_zero_there_and_positive_above(r):
    x = float(critical(r))
    assert -(np.pi**2) * (1 + 1e-12) <= x <= -(np.pi**2) / 4 * (1 - 1e-12)
    assert float(segment_stiffness(x, r)) == pytest.approx(0.0, abs=1e-12)
    for above in np.linspace(x, 1.0, 20)[1:]:
        assert float(segment_stiffness(above, r)) > 0


@pytest.mark.parametrize("r, x", [(0.0, -(np.pi**2)), (1e308, -(np.pi**2) / 4)])
def test_limits_of_the_root_spring(r, x):
    assert float(critical(r)) == pytest.approx(x, rel=1e-12)
    assert np.isfinite(float(jax.grad(critical_reduced_force)(r)))


def test_differentiable():
    r, step = 0.6, 1e-5
    slope = (float(critical(r + step)) - float(critical(r - step))) / (2 * step)
    assert float(jax.grad(critical_reduced_force)(r)) == pytest.approx(slope, rel=1e-8)


@pytest.mark.parametrize("multiple, fails", [(1.0, False), (7.0, False), (8.2, False), (8.3, True), (20.0, True)])
def test_the_axial_force_closure_fails_at_eight_times_the_stress(device, multiple, fails):
    sigma12, sigma23, sigma2 = (multiple * s for s in device.stresses)
    constants = restoring(
        device.section, device.length_1, device.length_2, sigma12=sigma12, sigma23=sigma23, sigma2=sigma2
    )
    z = np.linspace(-400e-6, 100e-6, 2001)
    stiffness = np.asarray(restoring_stiffness(constants, z))
    assert np.all(np.isfinite(stiffness))
    assert bool(stiffness.min() < 0) is fails
