"""The coordinates of an effect are read off its code."""

import pytest

from ident.campaign.device import Platform
from ident.effects.dependence import depends_on
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
