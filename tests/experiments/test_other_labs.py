"""The study of other laboratories writes what can be read, and judges a word as it is meant."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from experiments.other_labs import DEVICES, Lab, judge
from ident.campaign import read_campaign


def said(verdict: str, *effects: str, tied: tuple[str, ...] = ()) -> dict:
    steps = [{"added": name, "tie_set": [name, *tied]} for name in effects]
    unknown = {"explains": 0.95} if verdict == "not-in-library" else None
    return {"verdict": verdict, "steps": steps, "final": {"effects": list(effects)}, "unknown": unknown}


@pytest.mark.parametrize(
    ("device", "found", "verdict"),
    [
        ("mems", said("identified", "cubic-stiffness"), "right"),
        ("mems", said("identified", "cubic-stiffness", "sensor-offset"), "right"),
        ("mems", said("identified", "end-stop"), "wrong"),
        ("mems", said("not-in-library", "end-stop"), "doubt"),
        ("mems", said("ambiguous", "cubic-stiffness"), "right, with a doubt"),
        ("mems", said("identified", "cubic-stiffness", "creep"), "wrong"),
        ("mems", said("adequate"), "wrong"),
        ("heater", said("ambiguous", "viscoelastic-support", tied=("creep",)), "right"),
        ("pendulum", said("identified", "quadratic-damping"), "wrong"),
        ("tilted", said("identified", "static-force"), "right"),
        ("linear_mems", said("adequate"), "right"),
        ("linear_mems", said("identified", "second-mode"), "wrong"),
        ("groove", said("not-in-library", "end-stop"), "right"),
        ("groove", said("identified", "end-stop"), "wrong"),
    ],
)
def test_a_word_is_judged(device: str, found: dict, verdict: str) -> None:
    assert judge(device, found) == verdict


@pytest.mark.parametrize("name", ["fork", "mems", "plate", "swing", "magnet", "shaker", "bouncing", "valve"])
def test_its_records_are_read(name: str, tmp_path: Path) -> None:
    rng = np.random.default_rng(5)
    lab = Lab(tmp_path, rng)
    DEVICES[name].write(lab, rng)
    campaign = read_campaign(sorted(tmp_path.glob("*.csv")))
    assert len(campaign.records) == len(list(tmp_path.glob("*.csv"))) > len(lab.held) == 1
    assert all(np.all(np.isfinite(record.response)) for record in campaign.traces)
