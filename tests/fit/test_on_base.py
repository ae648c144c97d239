"""An oscillator whose spring and damper stand on what the drive moves, against SciPy."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.interpolate import CubicSpline

from ident.campaign import Channel, NoiseFloor, Trace
from ident.campaign.campaign import Campaign
from ident.campaign.device import Oscillator
from ident.effects.library.cubic_stiffness import CubicStiffness
from ident.fit import fit
from ident.fit.linear.choice import choose_linear
from ident.fit.linear.start_model import start_model

F, Q = 1.4, 1.6
OMEGA = 2 * np.pi * F
CUBE = 400.0 * OMEGA**2
"""1/(m² s²), on the distance from the base."""


def shaken(size: float, unit: str, seed: int, *, cube: float = 0.0, base: bool = True) -> Trace:
    """A record from rest, the base in a random motion of some size (m), the body read in m."""
    rng, t = np.random.default_rng(seed), np.arange(1500) / (40 * F)
    tones = F * np.arange(0.3, 4.0, 0.1)
    phases, sizes = rng.uniform(0, 2 * np.pi, len(tones)), 1 / tones
    fine = np.linspace(0, t[-1], 8 * len(t))
    begun = np.clip(fine * F / 2, 0, 1) ** 2
    moved = begun * (sizes * np.sin(2 * np.pi * np.outer(fine, tones) + phases)).sum(axis=1)
    curve = CubicSpline(fine, size * moved / np.std(moved))
    rate = curve.derivative()

    def rates(at: float, y: np.ndarray) -> tuple[float, float]:
        apart, pace = y[0] - curve(at), y[1] - (rate(at) if base else 0.0)
        return y[1], -(OMEGA**2) * apart - OMEGA / Q * pace - cube * apart**3

    z = solve_ivp(rates, (0, t[-1]), (0.0, 0.0), "DOP853", t, rtol=1e-9, atol=1e-12).y[0]
    noise = 0.01 * float(np.std(z))
    response = z + noise * rng.standard_normal(len(t))
    return Trace("road", t, curve(t), response, Channel(unit, 1.0), Channel("m", 1.0), NoiseFloor(noise), "rest")


@pytest.mark.parametrize("unit", ["m", "V"])
def test_the_records_choose_it_and_the_fit_reaches_the_noise(unit):
    campaign = Campaign("car", (shaken(0.01, unit, 1),), Oscillator("m", unit))
    model = start_model(campaign)
    assert model.form == "base"
    found = fit(model, campaign)
    assert found.fitted.error_over_noise == pytest.approx(1.0, abs=0.06)
    for name, truth in (("frequency", F), ("quality", Q), ("gain", 1.0)):
        assert found[name].value == pytest.approx(truth, abs=4 * (found[name].error or 0.0))


def test_what_only_pushes_is_no_base_in_whatever_unit():
    assert choose_linear([shaken(0.01, "m", 2, base=False)]).chosen.form == "oscillator"


def test_forces_act_by_the_distance_from_the_base():
    records = tuple(shaken(size, "m", seed, cube=CUBE) for seed, size in ((3, 0.01), (4, 0.025)))
    campaign = Campaign("car", records, Oscillator("m", "m"))
    found = fit(start_model(campaign) + CubicStiffness(), campaign)
    assert found.fitted.error_over_noise == pytest.approx(1.0, abs=0.06)
    assert found["k3"].value == pytest.approx(CUBE, abs=4 * (found["k3"].error or 0.0))
