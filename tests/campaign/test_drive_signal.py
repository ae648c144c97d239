"""The drive between its samples, its rate, its frequency and its period."""

from __future__ import annotations

import numpy as np
import pytest

from ident.campaign import Channel, NoiseFloor, Trace, drive_frequency, half_step_drive
from ident.campaign.period import find_period

STEP = 2e-5


def record(drive: np.ndarray, period: float | None) -> Trace:
    time = STEP * np.arange(len(drive))
    return Trace("a", time, drive, drive, Channel("V", 1.0), Channel("m", 1.0), NoiseFloor(1.0), period=period)


def _sine(per_period: float, n: int = 2000) -> np.ndarray:
    return 5 * np.sin(2 * np.pi * np.arange(n) / per_period + 0.3)


@pytest.mark.parametrize("per_period", [20, 40, 23.37, 61.803, 7.3, 100])
@pytest.mark.parametrize("noise", [0.0, 1e-3, 1e-2])
def test_the_period_of_a_sine(per_period, noise):
    drive = _sine(per_period) + 5 * noise * np.random.default_rng(0).standard_normal(2000)
    assert find_period(drive) == pytest.approx(per_period, rel=1e-4)


def test_what_has_no_period():
    rng = np.random.default_rng(1)
    k = np.arange(2000)
    assert find_period(rng.standard_normal(2000)) is None
    assert find_period(np.ones(2000)) is None
    assert find_period(np.sin(2 * np.pi * (0.01 * k + 1e-5 * k**2))) is None
    assert find_period(np.where(k < 400, 0, np.sin(2 * np.pi * k / 40))) is None
    assert find_period(np.sin(2 * np.pi * k / 40) * (1 + k / 2000)) is None


def test_the_period_of_other_waves():
    rng = np.random.default_rng(2)
    one = np.convolve(rng.standard_normal(500), np.ones(20), "same")
    assert find_period(np.tile(one, 4)) == 500
    assert find_period(np.abs((np.arange(2000) / 50) % 2 - 1)) == 100


@pytest.mark.parametrize("per_period", [40, 33.7])
@pytest.mark.parametrize("substeps", [1, 2, 4])
def test_a_clean_sine_is_not_distorted(per_period, substeps):
    drive = _sine(per_period)
    points = np.arange(2 * 1999 * substeps + 1) / (2 * substeps)
    rate = 2 * np.pi / per_period
    exact, slope = 5 * np.sin(rate * points + 0.3), 5 * rate * np.cos(rate * points + 0.3) / STEP
    inner = slice(12 * substeps, -12 * substeps)
    for period in (find_period(drive), None):
        voltage, change = half_step_drive(record(drive, period), substeps)
        assert voltage.shape == change.shape == points.shape
        np.testing.assert_array_equal(voltage[:: 2 * substeps], drive)
        size = 5 * rate / STEP
        assert np.max(np.abs(voltage - exact)[inner]) < 1e-4 * 5
        assert np.max(np.abs(change - slope)[inner]) < 1e-4 * size
        assert np.sqrt(np.mean((change - slope) ** 2)) < 1e-4 * size


def test_noise_on_the_drive_is_not_amplified():
    rng = np.random.default_rng(3)
    drive = _sine(40) + 0.05 * rng.standard_normal(2000)
    points = np.arange(2 * 1999 + 1) / 2
    rate = 2 * np.pi / 40
    slope = 5 * rate * np.cos(rate * points + 0.3) / STEP
    size = np.sqrt(np.mean(slope**2))
    raw = np.sqrt(np.mean((np.gradient(drive, STEP) - slope[::2]) ** 2)) / size
    for period, allowed in ((40.0, 2e-3), (None, 0.03)):
        _, change = half_step_drive(record(drive, period))
        error = np.sqrt(np.mean((change - slope) ** 2)) / size
        assert error < allowed < raw


def test_a_long_record_is_no_harder():
    rng = np.random.default_rng(4)
    drive = np.convolve(rng.standard_normal(65_000), np.hanning(25), "same")
    voltage, change = half_step_drive(record(drive, None))
    assert np.all(np.isfinite(voltage)) and np.all(np.isfinite(change))


@pytest.mark.parametrize("per_period", [40, 23.37])
def test_the_drive_frequency_of_a_sine_is_exact(per_period):
    drive = _sine(per_period) + 2.0
    expected = 2 * np.pi / (per_period * STEP)
    assert drive_frequency(record(drive, find_period(drive))) == pytest.approx(expected, rel=1e-9)
    assert drive_frequency(record(drive, None)) == pytest.approx(expected, rel=5e-3)


def test_a_constant_drive_has_frequency_zero_and_no_slope():
    still = record(np.full(200, 3.0), None)
    assert drive_frequency(still) == 0.0
    voltage, change = half_step_drive(still, 2)
    np.testing.assert_allclose(voltage, 3.0)
    assert not change.any()


def test_a_triangle_has_its_own_frequency():
    """rms(V̇)/rms(V) of a triangle of period T is (4A/T)/(A/√3)."""
    drive = np.abs((np.arange(4000) / 100) % 2 - 1)
    expected = 4 / (200 * STEP) / (1 / np.sqrt(3))
    assert drive_frequency(record(drive, 200.0)) == pytest.approx(expected, rel=0.01)
