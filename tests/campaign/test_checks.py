"""What the data checks say of records that can be used, but not without a word."""

from __future__ import annotations

import numpy as np
import pytest

from ident.campaign import read_campaign
from ident.campaign.quality.clipping import clipped_fraction
from tests.broken import csv_text, signals


def _notes(tmp_path, values=None, header="time (s),drive (V),z (um)", text=None):
    (tmp_path / "a.csv").write_text(text or csv_text(header, values), encoding="utf-8")
    campaign = read_campaign(tmp_path / "a.csv")
    return campaign.traces[0], " ".join(campaign.notes)


def test_a_healthy_record_has_little_to_say(tmp_path):
    _, notes = _notes(tmp_path)
    assert (
        notes
        == "No device given: the nominal platform is assumed. a.csv: start is not given; the initial state is fitted."
    )


def test_a_little_jitter_is_noted_and_taken_as_uniform(tmp_path):
    values = signals()
    values[:, 0] += np.random.default_rng(0).uniform(-0.05, 0.05, 400) * 5e-5
    trace, notes = _notes(tmp_path, values)
    assert "jitter" in notes
    assert np.ptp(np.diff(trace.time)) < 1e-12


@pytest.mark.parametrize("digits", [3, 4, 6])
def test_rounded_times_are_normal(tmp_path, digits):
    rows = "".join(f"{t:.{digits}g},{u:.7g},{z:.7g}\n" for t, u, z in signals(300) * [1 / 0.7, 1, 1])
    trace, notes = _notes(tmp_path, text="time (s),drive (V),z (um)\n" + rows)
    assert trace.step == pytest.approx(5e-5 / 0.7, rel=2e-3)
    assert "jitter" not in notes
    assert ("rounded" in notes) == (digits < 5)


def test_clipping_is_noted(tmp_path):
    values = signals()
    values[:, 2] = np.clip(values[:, 2], -2.5, 2.5)
    _, notes = _notes(tmp_path, values)
    assert "clipped" in notes


def test_coarse_resolution_is_not_clipping():
    sine = np.sin(2 * np.pi * np.arange(4000) / 113.7)
    assert clipped_fraction(np.round(sine * 127) / 127) == 0
    assert clipped_fraction(np.clip(np.round(sine * 127) / 127, -0.8, 0.8)) > 0.3


def test_few_samples_per_period_are_noted(tmp_path):
    time = np.arange(400) * 2e-4
    values = np.c_[time, 8 * np.sin(2 * np.pi * 1000 * time + 0.2), np.cos(2 * np.pi * 1000 * time)]
    _, notes = _notes(tmp_path, values)
    assert "5.0 samples per period" in notes


def test_a_free_decay_is_noted(tmp_path):
    time = np.arange(800) * 5e-5
    values = np.c_[time, np.zeros(800), np.exp(-50 * time) * np.cos(2 * np.pi * 500 * time)]
    trace, notes = _notes(tmp_path, values)
    assert "free decay" in notes and trace.period is None and "die away" not in notes


def test_a_motion_that_goes_on_without_a_drive_asks_for_the_drive(tmp_path):
    time = np.arange(800) * 5e-5
    _, notes = _notes(tmp_path, np.c_[time, np.zeros(800), np.sin(2 * np.pi * 500 * time)])
    assert "does not die away; was the drive recorded?" in notes


def test_a_drive_beyond_the_device_is_noted(tmp_path):
    _, notes = _notes(tmp_path, signals() * [1, 3, 1])
    assert "more than the 10 V" in notes


def test_a_strange_sampling_rate_is_noted(tmp_path):
    _, notes = _notes(tmp_path, signals() * [1e3, 1, 1])
    assert "unit of time" in notes


def test_a_column_exported_twice_is_noted(tmp_path):
    values = signals()
    values[:, 2] = values[:, 1]
    _, notes = _notes(tmp_path, values)
    assert "same signal" in notes


def test_an_overshoot_that_clips_once_is_clipped_and_a_plateau_is_not():
    from scipy.signal import lfilter

    from ident.campaign.quality.clipping import clipped_samples

    rng, t = np.random.default_rng(31), np.arange(1500)
    transient = np.exp(-t / 300) * np.sin(2 * np.pi * t / 60) + 0.2 * np.sin(2 * np.pi * t / 43)
    noisy = transient + 0.002 * rng.standard_normal(len(t))
    cut = np.minimum(noisy, 0.9)
    assert list(np.flatnonzero(clipped_samples(cut))) == list(np.flatnonzero(noisy >= 0.9))
    assert not np.any(clipped_samples(np.maximum(np.minimum(noisy, 1.2), -1.2)))
    pulses = ((t // 250) % 2).astype(float)
    settled = np.round(64 * lfilter([0.05], [1, -0.95], pulses)) / 64  # a slow device that is read coarsely
    assert not np.any(clipped_samples(settled))
