"""One record of a steady motion: what it cannot say must not be said."""

from __future__ import annotations

from experiments.hidden_effects.campaigns import campaign_of, poor_case
from ident.diagnosis.diagnose import diagnose, measure_next
from ident.diagnosis.linearised.regression import prepare
from ident.diagnosis.ranking.score import score
from ident.diagnosis.search.steps import Discovery
from ident.effects.registry import built_in
from ident.fit import fit
from ident.model import Model


def found(seed: int, *effects: str) -> Discovery:
    """What the loop says of the end of one sine's record, from a device with these effects of 8 % under 0.3 % noise."""
    campaign = campaign_of(poor_case(seed, effects, 0.08, 0.003))
    return diagnose(fit(Model(campaign.device), campaign)).discovery


def test_a_held_quality_factor_that_is_wrong_is_no_effect():
    said = found(610)
    assert "held" in said.final.estimates[1].flags
    assert said.verdict == "adequate"
    assert not said.steps


def test_a_drift_that_has_settled_ties_with_a_constant():
    said = found(610, "sensor-drift")
    assert said.verdict == "ambiguous"
    assert {"sensor-drift", "sensor-offset", "static-force"} == set(said.steps[0].tie_set)


def test_a_stop_that_would_have_to_pull_is_not_named_beside_a_quadratic_spring():
    said = found(5013, "quadratic-stiffness")
    assert said.verdict == "identified"
    assert [step.added for step in said.steps] == ["quadratic-stiffness"]
    assert said.final.fitted.error_over_noise < 1.02  # with the quality factor that the spring's harmonics tell


def test_one_name_is_told_beside_three_that_take_its_place():
    said = found(5017, "residual-stress")
    first = said.steps[0]
    assert "residual-stress" in first.tie_set
    if first.added != "residual-stress":
        assert "or residual-stress alone" in first.reasons[-1]
        proposed = measure_next(said, built_in())
        assert proposed and "residual-stress" in proposed[0].separates


def test_damping_of_the_wrong_sign_by_its_score_still_finds_a_motion_to_start_from():
    said = found(5023, "cubic-damping")
    assert "cubic-damping" in said.steps[0].tie_set
    assert said.confirmed["cubic-damping"] > 0.95


def test_a_sensor_that_saturates_is_judged_on_the_motion_and_not_on_its_readings():
    campaign = campaign_of(poor_case(610, ("sensor-nonlinearity",), 0.08, 0.003))
    start = fit(Model(campaign.device), campaign)
    assert start.fitted.error_over_noise > 10
    best = score(prepare(start), built_in())[0]
    assert best.name == "sensor-nonlinearity"
    assert best.predicted_gain > 0.95
