"""The numbers of `run.json`, format 1."""

from __future__ import annotations

import json

import pytest

from ident.report.run_json import run_dict


def test_format_1(make_fit):
    fit = make_fit(heldout_misfit=0.05)
    document = json.loads(json.dumps(run_dict(fit), allow_nan=False))
    assert document["format"] == 1
    assert document["effects"] == ["residual-stress", "pzt-hysteresis"]
    assert document["converged"] is True
    assert document["sigma"] == "known"
    assert len(document["undetermined"]) == 1
    assert set(document["fitted"]) == {"n", "rmse", "unit", "noise_rmse", "error_over_noise", "error_over_signal"}
    assert [r["file"] for r in document["records"]] == ["first_8V.csv", "second_3V.csv", "held_out_5V.csv"]
    assert [r["holdout"] for r in document["records"]] == [False, False, True]


def test_errors_are_in_the_records_own_unit(make_fit):
    document = run_dict(make_fit())
    first = document["records"][0]
    assert first["unit"] == "um"  # also where the file writes µ
    assert first["noise_rmse"] == pytest.approx(0.02)
    assert first["rmse"] == pytest.approx(0.02, rel=0.05)
    assert document["fitted"]["n"] == 3200
    assert document["holdout"]["n"] == 1600


def test_parameters_are_si_and_a_missing_error_has_its_reason(make_fit):
    parameters = {p["name"]: p for p in run_dict(make_fit())["parameters"]}
    assert parameters["platform.d31"]["value"] == 6.399e-11
    assert parameters["platform.d31"]["unit"] == "m/V"
    assert parameters["platform.d31"]["flags"] == []
    stress = parameters["residual-stress.sigma12"]
    assert (stress["standard_error"], stress["flags"], stress["reason"]) == (None, ["undetermined"], "undetermined")
    assert parameters["residual-stress.sigma2"]["reason"] == "held"


def test_no_held_out_record_is_null_and_nan_is_null(make_fit, oscillator_fit):
    fit = make_fit()
    traces = fit.campaign.traces[:2]
    assert run_dict(make_fit(traces=traces))["holdout"] is None
    broken = tuple(s._replace(rmse=float("nan")) for s in fit.scores)
    text = json.dumps(run_dict(make_fit(scores=broken)), allow_nan=False)
    assert json.loads(text)["records"][0]["rmse"] is None
    units = {p["name"]: p["unit"] for p in run_dict(oscillator_fit)["parameters"]}
    assert units["cubic-stiffness.k3"] == "1/V^2/s^2"
