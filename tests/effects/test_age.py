"""A drift in a record that begins in motion has had time to go on before the first sample."""

from __future__ import annotations

from dataclasses import replace

import pytest

from experiments.hidden_effects.campaigns import campaign_of, poor_case
from experiments.hidden_effects.generator import draw, measure_again
from experiments.simulator.signals import sine
from ident.effects.effect import AbstractEffect, Drive, State, amplitude, choice
from ident.effects.registry import built_in
from ident.fit import fit
from ident.model import Model, make_effect

DRIFTS = ("sensor-drift", "stiffness-drift", "damping-drift")
STATE = State(2e-6, 3e-3)


@pytest.mark.parametrize("name", DRIFTS)
def test_age_shifts_the_time_of_a_record_that_begins_in_motion_only(name: str) -> None:
    effect = built_in()[name](settings={"begins": "in-motion"}, rate0=2.0, time=0.5, age=0.3)
    act = effect.sensor if name == "sensor-drift" else effect.force
    at_rest, moving = Drive(1.0, 0.0, 1.0, 1.0), Drive(1.0, 0.0, 1.0, 1.0, 1.0)
    assert act(STATE, moving, 0.1) == act(STATE, at_rest, 0.1 + 0.3)
    assert abs(act(STATE, moving, 0.1)) > abs(act(STATE, at_rest, 0.1)) > 0
    plain = effect.with_values(age=0.3)
    afresh = type(plain)(settings={"begins": "at-rest"}, **plain.values)
    act = afresh.sensor if name == "sensor-drift" else afresh.force
    assert act(STATE, moving, 0.1) == act(STATE, at_rest, 0.1)


def test_age_is_fitted_only_where_some_records_begin_in_motion_and_some_at_rest() -> None:
    rest, mixed = (
        campaign_of(draw(4, (), device="oscillator", records=4, length=400, starts=starts))
        for starts in ("rest", "mixed")
    )
    fitted = lambda campaign: make_effect(campaign, "sensor-drift").parameter("age").fitted
    assert any(record.begins_in_motion for record in mixed.fitted)
    moving = replace(mixed, records=tuple(replace(r, start="unknown") for r in mixed.traces))
    assert fitted(mixed) and not fitted(rest) and not fitted(moving)


def test_what_a_user_says_of_the_age_counts_and_a_choice_of_the_same_name_is_left_alone() -> None:
    class Warming(AbstractEffect):
        name = "warming"
        begins = choice("cold", "warm")
        size = amplitude("N")

    campaign = campaign_of(draw(4, (), device="oscillator", records=4, length=400, starts="mixed"))
    told = replace(campaign, settings={"sensor-drift": {"begins": "at-rest"}})
    assert make_effect(told, "sensor-drift").settings["begins"] == "at-rest"
    assert make_effect(campaign, "warming", {"warming": Warming}).begins == "cold"


def test_a_drift_is_found_back_from_a_record_cut_out_of_a_motion_and_one_from_rest() -> None:
    """Independent simulation: the first record begins when four fifths of the drift's time have gone."""
    case = poor_case(610, ("sensor-drift",), 0.08, 0.003)
    time = case.records[0].time
    from_rest = measure_again(case, "from rest", sine(9.0, 0.95 * case.device.frequency), time)
    campaign = campaign_of(replace(case, records=[*case.records, from_rest]))
    drift = make_effect(campaign, "sensor-drift")
    afresh = built_in()["sensor-drift"](campaign.device, {"begins": "at-rest"})
    linear = Model(campaign.device)
    assert fit(linear + drift, campaign).fitted.error_over_noise < 1.05
    assert fit(linear + afresh, campaign).fitted.error_over_noise > 1.1
