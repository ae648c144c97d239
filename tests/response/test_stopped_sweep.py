"""Curves that end in the corner of a stop, against transients that an independent Runge-Kutta scheme had settled."""

from __future__ import annotations

import numpy as np
import pytest

from ident.campaign.device import Oscillator
from ident.effects.registry import built_in
from ident.model import Model
from ident.response import Equation
from ident.response.branches import follow
from ident.response.periodic import Periodic
from ident.response.sweep import run_along

OWN = 2 * np.pi * 60.0
VALUES = {
    "oscillator.frequency": 60.0, "oscillator.quality": 35.0, "oscillator.gain": 0.5e-3 * OWN**2 / 35,
    "end-stop.above": 3 * OWN**2, "end-stop.gap": 0.8e-3, "end-stop.exponent": 1.0, "end-stop.asymmetry": 1.0,
}  # fmt: skip
JUMPS = {True: 70.50, False: 61.93}  # ± 0.21 Hz at 4 V: between two frequencies of the transient's sweep


@pytest.mark.parametrize("up", [True, False])
def test_a_curve_that_ends_at_a_corner_is_jumped_off_there(up: bool) -> None:
    device = Oscillator(output="m")
    model = Model(device) + built_in()["end-stop"](device)
    values = np.array([VALUES.get(p.name, 0.0) for p in model.parameters])
    periodic = Periodic(Equation(model), values, 256)
    (branch,) = follow(periodic, np.array([4.0]), np.zeros(1), np.array([50.0, 80.0]), np.array([1.7e-3]))
    frequency = np.linspace(54, 75, 50)[:: 1 if up else -1]
    scale = np.maximum(np.max(np.abs(branch.unknowns), axis=0), 1e-300)
    passed = run_along(periodic, branch, frequency, 0.0, False, scale)
    assert passed.fold is not None and passed.fold.frequency == pytest.approx(JUMPS[up], abs=0.3)
    assert 0 < passed.after < 50
