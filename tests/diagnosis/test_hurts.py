"""Held-out records veto an effect if they are predicted worse; the one with the lowest noise floor does not alone."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any, cast

from ident.diagnosis.evidence.held_out import contradicted, hurts
from ident.fit.judge import RecordScore, combine


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
