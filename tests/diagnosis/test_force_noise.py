"""Noise of the force is told from physics: by its colour, which is that of the device."""

from __future__ import annotations

import numpy as np
import pytest
from scipy import signal

from ident.campaign.campaign import Campaign
from ident.campaign.device import Oscillator
from ident.campaign.record import Channel, NoiseFloor, Trace
from ident.diagnosis.evidence.enough import adequate, noise_of_force
from ident.diagnosis.evidence.force_noise import _factor, force_noise
from ident.diagnosis.linearised.regression import prepare
from ident.diagnosis.ranking.score import score, significant
from ident.effects.registry import built_in
from ident.fit import fit
from ident.fit.linear.stretches import oscillator_filter
from ident.model import Model

STEP, F0, Q, GAIN = 5e-5, 480.0, 120.0, 1e6


def record(name: str, drive: np.ndarray, push: float, rng: np.random.Generator, bent: float = 0.0) -> Trace:
    """A linear device that is pushed by the drive and by noise of `push` times its rms; `bent`: a sensor's second
    order."""
    noise = push * np.std(drive) * rng.normal(size=len(drive))
    z = signal.lfilter(*oscillator_filter(F0, Q, STEP), GAIN * (drive + noise))
    z, sigma, volts = z + bent * z**2 / np.max(np.abs(z)), 0.002 * float(np.std(z)), Channel("V", 1.0)
    z = z + sigma * rng.normal(size=len(z))
    return Trace(name, STEP * np.arange(len(z)), drive, z, volts, volts, NoiseFloor(sigma, relative_error=0.02), "rest")


def campaign(push: float, bent: float = 0.0) -> Campaign:
    rng, t = np.random.default_rng(7), STEP * np.arange(2000)
    lines = np.column_stack([rng.uniform(200, 800, 12), rng.uniform(0, 6, 12)])
    tones = sum(np.sin(2 * np.pi * hz * t + turn) for hz, turn in lines)
    drives = [7 * np.sin(2 * np.pi * 317 * t), 3 * np.sin(2 * np.pi * 478 * t), 2 * tones * np.clip(15 * t, 0, 1)]
    traces = tuple(record(f"{k}.csv", drive, push, rng, bent) for k, drive in enumerate(drives))
    return Campaign("pushed", traces, Oscillator())


def test_noise_of_the_force_is_no_physics():
    regression = prepare(fit(Model(Oscillator()), campaign(push=0.004)))
    assert regression.chi2 > 1.3 * regression.n  # above the floors
    assert not significant(score(regression, built_in()))
    noise = noise_of_force(regression)
    assert noise is not None and adequate(regression)
    assert noise.share == pytest.approx(0.004, rel=0.3)


def test_physics_is_no_noise_of_the_force():
    regression = prepare(fit(Model(Oscillator()), campaign(push=0.004, bent=0.02)))
    assert significant(score(regression, built_in()))[0].name == "sensor-nonlinearity"
    assert noise_of_force(regression) is None and not adequate(regression)


def test_where_the_sensor_alone_is_noisy_none_of_the_force_is_seen():
    regression = prepare(fit(Model(Oscillator()), campaign(push=0.0)))
    assert noise_of_force(regression) is None and adequate(regression)
    found = [force_noise(regression, k, regression.residual[own]) for k, own in enumerate(regression.places)]
    assert all(one is None or one.ratio < 0.05 for one in found)


@pytest.mark.parametrize("ratio", [1e-3, 1.0, 1e4])
def test_the_factor_has_the_spectrum_of_both_noises(ratio):
    b, a = oscillator_filter(F0, Q, STEP)
    b = b / np.sqrt(np.mean(np.abs(signal.freqz(b, a, 4096)[1]) ** 2))
    c = _factor(a, b, ratio)
    _, both = signal.freqz(a, [1.0], 2048)
    _, pushed = signal.freqz(b, [1.0], 2048)
    _, factor = signal.freqz(c, [1.0], 2048)
    wanted = np.abs(both) ** 2 + ratio * np.abs(pushed) ** 2
    np.testing.assert_allclose(np.abs(factor) ** 2 / wanted, np.abs(factor[0]) ** 2 / wanted[0], rtol=1e-6)
    assert np.all(np.abs(np.roots(c)) < 1)
