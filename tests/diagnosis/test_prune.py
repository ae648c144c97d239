"""Effects that were added are questioned again, and stay where the model cannot do without them."""

from __future__ import annotations

from typing import Any

import pytest

from experiments.hidden_effects.campaigns import campaign_of
from experiments.hidden_effects.generator import draw
from ident.diagnosis.linearised.regression import prepare
from ident.diagnosis.linearised.trajectory import Diverged
from ident.diagnosis.search import prune as pruning
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
