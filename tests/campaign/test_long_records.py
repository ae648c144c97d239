"""Records that are sampled far more often than they need, and records that lost samples on the way."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from scipy.signal import cont2discrete, lfilter

import ident
from ident.campaign.noise.floor import noise_floor
from ident.campaign.quality.suspect import suspects_by_data
from ident.report.words.data import remarks

FREQUENCY, QUALITY, RATE, NOISE = 480.0, 30.0, 400_000.0, 2e-8


@pytest.fixture(scope="module")
def table() -> dict[str, np.ndarray]:
    """A linear oscillator under a sine, solved exactly between samples: 830 samples a period."""
    t = np.arange(160_000) / RATE
    drive = np.sin(2 * np.pi * 500.0 * t)
    w = 2 * np.pi * FREQUENCY
    exact: Any = cont2discrete(([1e-6 * w * w], [1.0, w / QUALITY, w * w]), 1 / RATE, method="foh")
    response = np.asarray(lfilter(np.ravel(exact[0]), exact[1], drive))
    response += NOISE * np.random.default_rng(8).standard_normal(len(t))
    return {"time (s)": t, "drive (V)": drive, "displacement (m)": response}


DEVICE = {"kind": "oscillator", "output": "m"}


def test_an_oversampled_record_is_thinned_with_an_honest_floor_and_fitted(table):
    campaign = ident.read_campaign(table, device=DEVICE, start="rest", skip=2000)
    (record,) = campaign.traces
    every = round(record.step * RATE)
    assert 16 <= every <= 20 and len(record.time) == -(-160_000 // every)
    assert any("every" in note and "160000 samples" in note for note in campaign.notes)
    # White noise through a filter that keeps one part in `every` of its band.
    assert record.noise.sigma == pytest.approx(NOISE / np.sqrt(every), rel=0.15)
    assert record.skip == -(-2000 // every)
    found = ident.fit(campaign)
    assert 0.95 < found.fitted.error_over_noise < 1.05
    for name, truth in (("frequency", FREQUENCY), ("quality", QUALITY)):
        one = found[name]
        assert one.error is not None and abs(one.value - truth) < 4 * one.error


def test_what_was_clipped_is_said_of_a_record_that_is_thinned(table):
    """The filter against aliases rounds a plateau off, so that no sample of those kept sticks to a limit."""
    name, limit = "displacement (m)", 0.97 * float(np.max(table["displacement (m)"]))
    campaign = ident.read_campaign(table | {name: np.clip(table[name], -limit, limit)}, device=DEVICE, start="rest")
    (record,) = campaign.traces
    assert record.step > 10 / RATE
    (suspect,) = (one for one in suspects_by_data(campaign) if one.kind == "clipping")
    assert any(f"{suspect.size / 100:.1%} of the response sticks" in remark for remark in remarks(record, campaign))


def test_a_given_noise_is_less_by_what_the_filter_takes_away(table):
    (record,) = ident.read_campaign(table, device=DEVICE, start="rest", noise="20 nm").traces
    assert record.noise.sigma == pytest.approx(NOISE / np.sqrt(record.step * RATE), rel=0.15)


def test_a_record_of_ordinary_length_is_left_as_it_is(table):
    short = {name: column[:20_000] for name, column in table.items()}
    (record,) = ident.read_campaign(short, device=DEVICE, start="rest").traces
    assert len(record.time) == 20_000


def test_lost_samples_do_not_hide_behind_the_floor_that_they_make():
    t = np.arange(1640) * 1e-4
    drive = np.sin(2 * np.pi * 60.0 * t)
    curve = np.sin(2 * np.pi * 60.0 * t - 0.3) + 0.01 * np.random.default_rng(2).standard_normal(len(t))
    broken = np.concatenate([curve[:800], curve[840:]])
    whole = noise_floor(t[:1600], drive[:1600], curve[:1600], 1e4 / 60)
    assert noise_floor(t[:1600], drive[:1600], broken, 1e4 / 60).sigma == pytest.approx(whole.sigma, rel=0.15)
