"""What an effect depends on, read off its own code: an effect that needs a coordinate fails where there is none."""

from __future__ import annotations

from typing import Literal

from .effect import AbstractEffect, Drive, State

Side = Literal["force", "drive", "sensor"]
COORDINATES = ("z", "v", "V", "dV", "t")
_SIDES: tuple[Side, ...] = ("force", "drive", "sensor")


def depends_on(effect: AbstractEffect) -> tuple[Side, tuple[str, ...]] | None:
    """The side on which an effect acts and its coordinates, out of `COORDINATES`; None if it has a memory, builds on
    another effect, or acts on two sides."""
    sides: list[Side] = [side for side in _SIDES if effect.overrides(side)]
    if effect.state0() or effect.needs or len(sides) != 1:
        return None
    [side] = sides
    return side, tuple(name for name in COORDINATES if not _works_without(effect, side, name))


def _works_without(effect: AbstractEffect, side: Side, missing: str) -> bool:
    z, v, voltage, rate, t = (None if name == missing else 1e-6 for name in COORDINATES)
    drive = Drive(voltage, rate, 1.0, 1.0)
    try:
        if side == "drive":
            effect.drive((), drive, t)
        else:
            getattr(effect, side)(State(z, v), drive, t)
    except (TypeError, ValueError, AttributeError, ArithmeticError):
        return False
    return True
