"""Steady records begin on the periodic orbit of the model: nothing of them is fitted but the parameters."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from experiments.recovery.steady import draw, standardised
from experiments.simulator.circuit import Circuit
from ident.campaign import Campaign, Channel, NoiseFloor, Oscillator, Trace
from ident.effects.registry import built_in
from ident.fit import fit
from ident.fit.profile import profile
from ident.fit.rebuild import fit_at
from ident.model import Model
from ident.report.words.sentences import sentences
from tests.posterior.records import SIGMA, campaign, record

SETTLED = 1000  # samples of the records of the posterior's tests after which 1e-7 of the switching-on is left


def settled(seed: int, **told) -> Trace:
    return replace(record(seed, lead=SETTLED, **told), start="steady", period=100.0)


def duffing() -> Model:
    return Model(Oscillator(), (built_in()["cubic-stiffness"](Oscillator()),))


@pytest.fixture(scope="module")
def found():
    return fit(duffing(), campaign(settled(1), settled(2), settled(3, holdout=True)))


def test_no_start_is_fitted_and_error_bars_do_not_grow(found):
    assert len(found.solved.data.steady) == 2 and not found.solved.static.starts_free
    assert found.fitted.error_over_noise < 1.05 and found.converged
    records = tuple(replace(r, start="unknown") for r in found.campaign.traces)
    free = fit(duffing(), replace(found.campaign, records=records))
    assert free.solved.static.starts_free
    for own, other, true in zip(found.estimates[:4], free.estimates[:4], (71.3, 14.0, 1.9e5, 6.0e4), strict=True):
        assert own.standard_error < 1.01 * other.standard_error
        assert abs(own.value - true) < 4 * own.standard_error


@pytest.mark.parametrize("name", ["bouc-wen", "viscoelastic-support"])
def test_hidden_states_begin_on_the_orbit(name):
    data, model, truth = draw(3, name)
    one = fit(model, data)
    assert len(one.solved.data.steady) == 3
    assert one.fitted.error_over_noise < 1.1
    errors, _ = standardised(one, truth)
    assert len(errors) >= 4 and np.max(np.abs(errors)) < 4


def test_a_record_that_is_held_out_is_foretold_and_not_fitted(found):
    assert found.holdout.error_over_noise < 1.1
    other = tuple(replace(r, response=-r.response) if r.holdout else r for r in found.campaign.traces)
    again = fit_at(found.model, replace(found.campaign, records=other), found.values)
    assert np.allclose(again.readings[2], found.readings[2], rtol=0, atol=1e-3 * SIGMA)


def test_a_fit_is_the_same_from_its_numbers(found):
    again = fit_at(found.model, found.campaign, found.values)
    assert again.fitted.error_over_noise == pytest.approx(found.fitted.error_over_noise, rel=1e-6)
    for old, new in zip(found.estimates[:4], again.estimates[:4], strict=True):
        assert new.standard_error == pytest.approx(old.standard_error, rel=1e-3)


def test_a_prediction_knows_its_error(found):
    said = found.predict(found.campaign.heldout[0])
    clean = settled(3, sigma=1e-12).response
    assert np.sqrt(np.mean(((said.reading - clean) / said.error) ** 2)) < 3
    assert np.max(said.error) < SIGMA


def test_a_profile_agrees_with_the_error_bar(found):
    name = "oscillator.quality"
    walked = profile(found, name)
    own = found["quality"]
    assert walked.kind == "closed"
    assert walked.high - walked.low == pytest.approx(2 * own.standard_error, rel=0.1)


TWO = Circuit(frequency=40.0, quality=40.0, gain=4e3, cubic=1.2e4)


def on_branch(name: str, kick: float, seed: int) -> Trace:
    """A sine between the folds, after a start that leads to one of the two motions there."""
    hertz, step, lead, n = 44.0, 1.0 / (50 * 44.0), 50 * 250, 400
    w0 = 2 * np.pi * TWO.frequency

    def rates(t, y):
        z, v = y
        return [v, TWO.gain * np.cos(2 * np.pi * hertz * t) - w0 / TWO.quality * v - w0**2 * z - TWO.cubic * z**3]

    t = np.arange(n) * step
    run = solve_ivp(rates, (-lead * step, t[-1]), [kick, 0.0], t_eval=t, rtol=1e-9, atol=1e-11, max_step=1e-3)
    noisy = run.y[0] + 2e-3 * np.random.default_rng(seed).normal(size=n)
    one = Channel("V", 1.0)
    drive = np.cos(2 * np.pi * hertz * t)
    return Trace(name, t, drive, noisy, one, one, NoiseFloor(2e-3), "steady", period=50.0)


def test_each_record_is_on_the_branch_that_it_shows():
    records = on_branch("a.csv", 0.0, 0), on_branch("b.csv", 1.2, 1)
    sizes = [float(np.ptp(r.response)) for r in records]
    assert max(sizes) > 2 * min(sizes)  # the same drive, two motions
    found = fit(duffing(), Campaign("two", records, Oscillator()))
    assert len(found.solved.data.steady) == 2
    assert found.fitted.error_over_noise < 1.05


def test_a_drive_that_does_not_repeat_itself_leaves_the_start_unknown():
    cut = replace(settled(1), period=None)
    found = fit(duffing(), campaign(cut))
    assert found.solved.static.starts_free
    assert found.off_orbit == [("1.csv", "its drive does not repeat itself")]
    assert any("1.csv is fitted" in str(s.text) for s in sentences(found))


def test_a_model_that_changes_with_time_leaves_the_start_unknown():
    model = Model(Oscillator(), (built_in()["stiffness-drift"](Oscillator()),))
    found = fit_at(model, campaign(settled(1)), np.array([71.3, 14.0, 1.9e5, 0.0, 1.0, 1.0]))
    assert found.off_orbit == [("1.csv", "the model changes with time")]


def test_a_transient_that_has_not_died_away_is_said():
    early = replace(record(1, lead=100), start="steady", period=100.0)
    found = fit(duffing(), campaign(early, settled(2)))
    assert found.fitted.error_over_noise > 1.5
    assert "1.csv" in dict(found.begun_otherwise)
    assert any("died away" in str(s.text) for s in sentences(found))
