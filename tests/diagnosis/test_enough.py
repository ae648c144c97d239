"""When a model is good enough, and what a change may cost."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from ident.campaign import read_campaign
from ident.diagnosis.evidence import held_out
from ident.diagnosis.evidence.enough import (
    adequate,
    another_law,
    floor_of,
    known_floor_of,
    not_worth_adding,
    role_of,
    superfluous,
    worth_a_name,
)
from ident.diagnosis.evidence.held_out import foretold, hurts, hurts_more
from ident.effects.registry import built_in
from ident.fit.judge import Score

N = 10_000
WHITE = np.random.default_rng(1).normal(size=N)
WHITE /= np.sqrt(np.mean(WHITE**2))


def regression(error: float, reached: float | None = None, doubt: float = 0.03, freedom: int = 5) -> Any:
    """A stand-in with an error over noise, the one that its fit has `reached`, and the doubt of its noise floors."""
    records = [SimpleNamespace(noise=SimpleNamespace(relative_error=doubt))]
    fit = SimpleNamespace(campaign=SimpleNamespace(fitted=records, fitted_sweeps=()), freedom=freedom)
    residual = error * WHITE
    excess = max(N * (error**2 - 1), 1e-9)
    return SimpleNamespace(
        whitenings=(), best_chi2=N * error**2, excess=excess,
        chi2=N * error**2, fit_chi2=N * (reached or error) ** 2, n=N, fit=fit, residual=residual, instead_of=None,
        to_explain=excess, above_noise=max(N * (error**2 - 1), np.sqrt(2 * N)),
    )  # fmt: skip


def test_the_doubt_of_a_noise_floor_excuses_what_no_effect_explains() -> None:
    assert adequate(regression(1.08)) and not adequate(regression(1.08, doubt=0.0))
    excess = regression(1.08).excess
    assert adequate(regression(1.08), promise=0.3 * excess) and not adequate(regression(1.08), promise=0.8 * excess)
    assert adequate(regression(1.04), promise=regression(1.04).excess)  # within what is allowed to any model


def test_one_floor_that_nobody_knows_excuses_no_error_beside_others() -> None:
    t = np.arange(400.0)
    (trace,) = read_campaign({"t_s": t, "u_V": np.sin(t), "y_um": np.cos(t) + 0.01 * WHITE[:400]}).traces
    doubted = lambda *errors: [replace(trace, noise=replace(trace.noise, relative_error=error)) for error in errors]
    assert floor_of(doubted(0.5, 0.4)) == pytest.approx(1.95)
    assert floor_of(doubted(0.02, 0.02, 1.0)) == known_floor_of(doubted(0.5, 0.4)) == pytest.approx(1.25)


def test_a_floor_that_is_too_high_does_not_hide_a_law() -> None:
    """Of the first decays of a liquid, at 1.04 of a floor of coloured noise doubtful by 9 %, one law took a third."""
    assert not adequate(regression(1.04, doubt=0.09), promise=0.34 * N * 1.04**2)


def test_what_differs_between_two_passes_of_a_curve_is_smooth_noise_that_an_effect_explains() -> None:
    """A beam between magnets: at 1.07 of a floor that its way back had told, a stop took most of the rest, and the
    jumps of three other levels were predicted wrong."""
    curve = regression(1.08)
    curve.fit.campaign.fitted_sweeps, curve.fit.campaign.fitted = curve.fit.campaign.fitted, ()
    assert adequate(curve, promise=0.8 * curve.excess)


def test_a_term_under_one_percent_is_added_if_it_explains_most_of_what_is_left() -> None:
    first, now = regression(13.0), regression(1.08)
    left = now.chi2 - N
    assert not not_worth_adding(now, 0.8 * left, first)
    assert not_worth_adding(now, 0.3 * left, first)
    assert not_worth_adding(regression(1.0), 0.08 * N, first)


def test_the_library_is_asked_for_as_long_as_a_verdict_would_miss_a_law() -> None:
    """A piezo stage with plays had left 0.3 % of its first excess where scores cannot be believed: no refit was tried,
    and its creep and its offset became a table of twenty numbers."""
    first = regression(62.0)
    excess = first.chi2 - N
    assert another_law(0.003 * excess, first) and not another_law(0.0005 * excess, first)


def test_a_refit_that_a_limit_stopped_does_not_do_without_the_term() -> None:
    first, full = regression(13.0), regression(1.0, freedom=7)
    assert superfluous(regression(1.001), full, first)
    assert superfluous(
        regression(1.05), full, first
    )  # at the floor, and the loss is less than laws of a kind differ by
    assert not superfluous(regression(1.05, reached=1.48), full, first)


def test_nothing_is_worth_a_name_where_the_first_model_lies_below_its_floor() -> None:
    """A share of an excess that is negative is less than any gain, and every refinement would be an effect."""
    assert not worth_a_name(1.0, regression(0.97)) and not another_law(1e-3, regression(0.97))
    assert worth_a_name(20.0, regression(0.97))


def test_a_small_term_that_leaves_nothing_of_what_it_met_is_an_effect() -> None:
    """A magnet's quadratic force moved a free decay's frequency by little, and left 10 of 110 noise floors when it was
    missing and 1.00 when not: no refinement of a cubic's shape does that. One that leaves some of it is one, and so is
    one whose floor is not known well enough to see that."""
    first, cubic = regression(110.0), regression(10.6, doubt=0.02)
    law, constant = (built_in()[name]() for name in ("quadratic-stiffness", "sensor-offset"))
    assert role_of(law, cubic, 1.01 * N, first) == "effect"
    assert role_of(law, cubic, 1.2 * N, first) == "shape-refinement"
    assert role_of(law, regression(3.0), 1.0 * N, first) == "shape-refinement"
    assert role_of(constant, cubic, 1.2 * N, first) == "effect"  # it has no shape to refine


def heldout(missed: np.ndarray) -> dict[str, Any]:
    """Fields of a fit that misses so much of one held-out record, in noise floors."""
    counted = np.ones(N, dtype=bool)
    record = SimpleNamespace(response=missed, noise=SimpleNamespace(sigma=1.0), counted=counted, holdout=True)
    error = float(np.sqrt(np.mean(missed**2)))
    scores = (SimpleNamespace(holdout=True, error_over_noise=error, n=N),)
    return {"campaign": SimpleNamespace(traces=(record,)), "readings": (np.zeros(N),), "scores": scores}


@pytest.mark.parametrize(("fitted", "held", "more"), [(0.99, 1.23, False), (1.05, 1.25, True), (0.99, 1.18, False)])
def test_held_out_error_of_another_law_is_weighed_against_what_fitted_records_gain(
    fitted: float, held: float, more: bool
) -> None:
    score = lambda error: Score(N, 1.0, 1.0, error, 10.0)
    before: Any = SimpleNamespace(fitted=score(1.06), holdout=score(1.19), **heldout(1.19 * WHITE))
    after: Any = SimpleNamespace(fitted=score(fitted), holdout=score(held), **heldout(held * WHITE))
    assert np.isclose(before.fitted.chi2, N * 1.06**2)
    assert hurts_more(before, after) is more
    assert not hurts_more(before, SimpleNamespace(fitted=score(fitted), holdout=None))  # type: ignore[arg-type]


def test_held_out_records_that_say_one_thing_do_not_contradict() -> None:
    score = lambda error: Score(N, 1.0, 1.0, error, 10.0)
    slow = np.sqrt(2) * np.sin(2 * np.pi * 3 * np.arange(N) / N)
    for missed, contradict in ((WHITE, True), (slow, False)):
        before: Any = SimpleNamespace(holdout=score(50.0), **heldout(50.0 * missed))
        after: Any = SimpleNamespace(holdout=score(53.0), **heldout(53.0 * missed))
        assert hurts(before, after) is contradict


@pytest.mark.parametrize(("error", "at_floor"), [(1.4, True), (1.6, False), (4.5, False)])
def test_what_errors_of_parameters_and_floors_make_of_held_out_records_is_foretold(
    error: float, at_floor: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(held_out, "expected_error", lambda _: 1.2)
    records = [SimpleNamespace(holdout=held, noise=SimpleNamespace(relative_error=0.09)) for held in (False, True)]
    fit: Any = SimpleNamespace(
        campaign=SimpleNamespace(records=records), holdout=SimpleNamespace(error_over_noise=error)
    )
    assert foretold(fit) == at_floor
    fit.holdout = None
    assert foretold(fit)
