"""A spring that stiffens threefold: no linear oscillator comes near, and the equation of motion still tells its law."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import solve_ivp
from scipy.interpolate import CubicSpline

from ident.campaign.campaign import Campaign
from ident.campaign.device import Oscillator
from ident.campaign.record import Channel, NoiseFloor, Trace
from ident.diagnosis.linearised.anchor import prepare_at_best
from ident.diagnosis.linearised.regression import Regression, prepare
from ident.diagnosis.ranking.confirm import confirm
from ident.diagnosis.ranking.refits import by_refits
from ident.diagnosis.ranking.score import score
from ident.effects.registry import built_in
from ident.fit import fit
from ident.fit.rebuild import fit_at
from ident.model import Model

FREQUENCY, QUALITY, SIGMA = 50.0, 30.0, 2e-3
OMEGA = 2 * np.pi * FREQUENCY
GAIN, CUBIC = 3 * OMEGA**2 / QUALITY, OMEGA**2  # a volt at resonance would move a linear stage by three
LIBRARY = {name: built_in()[name] for name in ("cubic-stiffness", "bouc-wen", "end-stop", "voltage-stiffness", "creep")}
TIME = np.arange(2000) / 2000.0


def record(name: str, drive: np.ndarray, seed: int) -> Trace:
    """An oscillator with a cubic spring, from rest (SciPy, tight tolerances)."""
    told = CubicSpline(TIME, drive)
    rate = lambda t, y: [y[1], GAIN * told(t) - OMEGA / QUALITY * y[1] - OMEGA**2 * y[0] - CUBIC * y[0] ** 3]
    found = solve_ivp(rate, (0.0, TIME[-1]), [0.0, 0.0], "DOP853", TIME, rtol=1e-9, atol=1e-12, max_step=5e-4)
    noise = SIGMA * np.random.default_rng(seed).normal(size=len(TIME))
    one = Channel("V", 1.0)
    return Trace(name, TIME, drive, found.y[0] + noise, one, one, NoiseFloor(SIGMA, (), "given", 0.0))


@pytest.fixture(scope="module")
def regression() -> Regression:
    chirp = np.sin(2 * np.pi * (20 * TIME + 60 * TIME**2 / (2 * TIME[-1])))
    drives = {"chirp": chirp, "weak": 0.4 * np.sin(0.98 * OMEGA * TIME), "strong": np.sin(1.03 * OMEGA * TIME)}
    records = tuple(record(name, drive, seed) for seed, (name, drive) in enumerate(drives.items()))
    assert 1.5 < max(float(np.max(r.response**2)) for r in records) < 4  # how many times the spring stiffens
    campaign = Campaign("Duffing", records, Oscillator())
    return prepare(fit(Model(campaign.device), campaign))


def test_the_equation_is_believed_where_the_fit_is_useless(regression: Regression) -> None:
    assert regression.fit.fitted.error_over_signal > 0.25
    assert regression.credible


def test_the_law_and_the_linear_part_beside_it_are_read_off_the_motion(regression: Regression) -> None:
    best = score(regression, LIBRARY)[0]
    assert best.name == "cubic-stiffness" and best.predicted_gain > 0.999
    assert best.values["k3"] == pytest.approx(CUBIC, rel=0.01)
    assert best.beside is not None
    assert best.beside[[0, 2]] == pytest.approx([FREQUENCY, GAIN], rel=0.02)
    assert best.beside[1] == pytest.approx(QUALITY, rel=0.25)  # near resonance the velocity is small beside its noise
    assert confirm(regression, LIBRARY[best.name], best).gain > 0.9999


def test_short_refits_begin_where_the_score_leads_too(regression: Regression) -> None:
    ranked = by_refits(regression, score(regression, LIBRARY), LIBRARY, lambda _: None)
    assert ranked[0].name == "cubic-stiffness" and ranked[0].predicted_gain > 0.9999


def test_values_nearer_the_device_are_found_from_a_fit_that_bent_far(regression: Regression) -> None:
    bent = fit_at(regression.fit.model, regression.fit.campaign, np.array([3 * FREQUENCY, 0.3 * QUALITY, GAIN]))
    there = prepare_at_best(bent)
    assert there.instead_of is not None and there.instead_of.fit is bent
    assert there.unexplained < 0.5 * prepare(bent).unexplained
    best = score(there, LIBRARY)[0]
    assert best.name == "cubic-stiffness" and best.beside is not None
    assert best.beside[[0, 2]] == pytest.approx([FREQUENCY, GAIN], rel=0.02)


@given(frequency=st.floats(1e-3, 1e6), quality=st.floats(1e-3, 1e6), mass=st.floats(1e-9, 1e3))
def test_spring_and_damper_are_told_both_ways(frequency: float, quality: float, mass: float) -> None:
    for form in ("oscillator", "no-spring"):
        model = Model(Oscillator(), form=form)
        spring, damper = model.spring_and_damper(frequency, quality, mass)
        assert model.times_of(spring, damper, mass, frequency) == pytest.approx((frequency, quality), rel=1e-12)
