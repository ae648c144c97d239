"""A law that contains simpler ones gives way to two of them, and stays where it takes three."""

from __future__ import annotations

import numpy as np
import pytest

from experiments.hidden_effects.campaigns import campaign_of
from experiments.hidden_effects.generator import draw
from experiments.ring_downs.two_simple import LEVELS, found_in
from experiments.ring_downs.two_simple import draw as draw_pendulum
from ident.campaign.device import Oscillator, Platform
from ident.diagnosis.diagnose import diagnose, measure_next
from ident.diagnosis.ranking.starts import is_possible
from ident.effects.effect import AbstractEffect, shape
from ident.effects.library.coulomb_friction import CoulombFriction
from ident.effects.library.end_stop import EndStop
from ident.effects.library.quadratic_stiffness import QuadraticStiffness
from ident.effects.library.residual_stress import ResidualStress
from ident.effects.registry import built_in
from ident.fit import fit
from ident.fit.linear.guess import DataScales
from ident.model import Model

SCALES = DataScales(displacement=1e-5, velocity=0.03, voltage=9.0, period=2e-3, duration=0.04, slew=2e4)
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
    found = diagnose(fit(Model(campaign.device), campaign), {name: built_in()[name] for name in STIFFNESSES}).discovery
    assert {step.added for step in found.steps if step.role == "effect"} == set(hidden)


def test_where_one_name_does_as_well_as_two_both_answers_are_given() -> None:
    hidden = {"cubic-stiffness", "voltage-stiffness"}
    campaign = campaign_of(draw(5013, tuple(hidden), size=0.02, noise=0.003))
    found = diagnose(fit(Model(campaign.device), campaign), {name: built_in()[name] for name in STIFFNESSES}).discovery
    (step,) = found.steps
    assert found.verdict == "ambiguous" and hidden < set(step.tie_set)
    assert "together" in step.reasons[-1] and all(name in step.reasons[-1] for name in hidden)
    assert step.instead is not None and set(step.instead.names) == hidden
    for proposed in measure_next(found, built_in()):
        assert {"residual-stress", " and ".join(step.instead.names)} == set(proposed.separates)


@pytest.mark.parametrize("levels", LEVELS.values(), ids=LEVELS)
def test_drag_and_softening_of_a_decay_are_no_hysteresis(levels: tuple[float, ...]) -> None:
    """A loop with four numbers bends to both, and came first, alone and sure."""
    names = ("bouc-wen", "quadratic-damping", "cubic-damping", "cubic-stiffness")
    found = found_in(draw_pendulum(8104), levels, library={name: built_in()[name] for name in names})
    told = {name for step in found.steps for name in step.tie_set}
    assert {"quadratic-damping", "cubic-stiffness"} <= told and "cubic-damping" not in told
    assert found.verdict == "ambiguous" and any(step.instead for step in found.steps)


def test_a_friction_that_drives_is_no_friction() -> None:
    assert [p.name for p in CoulombFriction.parameters if p.one_sided] == ["friction"]


def test_a_stop_that_pulls_is_no_stop() -> None:
    stop = [p.name for p in EndStop.parameters if p.one_sided]
    assert stop == ["above", "below"]
    model = Model(Oscillator()) + EndStop()
    linear, shapes = [100.0, 20.0, 1e5], [1e-6, 1.0, 1.0]
    at = lambda values: np.array([*linear, *values, *shapes])
    possible = lambda model, *values: is_possible(model, at(values), model.effects[-1], SCALES)
    assert possible(model, 3.0, 2.0)
    assert possible(model, 3.0, -0.1)  # there is no lower stop
    assert not possible(model, 3.0, -2.0)
    # Beside another spring it bends that one's curve, and is no more a stop than alone.
    assert not possible(Model(Oscillator()) + QuadraticStiffness() + EndStop(), 1e9, 0.0, 3.0, -2.0)
    assert not possible(Model(Oscillator()) + CoulombFriction() + EndStop(), 1e-3, 0.02, 3.0, -2.0)


@pytest.mark.parametrize(("stress", "possible"), [(1e8, True), (-1e8, True), (3e11, False), (-3e11, False)])
def test_no_residual_stress_is_more_than_silicon_bears(stress: float, possible: bool) -> None:
    model = Model(Platform()) + ResidualStress(Platform())
    values = np.array([p.value for p in model.parameters])
    values[[p.name for p in model.parameters].index("residual-stress.sigma23")] = stress
    assert is_possible(model, values, model.effects[-1], SCALES) is possible


def test_limits_of_a_shape_that_may_be_negative_are_in_multiples_of_its_scale() -> None:
    class Kink(AbstractEffect):
        """A force that begins at a displacement."""

        name = "kink"
        place = shape("m", "where it begins", grid=(0.0,), scale="displacement", positive=False, limits=(-1.0, 1.0))

    model = Model(Oscillator()) + Kink()
    possible = lambda place: is_possible(model, np.array([100.0, 20.0, 1e5, place]), model.effects[-1], SCALES)
    assert possible(-0.9e-5) and not possible(-1.1e-5) and not possible(0.5)
