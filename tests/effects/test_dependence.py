"""The coordinates of an effect are read off its code."""

import pytest

from ident.campaign.device import Platform
from ident.effects.dependence import depends_on, needs_a_smooth_drive
from ident.effects.effect import AbstractEffect
from ident.effects.registry import built_in

KNOWN = {
    "cubic-stiffness": ("force", ("z",)),
    "coulomb-friction": ("force", ("v",)),
    "squeeze-film-damping": ("force", ("z", "v")),
    "voltage-stiffness": ("force", ("z", "V")),
    "residual-stress": ("force", ("z", "V")),
    "damping-drift": ("force", ("v", "t")),
    "pzt-hysteresis": ("drive", ("V", "dV")),
    "electrostriction": ("drive", ("V",)),
    "sensor-nonlinearity": ("sensor", ("z",)),
    "sensor-offset": ("sensor", ()),
    "stribeck-friction": ("force", ("v",)),
    "creep": None,  # memories
    "bouc-wen": None,
    "arch-force": None,  # builds on residual stress
}


@pytest.mark.parametrize("name", KNOWN)
def test_an_effect_depends_on_what_it_uses(name: str) -> None:
    assert depends_on(built_in()[name](Platform())) == KNOWN[name]


@pytest.mark.parametrize("effect", built_in().values(), ids=lambda effect: effect.name)
def test_only_a_cube_of_the_rate_of_the_drive_asks_for_a_smooth_one(effect: type[AbstractEffect]) -> None:
    """What a law of V̇ does at a jump is how steep its edge is drawn, unless it is linear in V̇ or remembers V."""
    assert needs_a_smooth_drive(effect) == (effect.name == "pzt-hysteresis")
