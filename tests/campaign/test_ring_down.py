"""Records without a drive, responses of any kind, and sampling that is not quite uniform."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from ident.campaign import read_campaign
from ident.campaign.campaign import Campaign
from ident.campaign.device import Oscillator
from ident.errors import UserError
from ident.report.words.data import about, what_the_records_tell

STEP = 0.02
T = STEP * np.arange(1500)
NOISE = 1e-4 * np.random.default_rng(5).normal(size=len(T))
DECAY = np.exp(-0.05 * T) * np.cos(2 * np.pi * 1.3 * T) + NOISE


def written(folder: Path, header: str, *columns: np.ndarray, toml: str = "") -> Campaign:
    lines = [header, *(",".join(f"{x:.9g}" for x in row) for row in zip(*columns, strict=True))]
    (folder / "a.csv").write_text("\n".join(lines) + "\n", encoding="utf-8")
    if not toml:
        return read_campaign(folder / "a.csv")
    (folder / "campaign.toml").write_text(toml, encoding="utf-8")
    return read_campaign(folder)


def test_time_and_response_alone_are_a_free_decay_counted_from_where_it_rests(tmp_path):
    campaign = written(tmp_path, "time_s,position_m", T, 0.42 + 0.05 * DECAY)
    (record,) = campaign.fitted
    assert isinstance(campaign.device, Oscillator) and campaign.device.output == "m"
    assert not record.driven and record.start == "unknown" and np.all(record.drive == 0)
    np.testing.assert_allclose(record.response, 0.05 * (DECAY), atol=2e-5)  # 0.04 % of the first amplitude
    assert any("free decay" in note for note in campaign.notes) and any("0.42" in note for note in campaign.notes)


def test_advice_fits_decays(tmp_path):
    campaign = written(tmp_path, "time_s,position_m", T, 0.05 * DECAY)
    told = " ".join(what_the_records_tell(campaign))
    assert "free decays" in told and "half the level" not in told and "one drive frequency" not in told
    assert about(campaign.fitted[0], campaign).startswith(
        "a.csv: no drive, a free decay. Noise floor: what a decay leaves"
    )


def test_a_drive_column_may_be_declared_to_be_none(tmp_path):
    toml = 'device = { kind = "oscillator", output = "V" }\n[[record]]\nfile = "a.csv"\ndrive = "none"\n'
    campaign = written(tmp_path, "t_s,u_V,y_V", T, NOISE, DECAY, toml=toml)
    assert not campaign.fitted[0].driven


def test_any_other_word_in_its_place_is_refused(tmp_path):
    toml = 'device = { kind = "oscillator", output = "V" }\n[[record]]\nfile = "a.csv"\ndrive = "maybe"\n'
    with pytest.raises(UserError, match="none"):
        written(tmp_path, "t_s,u_V,y_V", T, NOISE, DECAY, toml=toml)


@pytest.mark.parametrize(
    ("header", "unit"),
    [("t_s,drive_V,angle_rad", "rad"), ("t_s,force_in_N,strain", ""), ("time_us,drive_chA_V,capacitor_chB_V", "V")],
)
def test_angles_strains_and_the_one_column_that_is_left_are_responses(tmp_path, header, unit):
    drive = np.sin(2 * np.pi * 0.9 * T)
    if header.endswith("strain"):
        toml = 'device = { kind = "oscillator", output = "1", input = "N" }\n[[record]]\nfile = "a.csv"\n'
        campaign = written(tmp_path, header, T, drive, DECAY, toml=toml)
    else:
        campaign = written(tmp_path, header, T, drive, DECAY)
        assert isinstance(campaign.device, Oscillator) and campaign.device.output == unit
    np.testing.assert_allclose(campaign.fitted[0].response, DECAY, atol=1e-8)


def test_a_clock_that_waits_has_no_grid_and_is_read_where_samples_are_dense(tmp_path):
    waits = STEP * (1 + 0.12 * np.random.default_rng(8).uniform(-1, 1, len(T)))
    wandering = np.cumsum(waits) - waits[0]
    assert np.max(np.abs(wandering - T * wandering[-1] / T[-1])) > STEP
    wave = lambda t: np.sin(2 * np.pi * 1.3 * t)
    campaign = written(tmp_path, "t_s,u_V,y_V", wandering, wave(0.7 * wandering), wave(wandering))
    record = campaign.fitted[0]
    assert np.ptp(np.diff(record.time)) < 1e-9 and any("apart" in note for note in campaign.notes)
    assert np.max(np.abs(record.response - wave(record.time))) < 1e-3
    fast = lambda t: np.sin(2 * np.pi * 12 * t)  # 4 samples a period
    with pytest.raises(UserError, match="too few to say what is between"):
        written(tmp_path, "t_s,u_V,y_V", wandering, fast(0.7 * wandering), fast(wandering))


def test_times_that_jitter_are_used_as_they_are(tmp_path):
    jittered = T + 0.1 * STEP * np.random.default_rng(6).uniform(-1, 1, len(T))
    wave = lambda t: np.sin(2 * np.pi * 1.3 * t)
    campaign = written(tmp_path, "t_s,u_V,y_V", jittered, wave(0.7 * jittered), wave(jittered))
    record = campaign.fitted[0]
    taken_as_uniform = np.max(np.abs(wave(jittered) - wave(record.time)))
    assert taken_as_uniform > 0.01
    assert np.max(np.abs(record.response - wave(record.time))[5:-5]) < 0.02 * taken_as_uniform
