"""The commands around a fit: check, effects, new, simulate, report."""

from __future__ import annotations

import json

import numpy as np
import pytest

from ident.campaign import read_campaign
from ident.effects.registry import built_in
from ident.report.run_folder import read_run
from tests.end_to_end.schema import assert_run
from tests.end_to_end.user import DATA, assert_one_line, ident


def test_check_judges_every_record_and_what_they_tell_apart():
    outcome = ident("check", DATA / "platform_clean", "--json")
    assert outcome.code == 0, outcome.err
    document = json.loads(outcome.out)
    campaign = read_campaign(DATA / "platform_clean")
    assert [r["file"] for r in document["records"]] == [r.name for r in campaign.records]
    assert all(r["noise"]["sigma"] == pytest.approx(25e-9, rel=0.1) for r in document["records"])
    assert document["records"][0]["frequency"] == pytest.approx(317, rel=1e-3)
    assert any("one load" in sentence for sentence in document["tells_apart"])
    printed = ident("check", DATA / "platform_clean").out
    assert "8 V sine at 317 Hz" in printed and "one load" in printed


def test_check_asks_for_another_level_and_a_heldout_record():
    printed = ident("check", DATA / "platform_clean" / "sine_8V_317Hz.csv").out
    for words in ("one drive level", "one drive frequency", "Nothing is held out"):
        assert words in printed


def test_effects_lists_the_library_and_explains_each():
    listed = json.loads(ident("effects", "--json").out)["effects"]
    assert {effect["name"] for effect in listed} == set(built_in())
    printed = ident("effects").out
    assert all(name in printed for name in built_in())
    explained = ident("effects", "cubic-stiffness").out
    for words in ("cubic-stiffness.k3", "N/m^3", "force on the stage", "mistaken for", "source"):
        assert words in explained
    assert "alike          end-stop, residual-stress: a stop that is touched gently" in explained


def test_a_new_campaign_is_fitted_as_it_is_and_never_overwritten(tmp_path):
    folder = tmp_path / "mine"
    outcome = ident("new", folder)
    assert outcome.code == 0, outcome.err
    assert f"ident fit {folder}" in outcome.out
    before = (folder / "campaign.toml").read_bytes()
    assert_one_line(ident("new", folder), "exists already", "--force")
    assert (folder / "campaign.toml").read_bytes() == before
    assert ident("effects", "gas-drag", "--file", folder / "my_effect.py").code == 0
    fitted = ident("fit", folder, "-o", tmp_path / "run", "--json")
    assert fitted.code == 0, fitted.err
    document = json.loads(fitted.out)
    drag = next(p for p in document["parameters"] if p["name"] == "gas-drag.c")
    assert abs(drag["value"] - 4e-3) < 4 * drag["standard_error"] < 4e-3
    assert document["fitted"]["error_over_noise"] < 1.15 and document["holdout"]["error_over_noise"] < 1.15


def test_an_effect_is_added_by_its_file_also_where_the_campaign_has_that_already(tmp_path):
    folder = tmp_path / "mine"
    assert ident("new", folder).code == 0
    assert ident("fit", folder, "--effects", "", "-o", tmp_path / "plain").code == 0
    outcome = ident("add", tmp_path / "plain", folder / "my_effect.py", "-o", tmp_path / "more", "--json")
    assert outcome.code == 0, outcome.err
    assert json.loads(outcome.out)["effects"] == ["gas-drag"]
    two = tmp_path / "two.py"
    text = (folder / "my_effect.py").read_text()
    text = text.replace("gas-drag", "drag-a")
    two.write_text(text + text[text.index("class ") :].replace("GasDrag", "Other").replace("drag-a", "drag-b"))
    refused = ident("add", tmp_path / "plain", two, "-o", tmp_path / "none")
    assert refused.code == 2
    assert "several effects: drag-a, drag-b — give each a file of its own" in refused.err


def test_simulate_writes_what_the_fit_says_in_columns_with_units(clean, tmp_path):
    home, _ = clean
    outcome = ident("simulate", home / "run", "--record", "sine_3V_500Hz.csv", "-o", tmp_path / "model.csv")
    assert outcome.code == 0, outcome.err
    (simulated,) = read_campaign(tmp_path / "model.csv").traces
    measured = next(r for r in read_campaign(home / "campaign").traces if r.name == "sine_3V_500Hz.csv")
    assert (tmp_path / "model.csv").read_text().splitlines()[0] == "time (s),drive (mV),displacement (nm)"
    score = next(r for r in read_run(home / "run")["records"] if r["file"] == measured.name)
    assert 1e9 * np.std(simulated.response - measured.response) == pytest.approx(score["rmse"], rel=1e-3)


def test_simulate_takes_parameters_and_tells_records_apart(clean, tmp_path):
    file = tmp_path / "what_if.csv"
    outcome = ident("simulate", clean[0] / "run", "--set", "platform.frequency=0.6 kHz", "-o", file, "--json")
    assert outcome.code == 0, outcome.err
    assert json.loads(outcome.out)["parameters"]["platform.frequency"] == pytest.approx(600)
    lines = file.read_text().splitlines()
    assert lines[0].startswith("record,time (s)") and len(lines) == 1 + 5 * 2000
    assert_one_line(ident("simulate", clean[0] / "run", "-o", file), "exists already")


def test_report_is_made_again_from_the_numbers(clean):
    page = clean[0] / "run" / "report.html"
    page.unlink()
    outcome = ident("report", clean[0] / "run")
    assert outcome.code == 0, outcome.err
    assert outcome.out.strip() == str(page)
    assert "<html" in page.read_text(encoding="utf-8")


def test_a_walk_that_runs_out_of_time_leaves_what_it_found(tmp_path):
    run = tmp_path / "run"
    outcome = ident("discover", DATA / "oscillator", "-o", run, "--minutes", "0.0001")
    assert outcome.code == 0, outcome
    assert "time is over" in outcome.out
    document = json.loads((run / "diagnosis.json").read_text(encoding="utf-8"))
    assert document["finished"] is False and document["steps"] == []
    assert_run(json.loads((run / "run.json").read_text(encoding="utf-8")))
