"""Mains hum is a nuisance only where a record can tell it from what a device does."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from ident.campaign.noise.autoregression import predictors, variance_of
from ident.campaign.record import Channel, NoiseFloor, Trace
from ident.diagnosis.linearised.whiten import whiten, whitening_of

N = 2000


def trace(step: float, period: float | None = None) -> Trace:
    one = Channel("m", 1.0)
    return Trace("a.csv", step * np.arange(N), np.zeros(N), np.zeros(N), one, one, NoiseFloor(1.0), period=period)


def left(record: Trace, misfit: np.ndarray) -> float:
    """The share of a misfit's power that is no nuisance."""
    seen = whiten(whitening_of(record, None), misfit[None])[0]
    return float(seen @ seen) / float(misfit @ misfit)


@pytest.mark.parametrize("length", [1e-4, 5e-3, 0.02, 1.0, 100.0])
def test_an_offset_is_seen_in_a_record_of_any_length(length: float):
    """A device of some 10 kHz is recorded for milliseconds: there a quarter period of hum is an offset that bends. With
    it every offset was taken out, and a walk stopped at seven noise floors with nothing left to explain."""
    record = trace(length / N)
    assert left(record, np.ones(N)) > 0.9
    assert left(record, np.linspace(-1, 1, N)) > 0.8


def test_hum_is_taken_out_where_it_is_seen():
    record = trace(5e-4)
    hum = np.cos(2 * np.pi * 50 * record.time + 0.3) + 2 * np.sin(2 * np.pi * 60 * record.time)
    assert left(record, hum) < 1e-9


def test_hum_is_taken_out_where_its_floor_heard_it():
    """In 10 s a line 0.05 Hz beside it is another one."""
    record = trace(5e-3)
    hum = np.cos(2 * np.pi * 50.05 * record.time + 0.3)
    assert left(record, hum) > 0.5
    assert left(replace(record, noise=NoiseFloor(1.0, heard=((50.0, 50.05),))), hum) < 1e-9


def test_the_answer_to_a_drive_near_the_mains_is_no_hum():
    record = trace(5e-4, period=1 / (50.0 * 5e-4))
    assert left(record, np.cos(2 * np.pi * 50 * record.time)) > 0.99
    assert left(record, np.cos(2 * np.pi * 60 * record.time)) < 1e-9


def test_two_periods_of_hum_are_no_misfit():
    """Records of a platform last 40 ms: hum left in them made "not in the library" of a linear one."""
    record = trace(0.04 / N)
    assert left(record, np.sin(2 * np.pi * 50 * record.time + 0.4)) < 1e-6
    assert left(record, np.ones(N)) > 0.9


@pytest.mark.parametrize("poles", [[0.6], [0.999], [0.999 * np.exp(0.003j), 0.999 * np.exp(-0.003j)], [0.9, -0.5, 0.3]])
def test_noise_of_any_colour_is_white_from_its_first_sample_on(poles):
    """Predicted from zeros, the first samples of slow noise stood out a hundred times; and the filter's scale, summed
    over 20,000 samples, was some per cent off. The covariance is exact, R_kl = σ² Σ_j h_j h_{j+|k−l|}, summed to its
    end."""
    ar = -np.real(np.poly(poles))[1:]
    response = np.zeros(200_000)
    response[0] = 1.0
    for k in range(1, len(response)):
        before = response[max(0, k - len(ar)) : k][::-1]
        response[k] = ar[: len(before)] @ before
    covariance = np.array([response[: len(response) - k] @ response[k:] for k in range(80)])
    assert variance_of(ar, 1.0) == pytest.approx(covariance[0], rel=1e-6)
    lags = np.abs(np.subtract.outer(range(80), range(80)))
    for weights, variance in predictors(ar):
        k = len(weights)
        explained = np.linalg.solve(covariance[lags[:k, :k]], covariance[1 : k + 1])
        np.testing.assert_allclose(weights, explained, rtol=1e-5, atol=1e-8)
        assert variance == pytest.approx(covariance[0] - explained @ covariance[1 : k + 1], rel=1e-4)
    one = Channel("m", 1.0)
    floor = NoiseFloor(2.0, tuple(ar))
    record = Trace("a.csv", 1e-5 * np.arange(80), np.zeros(80), np.zeros(80), one, one, floor)
    seen = whiten(whitening_of(record, None)._replace(basis=np.zeros((80, 0))), np.eye(80))
    noise = 4.0 * covariance[lags] / covariance[0]
    np.testing.assert_allclose(seen.T @ noise @ seen, np.eye(80), atol=1e-4)
