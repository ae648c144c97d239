"""Traces and sweeps of one device in one campaign, from the command line."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np

from experiments.curves.joint import draw, truth, write
from tests.end_to_end.user import ident


def test_traces_and_sweeps_are_fitted_together_and_say_more_than_either(tmp_path: Path) -> None:
    rng = np.random.default_rng(7)
    stage = draw(rng)
    write(stage, rng, tmp_path)
    errors = {}
    for kind in ("traces", "sweeps", "both"):
        said = ident("fit", tmp_path / kind, "-o", tmp_path / f"run-{kind}")
        assert said.code == 0, said.err
        run = json.loads((tmp_path / f"run-{kind}" / "run.json").read_text(encoding="utf-8"))
        assert 0.9 < run["fitted"]["error_over_noise"] < 1.1
        found = {p["name"]: p for p in run["parameters"]}
        for name, value in truth(stage).items():
            assert abs(found[name]["value"] - value) < 4 * found[name]["standard_error"], (kind, name)
        errors[kind] = {name: found[name]["standard_error"] for name in truth(stage)}
        if kind == "both":
            sweeps = [record for record in run["records"] if record.get("kind") == "sweep"]
            assert [record["file"] for record in sweeps] == ["sweep_4V.csv", "sweep_8V.csv"]
            assert all(level["direction"] in ("up", "down") for record in sweeps for level in record["levels"])
    for name, error in errors["both"].items():
        assert error < min(errors["traces"][name], errors["sweeps"][name]), name
