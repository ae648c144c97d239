"""Names at the end of a walk that never reached the noise: held-out records have the last word."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from ident.campaign.record import NoiseFloor
from ident.diagnosis.evidence import held_out
from ident.diagnosis.search import conclude
from ident.diagnosis.search.steps import Step


@pytest.fixture
def certain(monkeypatch: pytest.MonkeyPatch) -> None:
    """Nothing is left to chance, but everything to the errors."""
    monkeypatch.setattr(held_out, "_beyond_chance", lambda *_: True)


def step(added: str, held_out: float) -> Any:
    fit = SimpleNamespace(holdout=SimpleNamespace(error_over_noise=held_out))
    return SimpleNamespace(added=added, fit=fit, regression=None)


def predicted(missed: np.ndarray) -> Any:
    """A fit that misses a held-out record by so much."""
    record = SimpleNamespace(response=missed, noise=NoiseFloor(1.0), counted=np.ones(len(missed), bool), holdout=True)
    size = SimpleNamespace(error_over_noise=float(np.sqrt(np.mean(missed**2))))
    return SimpleNamespace(holdout=size, campaign=SimpleNamespace(traces=[record]), readings=[np.zeros(len(missed))])


@pytest.mark.parametrize(
    ("held_out_errors", "kept"),
    [
        ((6.4, 5.3, 5.8, 5.7), 2),  # the last is better than the one before it, not than the best
        ((6.4, 5.3, 5.8, 5.2), 4),
        ((6.4, 5.3), 2),
        ((17.9, 7.4), 1),  # the last is better than the one before it, not than what there was without effects
        ((6.4,), 1),
    ],
)
@pytest.mark.usefixtures("certain")
def test_a_name_counts_if_it_predicts_better_than_every_model_before(
    held_out_errors: tuple[float, ...], kept: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(conclude, "adequate", lambda _: False)
    monkeypatch.setattr(conclude, "hurts", lambda *_: False)
    steps = [step(f"law-{i}", error) for i, error in enumerate(held_out_errors)]
    regression: Any = None
    found = conclude._without_refuted(step("start", 6.2).fit, steps, regression)
    assert [one.added for one in found] == [f"law-{i}" for i in range(kept)]


@pytest.mark.parametrize(
    ("smooth", "share", "better"), [(True, 0.98, False), (False, 0.9, True), (True, 0.5, True), (True, 1.0, False)]
)
def test_a_prediction_is_better_by_more_than_chance(smooth: bool, share: float, better: bool) -> None:
    """A slow misfit says a few things only, however many its samples are."""
    noise = np.random.default_rng(3).normal(size=4000)
    missed = np.sin(np.arange(4000) / 300.0) if smooth else noise
    before, after = (predicted(missed * size) for size in (1.0, share))
    assert held_out.predicts_better(before, after) == better


@pytest.mark.parametrize(("foretold", "kept"), [(True, 2), (False, 1)])
@pytest.mark.usefixtures("certain")
def test_a_floor_that_the_fitted_records_alone_have_reached_excuses_nothing(
    foretold: bool, kept: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(conclude, "adequate", lambda _: True)
    monkeypatch.setattr(conclude, "foretold", lambda _: foretold)
    monkeypatch.setattr(conclude, "hurts", lambda *_: False)
    regression: Any = None
    found = conclude._without_refuted(step("start", 7.1).fit, [step("a", 4.36), step("b", 4.55)], regression)
    assert len(found) == kept


@pytest.mark.usefixtures("certain")
def test_held_out_records_are_asked_again_where_the_last_search_had_not_ended(monkeypatch: pytest.MonkeyPatch) -> None:
    """A refit that was left crawling predicts a little better than what it crawls to."""

    def model(held_out: float, converged: bool, ends_at: float = 0.0) -> Any:
        return SimpleNamespace(holdout=SimpleNamespace(error_over_noise=held_out), converged=converged, campaign=None,
                               values=None, model=ends_at)  # fmt: skip

    monkeypatch.setattr(conclude, "adequate", lambda _: False)
    monkeypatch.setattr(conclude, "hurts", lambda *_: False)
    monkeypatch.setattr(conclude, "is_long", lambda _: False)
    monkeypatch.setattr(conclude, "prepare", lambda _: None)
    monkeypatch.setattr(conclude, "working", lambda fit: fit)
    monkeypatch.setattr(conclude, "to_its_end", lambda last, _: model(last.model, True))
    first, crawling = model(3.50, True), model(3.49, False, ends_at=3.65)
    steps: list[Any] = [Step(name, 1.0, 1.0, (name,), "effect", one) for name, one in (("a", first), ("b", crawling))]
    found = conclude._on_all_samples(model(6.9, True), steps, lambda _: None)
    assert [one.added for one in found] == ["a"] and found[0].fit is first
