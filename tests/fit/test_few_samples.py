"""A linear device under noise of few samples to a period is that and nothing else: no drive that is held, no mode.

The drive is a sum of sines and the answer of each is known: neither has been drawn between samples by anybody.
"""

from __future__ import annotations

import numpy as np
import pytest

from ident.campaign.campaign import Campaign
from ident.campaign.device import Oscillator
from ident.campaign.record import Channel, NoiseFloor, Trace
from ident.fit import fit
from ident.fit.linear.start_model import start_model, with_drives

STEP, SAMPLES, NOISE = 5e-4, 2000, 0.004  # of the response
OMEGA, QUALITY, GAIN = 2 * np.pi * 211.0, 0.78, 1.0e6
ONE = Channel("V", 1.0)


def record(seed: int) -> Trace:
    """Noise up to 0.43 of the sampling rate, of 80 lines of equal size, in the steady state."""
    rng = np.random.default_rng(seed)
    time, omega = STEP * np.arange(SAMPLES), 2 * np.pi * rng.uniform(20, 0.43 / STEP, 80)
    lines = np.exp(1j * (np.outer(time, omega) + rng.uniform(0, 2 * np.pi, 80)))
    answer = np.real(lines @ (GAIN / (OMEGA**2 - omega**2 + 1j * omega * OMEGA / QUALITY)))
    sigma = NOISE * float(np.std(answer))
    noisy = answer + sigma * rng.standard_normal(SAMPLES)
    return Trace(
        f"{seed}.csv", time, np.real(lines).sum(axis=1), noisy, ONE, ONE, NoiseFloor(sigma, method="given"), "unknown"
    )


@pytest.mark.parametrize("seed", [1, 11])
def test_a_linear_device_under_broadband_noise_is_met_to_the_noise(seed: int) -> None:
    campaign = with_drives(Campaign("mirror", (record(seed), record(seed + 1), record(seed + 2)), Oscillator()))
    assert all(trace.edge is None for trace in campaign.traces)
    model = start_model(campaign)
    assert model.form == "oscillator" and not model.effects
    found = fit(model, campaign)
    assert found.fitted.error_over_noise < 1.03
    assert found.value("oscillator.quality") == pytest.approx(QUALITY, rel=2e-3)
