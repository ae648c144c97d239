"""Effects that were added are questioned again, and stay where the model cannot do without them."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any, cast

import pytest

from experiments.hidden_effects.campaigns import campaign_of
from experiments.hidden_effects.generator import draw
from ident.diagnosis.linearised.regression import prepare
from ident.diagnosis.linearised.trajectory import Diverged
from ident.diagnosis.search import prune as pruning
from ident.diagnosis.search.conclude import _beside_its_even
from ident.diagnosis.search.steps import Step
from ident.effects.registry import built_in
from ident.fit import Fit, fit
from ident.model import Model, make_effect

NAMES = ("cubic-stiffness", "quadratic-damping")
LIBRARY = {name: built_in()[name] for name in (*NAMES, "coulomb-friction")}


@pytest.fixture(scope="module")
def start() -> Fit:
    campaign = campaign_of(draw(41, NAMES, size=0.03, noise=0.005, records=3, length=800))
    return fit(Model(campaign.device), campaign)


def fitted(start: Fit, *names: str) -> Fit:
    model = start.model
    for name in names:
        model = model + make_effect(start.campaign, name, LIBRARY)
    return fit(model, start.campaign)


def test_a_superfluous_effect_is_taken_out_and_the_true_ones_stay(start: Fit) -> None:
    names = ["coulomb-friction", *NAMES]
    needed = pruning.prune(fitted(start, *names), names, LIBRARY, prepare(start), lambda _: None)
    assert needed.names == NAMES and needed.alike == ()
    assert needed.fit.fitted.error_over_noise < 1.1


def test_an_effect_without_which_the_motion_has_no_bound_stays(start: Fit, monkeypatch: pytest.MonkeyPatch) -> None:
    last, first = fitted(start, *NAMES), prepare(start)

    def unbounded(one: Fit, *rest: Any) -> Any:
        if one.model.names != NAMES:
            raise Diverged("a.csv")
        return prepare(one, *rest)

    monkeypatch.setattr(pruning, "prepare", unbounded)
    assert pruning.prune(last, list(NAMES), LIBRARY, first, lambda _: None).names == NAMES


def test_all_that_promise_nearly_as_much_as_the_best_are_tried_in_its_place(monkeypatch) -> None:
    drops = {"sensor-lag": 1000.0, "cubic-stiffness": 995.0, "quadratic-stiffness": 990.0, "end-stop": 900.0}
    scored = [SimpleNamespace(name=name, drop=drop) for name, drop in drops.items()]
    monkeypatch.setattr(pruning, "score", lambda *_: scored)
    monkeypatch.setattr(pruning, "significant", lambda found: found)
    tried = pruning.rivals("squeeze-film-damping", cast(Any, None), built_in())
    assert [c.name for c in tried] == ["sensor-lag", "cubic-stiffness", "quadratic-stiffness"]


def test_a_rival_that_does_as_well_in_its_place_is_told_with_what_would_tell_them_apart() -> None:
    step = Step("quadratic-stiffness", 1.0, 1.0, ("quadratic-stiffness",), "effect", cast(Any, None))
    told = _beside_its_even(step, {"quadratic-stiffness": "cubic-stiffness"}, built_in())
    assert told.tie_set == ("quadratic-stiffness", "cubic-stiffness")
    assert "second harmonic" in told.reasons[0]
    assert _beside_its_even(told, {"quadratic-stiffness": "cubic-stiffness"}, built_in()) is told


@pytest.mark.parametrize(("alone", "stands"), [(16.0, False), (2.0, True)])
def test_a_rival_that_needs_what_refines_is_none(monkeypatch: pytest.MonkeyPatch, alone: float, stands: bool) -> None:
    """Without the finer shape a quadratic spring leaves little, and cogs leave what that had said for them."""

    def fit_of(*names: str, chi2: float) -> Any:
        model = SimpleNamespace(names=names, carries=lambda _: False)
        return SimpleNamespace(model=model, fitted=SimpleNamespace(chi2=chi2))

    last = fit_of("quadratic-stiffness", "residual-stress", chi2=1010.0)
    after = fit_of("cogging", "residual-stress", chi2=1000.0)
    less = {id(last): fit_of("quadratic-stiffness", chi2=1012.0), id(after): fit_of("cogging", chi2=1012.0 + alone)}
    monkeypatch.setattr(pruning, "try_without", lambda fit, *_: less[id(fit)])
    first = cast(Any, SimpleNamespace(above_noise=1000.0, fit=None))
    assert pruning._unrefined("quadratic-stiffness", last, "cogging", after, first) == stands
