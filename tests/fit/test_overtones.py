"""Harmonics in a fit to curves: their derivatives, their noise, and what they tell."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from experiments.curves import overtones
from ident.campaign import read_campaign
from ident.campaign.campaign import Campaign
from ident.campaign.sweeps.rice import read_beside
from ident.effects.registry import built_in
from ident.fit import fit
from ident.fit.curves import lay_curves
from ident.model import Model
from ident.response import Equation


@pytest.fixture(scope="module")
def campaign(tmp_path_factory: pytest.TempPathFactory) -> Campaign:
    folder = tmp_path_factory.mktemp("heard")
    truth = overtones.oscillator(overtones.QUADRATIC, 0.3 * overtones.CUBIC, 1)
    overtones.write(folder, truth, 1, True, True, False)
    return read_campaign(folder)


def model(campaign: Campaign) -> Model:
    library = built_in()
    springs = (library[name](campaign.device) for name in ("quadratic-stiffness", "cubic-stiffness"))
    first, second = springs
    return Model(campaign.device) + first + second


TRUE = np.array(
    [overtones.FREQUENCY, overtones.QUALITY, overtones.GAIN, overtones.QUADRATIC, 0.0, 0.3 * overtones.CUBIC, 0.0]
)


def test_harmonics_have_the_slopes_of_differences(campaign: Campaign) -> None:
    equation = Equation(model(campaign))
    curves = lay_curves(campaign.sweeps, equation.model).weighed(equation, TRUE)
    slopes = curves.slopes(curves.solve(equation, TRUE), np.diag(TRUE))[:, -curves.heard.count :]
    for i, value in enumerate(TRUE):
        sides = []
        for side in (1e-4, -1e-4):
            there = TRUE.copy()
            there[i] += side * value
            fresh = replace(curves, known={})
            sides.append(fresh.residuals(fresh.solve(equation, there))[-curves.heard.count :])
        difference = (sides[0] - sides[1]) / 2e-4
        np.testing.assert_allclose(slopes[i], difference, rtol=0.01, atol=2e-3 * np.max(np.abs(difference)) + 1e-3)


def test_two_springs_are_told_apart_by_harmonics(campaign: Campaign) -> None:
    without = replace(campaign, records=tuple(replace(s, overtones=()) for s in campaign.sweeps))
    start = TRUE * np.array([1, 1, 1, 0.8, 1, 1.5, 1])
    told, untold = (fit(model(one), one, initial=start) for one in (campaign, without))
    assert 0.8 < told.fitted.error_over_noise < 1.15
    off = (told.values - TRUE) / [e.error or np.nan for e in told.estimates]
    assert np.nanmax(np.abs(off)) < 4
    error = lambda found: found["quadratic-stiffness.k2"].error or np.inf
    assert error(told) < 0.3 * error(untold)


def test_an_amplitude_beside_noise() -> None:
    rng = np.random.default_rng(1)
    noise = rng.standard_normal(200_000) + 1j * rng.standard_normal(200_000)
    for size in (0.0, 0.7, 3.0):
        seen = np.abs(size + noise)
        mean, slope, spread = (float(x) for x in read_beside(np.array(size), np.array(1.0)))
        assert mean == pytest.approx(seen.mean(), abs=0.01)
        assert spread == pytest.approx(seen.std(), abs=0.01)
        more, _, _ = read_beside(np.array(size + 1e-5), np.array(1.0))
        assert slope == pytest.approx((float(more) - mean) / 1e-5, abs=1e-4)


def test_an_even_spring_is_found_from_zero_where_it_has_no_slope(campaign: Campaign) -> None:
    found = fit(model(campaign), campaign)
    assert found.fitted.error_over_noise < 1.15
    assert abs(found["quadratic-stiffness.k2"].value) == pytest.approx(overtones.QUADRATIC, rel=0.05)
