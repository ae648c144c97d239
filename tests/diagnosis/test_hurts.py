"""Held-out records veto an effect if they are predicted worse; the one with the lowest noise floor does not alone."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace
from typing import Any, cast

from experiments.hidden_effects.campaigns import campaign_of
from experiments.hidden_effects.generator import draw
from ident.diagnosis.evidence.criterion import VERY_STRONG
from ident.diagnosis.evidence.held_out import behind_held_out, contradicted, hurts
from ident.effects.registry import built_in
from ident.fit import fit
from ident.fit.judge import RecordScore, combine
from ident.model import Model


def judged(*errors: float) -> Any:
    scores = [RecordScore(str(i), True, 100, error, 1.0, error, 100.0) for i, error in enumerate(errors)]
    return SimpleNamespace(scores=scores, holdout=combine(scores), campaign=SimpleNamespace(traces=()), readings=())


def test_one_record_far_above_its_floor_does_not_outvote_two_that_became_ten_times_better() -> None:
    before, after = judged(100.0, 80.0, 150.0), judged(10.0, 8.0, 250.0)
    assert cast(float, after.holdout.error_over_noise) > before.holdout.error_over_noise
    assert not hurts(before, after)


def test_what_makes_every_record_worse_hurts() -> None:
    assert hurts(judged(3.0, 2.0), judged(4.0, 2.5))


def test_what_lies_below_the_floor_counts_as_at_it() -> None:
    assert hurts(judged(1.0, 2.0), judged(0.5, 3.0))


def test_a_motion_without_bound_hurts_and_is_contradicted() -> None:
    away = judged(2.0, float("nan"))
    assert hurts(judged(300.0, 200.0), away) and not hurts(away, away)
    assert contradicted(away)


def test_held_out_records_tell_a_law_from_one_that_is_a_tenth_off() -> None:
    case = draw(44, ("cubic-stiffness",), size=0.05, noise=0.004, records=4, length=700, detail="plain")
    campaign = campaign_of(case)
    right = fit(Model(campaign.device) + built_in()["cubic-stiffness"](), campaign)
    values = right.values.copy()
    values[-2] *= 0.9
    wrong = SimpleNamespace(model=right.model, values=values)
    assert behind_held_out(campaign, right, wrong) > VERY_STRONG > 0 > behind_held_out(campaign, wrong, right)
    assert behind_held_out(campaign, right, right) == 0.0
    fitted = replace(campaign, records=tuple(record for record in campaign.records if not record.holdout))
    assert behind_held_out(fitted, right, wrong) == 0.0
