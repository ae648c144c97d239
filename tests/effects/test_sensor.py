"""Laws of the sensor against independent solutions."""

from __future__ import annotations

import numpy as np
import pytest

from tests.effects.harness import DURATION, TIME, Physics, assert_agrees, make, measured, voltage, voltage_rate

EXACT = 1e-6


def test_offset():
    assert_agrees(make("sensor-offset", offset=3e-7), Physics(sensor=lambda t, z, v, h: 3e-7), EXACT)


def test_crosstalk():
    physics = Physics(sensor=lambda t, z, v, h: 2e-8 * voltage(t) + 1e-12 * voltage_rate(t))
    assert_agrees(make("sensor-crosstalk", leak=2e-8, capacitive=1e-12), physics, EXACT)


def test_drift_that_dies_out_and_drift_that_does_not():
    dying = Physics(sensor=lambda t, z, v, h: 5e-7 * (1 - np.exp(-t / 4e-3)))
    assert_agrees(make("sensor-drift", rate0=5e-7 / 4e-3, time=4e-3), dying, EXACT)
    steady = Physics(sensor=lambda t, z, v, h: 5e-7 * t / DURATION)
    assert_agrees(make("sensor-drift", rate0=5e-7 / DURATION, time=1e6 * DURATION), steady, 1e-5)


def test_polynomial_characteristic():
    physics = Physics(sensor=lambda t, z, v, h: 4e3 * z**2 - 1e9 * z**3)
    assert_agrees(make("sensor-nonlinearity", quadratic=4e3, cubic=1e9, saturation=1e-9), physics, 1e-5)


@pytest.mark.parametrize("full_scale", [6e-6, 12e-6])
def test_saturating_characteristic_follows_the_hyperbolic_tangent(full_scale):
    physics = Physics(sensor=lambda t, z, v, h: full_scale * np.tanh(z / full_scale) - z)
    effect = make("sensor-nonlinearity", cubic=1 / (3 * full_scale**2), saturation=1.2)
    assert_agrees(effect, physics, 2e-2)


def test_a_beam_of_light_on_a_flat_scale_is_a_tangent():
    far = 12e-6  # at half the angle
    physics = Physics(sensor=lambda t, z, v, h: far * np.tan(z / far) - z)
    effect = make("sensor-nonlinearity", cubic=-1 / (3 * far**2), saturation=1e-9, quintic=2 / (15 * far**4))
    assert_agrees(effect, physics, 1e-2)


@pytest.mark.parametrize(
    ("time", "accuracy"),
    [(2e-6, 2e-3), (1e-5, 6e-3), (3e-5, 1e-2), (1e-4, 4e-3), (1e-3, 2e-5)],
)
def test_sensor_lag_is_an_exact_low_pass_within_its_stated_accuracy(time, accuracy):
    physics = Physics(rates=lambda t, z, v, h: ((z - h[0]) / time,), sensor=lambda t, z, v, h: h[0] - z, start=(0.0,))
    assert_agrees(make("sensor-lag", time=time, shortest=6e-5), physics, accuracy)


@pytest.mark.parametrize("corner", [20.0, 2e3])
def test_ac_coupling_is_a_high_pass(corner):
    physics = Physics(rates=lambda t, z, v, h: (corner * (z - h[0]),), sensor=lambda t, z, v, h: -h[0], start=(0.0,))
    assert_agrees(make("ac-coupling", corner=corner), physics, 1e-5)


def test_on_a_linear_device_a_lag_of_the_sensor_is_a_lag_of_the_drive():
    # Linear blocks commute: no record of such a device can tell the two apart.
    sensor = measured(make("sensor-lag", time=4e-5, shortest=6e-5), substeps=4)
    drive = measured(make("drive-lag", time=4e-5), substeps=4)
    late = np.max(np.abs(drive - measured(substeps=4)))
    assert np.max(np.abs(sensor - drive)) < 0.01 * late  # what the sensor's is off by
    assert len(sensor) == len(TIME)
