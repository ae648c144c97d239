"""A slice of the hidden-effect study: an effect of each side is found and named, and nothing where there is nothing."""

from __future__ import annotations

import pytest

from experiments.hidden_effects.campaigns import campaign_of
from experiments.hidden_effects.generator import draw
from ident.diagnosis.diagnose import diagnose
from ident.diagnosis.search.steps import Discovery
from ident.effects.registry import built_in
from ident.fit import fit
from ident.model import Model

# A few rivals instead of the whole library: each costs a compilation.
RIVALS = ("quadratic-stiffness", "quadratic-damping", "cubic-damping", "electrostriction", "sensor-crosstalk")


def discovered(seed: int, *effects: str, kind: str = "white") -> Discovery:
    case = draw(seed, effects, size=0.03, noise=0.003, noise_kind=kind, device="oscillator", records=4, length=800)  # type: ignore[arg-type]
    campaign = campaign_of(case)
    return diagnose(fit(Model(campaign.device), campaign), {name: built_in()[name] for name in RIVALS}).discovery


@pytest.mark.parametrize("effect", ["quadratic-damping", "electrostriction", "sensor-crosstalk"])
def test_a_hidden_effect_is_named(effect: str) -> None:
    found = discovered(31, effect)
    assert found.start.fitted.error_over_noise > 5
    assert [step.added for step in found.steps if step.role == "effect"] == [effect]
    assert found.verdict in ("identified", "ambiguous") and effect in found.steps[0].tie_set
    assert found.final.fitted.error_over_noise < 1.1
    assert found.final.holdout is not None and found.final.holdout.error_over_noise < 1.2


def test_nothing_is_named_where_nothing_is_hidden() -> None:
    found = discovered(32, kind="ar")
    assert found.verdict == "adequate"
    assert found.steps == () and found.remaining == ()
    assert found.final.fitted.error_over_noise < 1.1


@pytest.mark.parametrize("effect", ["power-law-stiffness", "voltage-damping"])
def test_a_law_that_the_library_has_not_gets_no_name_that_is_sure(effect: str) -> None:
    found = discovered(33, effect)
    assert found.start.fitted.error_over_noise > 5
    assert found.verdict in ("ambiguous", "not-in-library")
    assert found.lacking > 1e-3 or not found.steps


def test_an_impostor_that_leaves_most_of_the_misfit_is_no_answer() -> None:
    found = discovered(34, "second-mode")  # which is none of the rivals
    assert found.final.fitted.error_over_noise > 1.3
    assert found.verdict == "not-in-library"
