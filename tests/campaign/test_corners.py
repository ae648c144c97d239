"""Drives with corners between their samples: triangles, trapezoids, ramped steps; and smooth ones, that have none."""

from __future__ import annotations

import numpy as np
import pytest

from ident.campaign import half_step_drive
from ident.campaign.corners import Corners, broken_spline, corners
from tests.campaign.test_drive_signal import STEP, record

N = 1200
K = np.arange(N)


def straight(points: list[tuple[float, float]], at: np.ndarray) -> np.ndarray:
    """A drive of straight lines from corner to corner."""
    times, volts = zip(*points, strict=True)
    return np.interp(at, times, volts)


TRAPEZOID = [(0, 0.0), (40, 0.0), (46, 3.0), (200, 3.0), (209, -1.5), (500, -1.5), (507, 2.0), (1000, -2.0), (1200, 0)]


def smooth(seed: int) -> np.ndarray:
    """A sine, a multisine, a chirp or noise of a narrow band, with noise of the column and steps of its converter."""
    rng = np.random.default_rng(seed)
    samples = rng.uniform(6.0, 60.0)  # of its fastest period
    match seed % 4:
        case 0:
            drive = np.sin(2 * np.pi * K / samples)
        case 1:
            drive = (
                sum(np.sin(2 * np.pi * rng.uniform(0.02, 1) / samples * K + rng.uniform(0, 6)) for _ in range(40)) / 6
            )
        case 2:
            drive = np.sin(np.pi * K**2 / N / samples)
        case _:
            spectrum = np.fft.rfft(rng.normal(size=N))
            spectrum[int(N / samples) :] = 0.0
            drive = np.fft.irfft(spectrum, N)
            drive /= np.std(drive)
    drive = drive + rng.choice([0.0, 1e-5, 1e-3, 1e-2]) * rng.normal(size=N)
    return np.round(drive, rng.choice([2, 3, 4])) if rng.uniform() < 0.5 else drive


def test_smooth_drives_have_no_corners() -> None:
    assert [seed for seed in range(400) if corners(smooth(seed))] == []


@pytest.mark.parametrize("bits", [None, 12, 16])
@pytest.mark.parametrize("noise", [0.0, 1e-3])
def test_a_drive_that_rests_before_it_moves_has_none(noise: float, bits: int | None) -> None:
    k = np.arange(20_000)
    for samples in (6.3, 17.0, 60.0, 300.0):
        eased = np.clip((k - 16_000) / 1500, 0, 1) ** 2 * np.sin(2 * np.pi * (k - 16_000) / samples)
        drive = eased + noise * np.random.default_rng(3).normal(size=len(k))
        assert not corners(np.round(drive * 2**bits / 2) * 2 / 2**bits if bits else drive)


@pytest.mark.parametrize("noise", [0.0, 3e-3])
def test_corners_are_where_the_lines_meet(noise: float) -> None:
    drive = straight(TRAPEZOID, K) + noise * np.random.default_rng(1).normal(size=N)
    seen = {40, 46, 200, 209, 500, 507, 1000} - ({1000} if noise else set())  # a bend of 13 mV
    places = sorted(seen)
    assert corners(drive).places == pytest.approx(places, abs=0.05)
    assert corners(drive).of(drive) == pytest.approx(straight(TRAPEZOID, np.array(places)), abs=0.01)


def test_between_its_corners_a_drive_is_what_it_was() -> None:
    volts, slope = half_step_drive(record(straight(TRAPEZOID, K), None), substeps=2)
    slope = slope * STEP
    at = np.arange(4 * (N - 1) + 1) / 4
    np.testing.assert_allclose(volts, straight(TRAPEZOID, at), atol=1e-12)
    assert slope[4 * 43] == pytest.approx(0.5) and slope[4 * 40] == pytest.approx(0.25)  # half of it at a corner
    np.testing.assert_allclose(slope[4 * 47 : 4 * 199], 0.0, atol=1e-12)


@pytest.mark.parametrize("noise", [0.0, 1e-3])
def test_a_corner_between_two_samples_is_where_the_lines_meet(noise: float) -> None:
    triangle = lambda at: 5 * (2 * np.abs((at / 97.3) % 1 - 0.5) * 2 - 1)
    drive = triangle(K) + noise * np.random.default_rng(2).normal(size=N)
    volts, slope = half_step_drive(record(drive, period=97.3))
    error = volts - triangle(np.arange(2 * (N - 1) + 1) / 2)
    assert np.max(np.abs(error)) < max(1e-9, 10 * noise) and np.std(error) <= 2 * noise + 1e-9
    steep = np.abs(slope) * STEP
    assert np.max(steep) < 20 / 97.3 + max(1e-9, 10 * noise) and np.mean(steep) > 0.98 * 20 / 97.3


def test_short_ramps_are_lines_and_parabolas() -> None:
    """Pieces of two and three points, whose cubic has no other points to go through."""
    found = Corners(np.array([10, 11, 13]), np.zeros(3))
    drive = np.concatenate([np.zeros(11), [3.0], [4.0, 6.0], np.full(8, 6.0)])
    curve = broken_spline(drive, found)
    assert curve(np.array([5.0, 10.5, 12.0, 17.5])) == pytest.approx([0.0, 1.5, 4.0, 6.0])
    assert curve(11 + np.linspace(0, 2, 5)) == pytest.approx([3.0, 3.375, 4.0, 4.875, 6.0])


def test_a_play_rests_where_a_ramp_turns() -> None:
    """A ramp into a plateau that droops: with the mean of both slopes at the corner the play was taken to overshoot."""
    droops = [(0, 0.0), (40, 0.0), (44, 4.0), (200, 3.9), (1199, 3.9)]
    volts, slope = half_step_drive(record(straight(droops, K), None))
    assert slope[2 * 44] == 0.0 and np.max(volts) == pytest.approx(4.0)


def test_noise_of_the_drive_is_not_amplified_between_corners() -> None:
    ramp = straight([(0, 0.0), (100, 0.0), (106, 3.0), (1100, 3.0), (1199, 3.0)], K)
    clean = ramp + np.where(K > 300, np.sin(2 * np.pi * np.clip(K - 300, 0, None) / 300), 0.0)
    drive = clean + 2e-3 * np.random.default_rng(4).normal(size=N)
    assert corners(drive)
    slope = half_step_drive(record(drive, None))[1][2 * 330 : 2 * 1150] * STEP
    exact = 2 * np.pi / 300 * np.cos(2 * np.pi * (np.arange(2 * 330, 2 * 1150) / 2 - 300) / 300)
    assert np.std(slope - exact) < 0.05 * np.std(exact)
