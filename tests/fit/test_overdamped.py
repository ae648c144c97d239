"""A decay that is over within a sample: no record tells its rate, and no solver follows it."""

from __future__ import annotations

import numpy as np
import pytest

from ident.campaign.campaign import Campaign
from ident.campaign.device import Oscillator
from ident.campaign.record import Channel, NoiseFloor, Trace
from ident.fit import fit
from ident.fit.linear.forms import FORMS
from ident.fit.linear.guess import stretch_of
from ident.fit.linear.start_model import start_model

RATE = 20.0


def slow_record(seed: int) -> Trace:
    """Steps through a lag of 0.8 s, and nothing else."""
    rng, t, one = np.random.default_rng(seed), np.arange(1200) / RATE, Channel("m", 1.0)
    drive = np.repeat(rng.uniform(0, 10, 10), 120)
    z = np.zeros(1200)
    for k in range(1, 1200):
        z[k] = drive[k] + (z[k - 1] - drive[k]) * np.exp(-1 / (RATE * 0.8))
    return Trace("a.csv", t, drive, z + 0.01 * rng.normal(size=1200), one, one, NoiseFloor(0.01), "unknown")


@pytest.mark.parametrize(("frequency", "quality"), [(48.0, 0.0103), (30.0, 0.00625), (2.0, 0.2), (0.1, 0.3)])
def test_the_slow_decay_is_kept_and_the_fast_one_stays_in_sight(frequency: float, quality: float):
    def rates(f: float, q: float) -> np.ndarray:
        return np.sort(-np.roots([1.0, 2 * np.pi * f / q, (2 * np.pi * f) ** 2]).real)

    told = FORMS["overdamped"].told(np.array([frequency, quality]), [stretch_of(slow_record(1))])
    before, after = rates(frequency, quality), rates(*told)
    assert after[0] == pytest.approx(before[0], rel=1e-6)
    assert after[1] == pytest.approx(min(before[1], 3.0 * RATE), rel=1e-6)


def test_a_stage_that_lags_is_fitted_to_the_noise_and_not_beyond_all_bounds():
    campaign = Campaign("slow", (slow_record(1), slow_record(2)), Oscillator())
    model = start_model(campaign)
    assert model.form == "overdamped"
    found = fit(model, campaign)
    assert found.fitted.error_over_signal < 0.03
