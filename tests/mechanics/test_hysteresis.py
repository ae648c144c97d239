"""The polynomial hysteresis of Eq. 12 and the force of the PZT."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ident.mechanics import drive_force_coefficient, polynomial_strain


def _sine(amplitude: float = 8 / 17e-6, frequency: float = 317.0, n: int = 240, periods: int = 3):
    phase = 2 * np.pi * periods * np.arange(n) / n
    omega = 2 * np.pi * frequency
    return amplitude * np.sin(phase), amplitude * omega * np.cos(phase), omega


def test_each_term_of_the_polynomial():
    field, rate, omega = _sine()
    strain = polynomial_strain(field, rate, omega, 1e-10, 2e-22, 3e-22)
    cosine = rate / omega
    np.testing.assert_allclose(strain, 1e-10 * field - 2e-22 * field**3 + 3e-22 * cosine**3, rtol=1e-12)


def test_the_loop_term_acts_in_quadrature_at_the_first_and_third_harmonic():
    field, rate, omega = _sine(periods=1)
    spectrum = np.fft.rfft(np.asarray(polynomial_strain(field, rate, omega, 0.0, 0.0, 1e-18))) / len(field) * 2
    size = 1e-18 * (8 / 17e-6) ** 3
    assert spectrum[1] == pytest.approx(0.75 * size, rel=1e-9)  # cos³ = (3 cos + cos 3)/4
    assert spectrum[3] == pytest.approx(0.25 * size, rel=1e-9)
    assert np.abs(spectrum[[0, 2, 4]]).max() < 1e-9 * size


@given(st.floats(-1e-9, 1e-9), st.floats(-1e-21, 1e-21), st.floats(-1e-21, 1e-21))
def test_odd_under_a_half_period(linear, cubic, loop):
    field, rate, omega = _sine(periods=1)
    strain = np.asarray(polynomial_strain(field, rate, omega, linear, cubic, loop))
    np.testing.assert_allclose(np.roll(strain, 120), -strain, atol=1e-9 * np.abs(strain).max() + 1e-30)


def test_force_coefficient(device):
    # K_stage(0) times the free travel κ_p (l1² + l2²)/4 with the reference values of the nominal device
    curvature = 63e9 * 1e-3 * 17e-6 * (38.5e-6 - 19.0984367367e-6) / 8.94351494993e-7
    expected = 605.146382124 * curvature * (2.4e-3**2 + 2.8e-3**2) / 4
    assert float(drive_force_coefficient(device.section, device.beam)) == pytest.approx(expected, rel=1e-9)
