"""A small term is an effect where no bending of the laws before it says as much, and a refinement where that does."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from experiments.hidden_effects.campaigns import campaign_of
from experiments.hidden_effects.generator import draw
from ident.campaign.device import Oscillator
from ident.diagnosis.linearised.regression import Regression, prepare
from ident.diagnosis.search.lacking import says_more_than_shapes
from ident.effects.registry import built_in
from ident.fit import fit
from ident.model import Model


def regressions(seed: int, hidden: tuple[str, ...], *named: str, **more: Any) -> tuple[Regression, Regression]:
    """With all names and with all but the last, on a device with something hidden."""
    campaign = campaign_of(draw(seed, hidden, **{"size": 0.05, "noise": 0.0005, "device": "oscillator"} | more))
    made: Callable[[tuple[str, ...]], Regression] = lambda names: prepare(
        fit(Model(Oscillator(), tuple(built_in()[name]() for name in names)), campaign)
    )
    return made(named), made(named[:-1])


def test_a_damping_bends_no_spring() -> None:
    """A cubic spring of twenty noise floors beside a drag of one: the drag was told as a finer shape of the spring."""
    assert says_more_than_shapes(
        *regressions(9901, ("cubic-stiffness", "quadratic-damping"), "cubic-stiffness", "quadratic-damping")
    )


def test_what_mimics_the_shape_of_a_spring_is_no_effect() -> None:
    """Here the spring eases off, z³/(1 + s z²), and the sensor's cubic term takes a part of what a cubic one leaves."""
    assert not says_more_than_shapes(*regressions(9902, ("cubic-stiffness",), "cubic-stiffness", "sensor-nonlinearity"))


def test_that_bending_takes_many_numbers_is_no_reason() -> None:
    """Here the sensor's term takes one of χ², and a bent spring 165; two dozen numbers had cost more than these."""
    few = {"records": 4, "length": 600, "noise": 0.003}
    after, met = regressions(9902, ("cubic-stiffness",), "cubic-stiffness", "sensor-nonlinearity", **few)
    assert not says_more_than_shapes(after, met)


def test_of_a_law_with_a_memory_nothing_is_said() -> None:
    assert not says_more_than_shapes(*regressions(9903, ("bouc-wen", "cubic-stiffness"), "bouc-wen", "cubic-stiffness"))
