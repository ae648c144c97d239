"""`ident fit` on campaigns simulated by the independent script: the truth, the run folder, and what may not be lost."""

from __future__ import annotations

import json
import shutil
import tomllib

import numpy as np
import pytest

from ident.errors import UserError
from ident.report.run_folder import load_run, read_run
from ident.report.run_json import run_dict
from tests.end_to_end.schema import assert_run
from tests.end_to_end.user import DATA, assert_one_line, ident


def _truth(campaign: str) -> dict[str, float]:
    return tomllib.loads((DATA / campaign / "truth.toml").read_text(encoding="utf-8"))["parameters"]


def _assert_true(document: dict, campaign: str) -> None:
    found = {p["name"]: p for p in document["parameters"]}
    for name, value in _truth(campaign).items():
        assert abs(found[name]["value"] - value) < 4 * found[name]["standard_error"], name


def test_the_linear_platform_is_recovered_to_the_noise_floor(clean):
    home, outcome = clean
    assert outcome.code == 0, outcome.err
    document = read_run(home / "run")
    assert_run(document)
    _assert_true(document, "platform_clean")
    assert document["effects"] == []
    assert document["fitted"]["error_over_noise"] < 1.1
    assert document["holdout"]["error_over_noise"] < 1.1
    assert document["fitted"]["unit"] == "nm"


def test_a_run_folder_holds_what_the_interface_says(clean):
    home, outcome = clean
    assert {p.name for p in (home / "run").iterdir()} >= {"run.json", "report.html", "figures", "lineage.json"}
    assert {p.name for p in home.iterdir()} == {"campaign", "run"}, "a temporary folder was left"
    assert json.loads((home / "run" / "lineage.json").read_text()) == []
    document = read_run(home / "run")
    assert set(document["campaign"]["checksums"]) == {"campaign.toml", *(r["file"] for r in document["records"])}
    assert str(home) not in json.dumps(document["campaign"]), "a run must survive being moved with its campaign"


def test_results_go_to_stdout_and_progress_to_stderr(clean):
    home, outcome = clean
    assert "platform.quality" in outcome.out and str(home / "run" / "report.html") in outcome.out
    assert "nominal platform is assumed" in outcome.out
    assert "compiling the model" in outcome.err and "platform.d31" not in outcome.err


def test_a_profile_agrees_with_the_error_bar_of_a_linear_model(clean):
    home, outcome = clean
    assert "Profile of platform.quality" in outcome.out and "closed" in outcome.out
    (profile,) = json.loads((home / "run" / "profiles.json").read_text())["profiles"]
    error = next(p for p in read_run(home / "run")["parameters"] if p["name"] == "platform.quality")["standard_error"]
    assert profile["high"] - profile["low"] == pytest.approx(2 * error, rel=0.02)


def test_json_on_stdout_is_what_the_run_folder_holds(oscillator):
    run, outcome = oscillator
    assert outcome.code == 0, outcome.err
    document = json.loads(outcome.out)
    assert document == json.loads((run / "run.json").read_text(encoding="utf-8"))
    assert_run(document)
    _assert_true(document, "oscillator")
    assert document["effects"] == ["cubic-stiffness"]


def test_a_loaded_run_has_the_numbers_of_the_fit(oscillator):
    run, _ = oscillator
    stored, loaded = read_run(run), run_dict(load_run(run))
    assert loaded["effects"] == stored["effects"] and loaded["converged"] == stored["converged"]
    for now, then in zip(loaded["parameters"], stored["parameters"], strict=True):
        assert now["value"] == pytest.approx(then["value"], rel=1e-12)  # there and back through the bounds
        if then["standard_error"] is None:  # it is held
            assert now["standard_error"] is None
        else:
            assert now["standard_error"] == pytest.approx(then["standard_error"], rel=1e-6)
    for now, then in zip(loaded["records"], stored["records"], strict=True):
        assert now["rmse"] == pytest.approx(then["rmse"], rel=1e-9)


