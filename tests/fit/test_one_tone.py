"""One steady sine does not determine a quality factor, and the fit says so instead of inventing one."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from experiments.hidden_effects.campaigns import campaign_of, poor_case
from ident.campaign.campaign import Campaign
from ident.campaign.device import Oscillator
from ident.campaign.noise.floor import NoiseFloor
from ident.campaign.period import find_period
from ident.campaign.record import Channel, Trace
from ident.diagnosis.search.change import add
from ident.effects.registry import built_in
from ident.fit import fit
from ident.fit.linear.one_tone import hold_dragged, hold_quality
from ident.model import Model
from ident.report.words.sentences import sentences

FREQUENCY, QUALITY, GAIN, STEP, SIGMA = 500.0, 40.0, 2e6, 2.5e-5, 1e-4


def steady(drive: float, start: str = "unknown", seed: int = 0) -> Trace:
    """A sine of 1 V answered by a linear oscillator, in closed form."""
    omega, omega0 = 2 * np.pi * drive, 2 * np.pi * FREQUENCY
    answer = GAIN / (omega0**2 - omega**2 + 1j * omega * omega0 / QUALITY)
    t = STEP * np.arange(1600)
    voltage, response = np.sin(omega * t), np.imag(answer * np.exp(1j * omega * t))
    response = response + SIGMA * np.random.default_rng(seed).normal(size=len(t))
    one = Channel("V", 1.0)
    noise = NoiseFloor(SIGMA, (), "given", 0.0)
    return Trace(f"{drive:g}.csv", t, voltage, response, one, one, noise, start=start, period=find_period(voltage))  # type: ignore[arg-type]


def held(*records: Trace, model: Model | None = None) -> bool:
    return "oscillator.quality" in hold_quality(model or Model(Oscillator()), records).undetermined


def test_it_is_held_for_one_steady_sine_only() -> None:
    assert held(steady(480.0)) and held(steady(480.0), steady(480.0, seed=1))
    assert not held(steady(480.0), steady(505.0))
    assert not held(steady(480.0, start="rest"))
    assert not held(steady(480.0), model=replace(Model(Oscillator()), freed=frozenset({"oscillator.quality"})))


def test_a_motion_that_still_changes_determines_it() -> None:
    record = steady(480.0)
    dying = 0.2 * np.exp(-record.time / 0.01) * np.sin(2 * np.pi * FREQUENCY * record.time)
    assert not held(replace(record, response=record.response + dying))


def test_the_fit_describes_the_record_and_says_what_it_held() -> None:
    found = fit(Model(Oscillator()), Campaign("one sine", (steady(480.0),), Oscillator()))
    quality = found.estimates[1]
    assert quality.standard_error is None and "held" in quality.flags and quality.value == 30.0
    assert found.fitted.error_over_noise == pytest.approx(1.0, abs=0.06)
    assert any(s.warning and "quality factor is held at 30" in s.text for s in sentences(found))


def test_a_sharp_resonance_is_not_believed_where_it_only_mimics_what_is_missing() -> None:
    """Independent simulation: the stiffness drifts, so that the one steady sine changes a little within its record."""
    campaign = campaign_of(poor_case(306, ("stiffness-drift",), 0.08, 0.003))
    linear = fit(Model(campaign.device), campaign)
    assert linear.fitted.error_over_noise > 1.5
    assert "held" in linear.estimates[1].flags and linear.estimates[1].value == 30.0
    assert len(fit(Model(campaign.device), campaign, starts=2).starts) == 3  # from which the user has asked to begin
    drifting = add(linear, built_in()["stiffness-drift"])
    assert drifting.fitted.error_over_noise < 1.05
    assert drifting.estimates[1].value == pytest.approx(55.5, rel=0.2) and "held" not in drifting.estimates[1].flags


def test_a_quality_factor_that_a_user_holds_stays() -> None:
    model = replace(Model(Oscillator()), held=frozenset({"oscillator.quality"}))
    assert hold_quality(model, (steady(480.0),)).undetermined == frozenset()
    assert hold_dragged(model, np.array([500.0, 1e6, 1.0]), (steady(480.0),)) is model
