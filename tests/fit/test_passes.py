"""Sweeps that were run faster than the motion settles, against the script's own SciPy transients."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from experiments.curves import hurry
from ident.campaign import read_campaign
from ident.campaign.campaign import Campaign
from ident.errors import UserError
from ident.fit import fit
from ident.fit.passes import lay_passes
from ident.model import build_model
from ident.response import Equation

HIDDEN = hurry.cubic(0.03)


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    found = tmp_path_factory.mktemp("hurry")
    hurry.write(found, 1, HIDDEN, (HIDDEN.name,))
    return found


@pytest.fixture(scope="module")
def campaign(folder: Path) -> Campaign:
    return read_campaign(folder)


def test_a_fast_sweep_is_told_by_its_curve_and_its_rate(campaign: Campaign) -> None:
    assert campaign.sweeps[0].fast
    assert any("simulated as it was run" in note for note in campaign.notes)


def test_parameters_of_a_fast_sweep_are_recovered(campaign: Campaign) -> None:
    found = fit(build_model(campaign), campaign)
    errors, left = hurry.off(found, HIDDEN)
    assert 0.8 < left < 1.15
    assert np.max(np.abs(errors)) < 4
    assert found.step_error < 0.1


def test_a_slow_sweep_is_fitted_as_settled(folder: Path, tmp_path: Path) -> None:
    text = (folder / "campaign.toml").read_text()
    (tmp_path / "sweeps.csv").write_text((folder / "sweeps.csv").read_text())
    (tmp_path / "campaign.toml").write_text(text.replace("6.0 Hz/s", "0.0005 Hz/s"))
    assert not read_campaign(tmp_path).sweeps[0].fast
    (tmp_path / "campaign.toml").write_text(text.replace("6.0 Hz/s", "0 Hz/s"))
    with pytest.raises(UserError, match="not positive"):
        read_campaign(tmp_path)
    (tmp_path / "campaign.toml").write_text(text.replace('sweep_rate = "6.0 Hz/s"\n', ""))
    with pytest.raises(UserError, match="averaging"):
        read_campaign(tmp_path)


def test_slopes_of_passes_are_those_of_differences(campaign: Campaign) -> None:
    sweep = campaign.sweeps[0]
    short = replace(sweep.only(np.flatnonzero((sweep.frequency > 117) & sweep.up)), fast=True)
    model = build_model(campaign)
    passes, equation = lay_passes([short], model), Equation(model)
    values = np.array([hurry.FREQUENCY, hurry.QUALITY, hurry.GAIN, *HIDDEN.parameters.values(), 0.0])
    slopes = passes.slopes(passes.solve(equation, values, np.diag(values)))
    for i, value in enumerate(values[:4]):
        sides = []
        for side in (1e-6, -1e-6):
            there = values.copy()
            there[i] += side * value
            sides.append(passes.residuals(passes.solve(equation, there, np.zeros((0, 5)))))
        difference = (sides[0] - sides[1]) / 2e-6
        np.testing.assert_allclose(slopes[i], difference, rtol=1e-3, atol=1e-4 * np.max(np.abs(difference)))
