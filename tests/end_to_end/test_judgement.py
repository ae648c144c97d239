"""What `check` says of clean records (nothing) and of faulty ones; sines of any number of samples per period."""

from __future__ import annotations

import json
import re
from dataclasses import replace

import numpy as np
import pytest

from ident.campaign import read_campaign
from ident.campaign.period import find_period
from ident.campaign.quality.judge import judge
from ident.report.words.data import one_frequency, remarks
from tests.end_to_end.user import DATA, assert_one_line, ident

CLEAN = ("platform_clean", "platform_317hz", "platform_fe", "mystery_platform", "oscillator")


@pytest.mark.parametrize("name", [*CLEAN, "platform_sweeps"])
def test_no_remark_stands_on_a_clean_record(name):
    campaign = read_campaign(DATA / name)
    assert [(r.name, remarks(r, campaign)) for r in campaign.records if remarks(r, campaign)] == []


@pytest.mark.parametrize("name", CLEAN)
def test_a_drift_of_a_third_is_seen_on_every_record(name):
    for record in read_campaign(DATA / name).traces:
        ramp = np.linspace(0.0, 0.6 * np.std(record.response), len(record.time))
        assert any("drifts" in one for one in judge(replace(record, response=record.response + ramp)).remarks)


@pytest.mark.parametrize("periods", [2.5, 5.0, 25.3])
@pytest.mark.parametrize("noise", [0.0, 1e-3, 1e-2])
@pytest.mark.parametrize("per_period", [7.3, 20.0, 80.8, 200.0, 257.3, 400.0, 512.5, 1000.7, 1600.0, 1616.2])
def test_a_sine_is_found_at_any_number_of_samples_per_period(per_period, noise, periods):
    index = np.arange(int(per_period * periods))
    if len(index) < 40:
        pytest.skip("too short for a record")
    drive = np.sin(2 * np.pi * index / per_period + 0.3)
    drive = drive + noise * np.random.default_rng(1).standard_normal(len(index))
    found = find_period(8 * drive)
    assert found is not None
    # Rife and Boorstyn 1974: sd(ω) = sqrt(24/n³) noise/amplitude; four of them, and a whole number where one is near
    error = 4 * np.sqrt(24 / len(index) ** 3) * noise * per_period / (2 * np.pi)
    assert abs(found / per_period - 1) < error + 0.02 / periods * max(1.0, per_period / 20) / per_period + 1e-9


def test_480_495_and_505_hertz_are_three_frequencies():
    (record,) = (r for r in read_campaign(DATA / "platform_clean").traces if "3V_500" in r.name)
    others = []
    for frequency in (480.0, 495.0, 505.0):
        drive = np.sin(2 * np.pi * frequency * record.time)
        others.append(replace(record, drive=drive, period=find_period(drive)))
    assert one_frequency(others) is None and one_frequency([record, record]) is not None


def test_what_a_fit_would_refuse_is_refused_by_check(small):
    text = '[model]\neffects = {effects}\n{more}\n[[record]]\nfile = "a.csv"\n'
    for effects, more, says in (
        ('["cubic-stifness"]', "", "cubic-stiffness"),
        ("[]", '[priors]\n"platform.qualty" = { normal = [1, 1] }', "quality"),
        ('["creep"]', "[effect.creep]\ntme = 3.0", "time"),
    ):
        (small / "other.toml").write_text(text.format(effects=effects, more=more), encoding="utf-8")
        assert_one_line(ident("check", small / "other.toml"), says)
    (small / "other.toml").unlink()


def test_check_of_curves_says_how_they_were_taken_and_what_they_show_before_any_fit():
    told = ident("check", DATA / "platform_sweeps")
    assert told.code == 0
    for words in ("up and down, with phase", "peak (Hz)", "do not fall on one curve"):
        assert words in told.out, words
    rises = re.search(r"natural frequency rises with the amplitude, from ([\d.]+) to", told.out)
    assert rises is not None and float(rises[1]) == pytest.approx(499.0, abs=0.2)
    judged = json.loads(ident("check", DATA / "platform_sweeps", "--json").out)
    assert [len(record["runs"]) for record in judged["records"]] == [2, 2, 2, 2]


def test_new_makes_a_campaign_of_curves_that_check_reads(tmp_path):
    files = sorted((DATA / "platform_sweeps").glob("*.csv"))
    made = ident("new", tmp_path / "mine", *files, "--json")
    assert made.code == 0 and json.loads(made.out)["files"] == [str(tmp_path / "mine" / "campaign.toml")]
    told = ident("check", tmp_path / "mine")
    assert told.code == 0 and "held out" in told.out and "with phase" in told.out
