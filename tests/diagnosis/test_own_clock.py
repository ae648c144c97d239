"""A response that was taken by another clock than its drive is told, and read by the clock of the drive."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.signal import lsim

from ident.campaign.record import Channel, NoiseFloor, Trace
from ident.diagnosis.faulty.nuisance import OWN_CLOCK, nuisances

STEP, N, SIGMA, RATIO = 1 / 80.0, 4000, 0.002, 1.0008
ONE = Channel("V", 1.0)
TONES = 2 * np.pi * np.arange(1.0, 9.0, 0.37)
PHASES = np.random.default_rng(2).uniform(0, 2 * np.pi, len(TONES))


def drive(t: np.ndarray) -> np.ndarray:
    return np.sum([np.sin(w * t + p) for w, p in zip(TONES, PHASES, strict=True)], axis=0) / 5


def answer(t: np.ndarray, held: bool = False) -> np.ndarray:
    """Of an oscillator of 5.2 Hz, Q = 20, at any times within the record."""
    fine = STEP / 10 * np.arange(10 * N + 100)
    pushed = drive(STEP * np.floor(fine / STEP + 1e-9)) if held else drive(fine)
    w = 2 * np.pi * 5.2
    return np.interp(t, fine, lsim(([w * w], [1.0, w / 20, w * w]), pushed, fine, interp=not held)[1])


def record(ratio: float, held: bool = False) -> Trace:
    t, rng = STEP * np.arange(N), np.random.default_rng(4)
    read = answer(ratio * t, held) + SIGMA * rng.standard_normal(N)
    return Trace("a", t, drive(t), read, ONE, ONE, NoiseFloor(SIGMA), "unknown", edge=0.0 if held else None)


@pytest.mark.parametrize("held", [False, True])
@pytest.mark.parametrize("ratio", [RATIO, 1 / RATIO])
def test_its_ratio_is_found_and_the_record_then_agrees(ratio: float, held: bool) -> None:
    one, t = record(ratio, held), STEP * np.arange(N)
    best = nuisances(one, answer(t, held))[0]
    assert (best.kind, best.unit) == ("time-scale", OWN_CLOCK)
    assert best.size == pytest.approx(ratio, abs=2e-6) and best.error < 1.3
    read = best.corrected
    assert read is not None
    left = (read.response - answer(read.time, held))[read.counted] / SIGMA
    assert np.sqrt(np.mean(left**2)) < 1.3
    if not held:
        np.testing.assert_allclose(read.drive[read.counted], drive(read.time)[read.counted], atol=1e-3)


def test_of_one_clock_nothing_is_said() -> None:
    found = {(one.kind, one.unit): one for one in nuisances(record(1.0), answer(STEP * np.arange(N)))}
    assert found["time-scale", OWN_CLOCK].size == pytest.approx(1.0, abs=1e-6)


def test_what_was_masked_stays_so() -> None:
    masked = np.zeros(N, bool)
    masked[700:720] = True
    for held in (False, True):
        broken = record(RATIO, held)
        broken = replace(broken, masked=masked, response=np.where(masked, 50.0, broken.response))
        (told,) = [one for one in nuisances(broken, answer(STEP * np.arange(N), held)) if one.unit == OWN_CLOCK]
        assert told.corrected is not None and np.max(np.abs(told.corrected.response[told.corrected.counted])) < 20
