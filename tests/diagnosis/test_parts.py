"""A law that contains simpler ones gives way to two of them, and stays where it takes three."""

from __future__ import annotations

import pytest

from experiments.hidden_effects.campaigns import campaign_of
from experiments.hidden_effects.generator import draw
from ident.diagnosis.discover import discover
from ident.effects.library.coulomb_friction import CoulombFriction
from ident.effects.registry import built_in
from ident.model import Model

STIFFNESSES = ("residual-stress", "cubic-stiffness", "quadratic-stiffness", "voltage-stiffness")


@pytest.mark.parametrize(
    ("seed", "hidden"),
    [
        (612, ("quadratic-stiffness", "voltage-stiffness")),  # the composite comes first, and alone
        (302, ("residual-stress",)),
    ],
)
def test_what_is_named_is_what_is_there(seed: int, hidden: tuple[str, ...]) -> None:
    campaign = campaign_of(draw(seed, hidden, size=0.02, noise=0.003))
    found = discover(Model(campaign.device), campaign, {name: built_in()[name] for name in STIFFNESSES})
    assert {step.added for step in found.steps if step.role == "effect"} == set(hidden)


def test_where_one_name_does_as_well_as_two_both_answers_are_given() -> None:
    hidden = {"cubic-stiffness", "voltage-stiffness"}
    campaign = campaign_of(draw(5013, tuple(hidden), size=0.02, noise=0.003))
    found = discover(Model(campaign.device), campaign, {name: built_in()[name] for name in STIFFNESSES})
    (step,) = found.steps
    assert found.verdict == "ambiguous" and hidden < set(step.tie_set)
    assert "together" in step.reasons[-1] and all(name in step.reasons[-1] for name in hidden)


def test_a_friction_that_drives_is_no_friction() -> None:
    assert [p.name for p in CoulombFriction.parameters if p.one_sided] == ["friction"]