def test_a_moved_run_finds_its_campaign_and_notices_changed_data(clean, tmp_path):
    home, _ = clean
    moved = tmp_path / "moved"
    shutil.copytree(home, moved)
    assert load_run(moved / "run").value("platform.quality") == pytest.approx(35, rel=1e-2)
    table = moved / "campaign" / "sine_3V_500Hz.csv"
    table.write_text(table.read_text().replace("0.000050000,469.6,", "0.000050000,469.7,"), encoding="utf-8")
    with pytest.raises(UserError, match="sine_3V_500Hz.csv: has changed since this run"):
        load_run(moved / "run")
    assert_one_line(ident("simulate", moved / "run", "-o", tmp_path / "a.csv"), "sine_3V_500Hz.csv", "has changed")


def test_data_files_alone_are_a_campaign_whose_starts_are_fitted(tmp_path):
    files = [DATA / "platform_clean" / name for name in ("sine_9V_505Hz.csv", "multisine_6V.csv")]
    outcome = ident("fit", *files, "-o", tmp_path / "run")
    assert outcome.code == 0, outcome.err
    assert "the initial state is fitted" in outcome.out
    document = read_run(tmp_path / "run")
    assert document["holdout"] is None
    _assert_true(document, "platform_clean")
    loaded = run_dict(load_run(tmp_path / "run"))
    assert loaded["fitted"]["rmse"] == pytest.approx(document["fitted"]["rmse"], rel=1e-6)


def test_nothing_is_overwritten_without_force(clean):
    home, _ = clean
    before = (home / "run" / "run.json").read_bytes()
    assert_one_line(ident("fit", home / "campaign", "-o", home / "run"), "exists already", "--force")
    assert (home / "run" / "run.json").read_bytes() == before


def test_force_replaces_runs_and_nothing_else(tmp_path):
    (tmp_path / "precious").mkdir()
    (tmp_path / "precious" / "thesis.tex").write_text("…")
    outcome = ident("fit", DATA / "platform_clean", "-o", tmp_path / "precious", "--force")
    assert_one_line(outcome, "not a run folder")
    assert (tmp_path / "precious" / "thesis.tex").exists()


def test_an_interrupted_fit_leaves_nothing_half_written(clean, tmp_path, monkeypatch):
    def stop(*_, **__):
        raise KeyboardInterrupt

    monkeypatch.setattr("ident.report.run_folder.write_report", stop)
    outcome = ident("fit", clean[0] / "campaign", "-o", tmp_path / "runs" / "a")
    assert outcome.code == 1
    assert outcome.err.splitlines()[-1].startswith("ident: stopped")
    assert list((tmp_path / "runs").iterdir()) == []


def test_a_parameter_that_the_fit_holds_has_no_profile_and_the_fit_is_kept(tmp_path):
    """One steady sine: the quality factor is free in the model, and held once the records are seen."""
    time = np.arange(1600) * 2.5e-5
    turn = 2 * np.pi * 480.0 * time
    response = 5.0 * np.sin(turn - 0.3) + 1e-3 * np.random.default_rng(0).standard_normal(1600)
    table = np.column_stack([time, np.sin(turn), response])
    np.savetxt(tmp_path / "a.csv", table, delimiter=",", header="time (s),drive (V),response (V)", comments="")
    what = 'device = { kind = "oscillator", output = "V" }\n[[record]]\nfile = "a.csv"\nstart = "unknown"\n'
    (tmp_path / "campaign.toml").write_text(what, encoding="utf-8")
    outcome = ident("fit", tmp_path, "-o", tmp_path / "run", "--profile", "quality", "--profile", "gain")
    assert outcome.code == 0, outcome.err
    assert "no profile of quality" in outcome.err and (tmp_path / "run" / "run.json").is_file()
    (told,) = json.loads((tmp_path / "run" / "profiles.json").read_text(encoding="utf-8"))["profiles"]
    assert told["name"] == "oscillator.gain"
