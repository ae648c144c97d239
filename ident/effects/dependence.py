"""What an effect depends on, read off its own code: an effect that needs a coordinate fails where there is none."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from typing import Any, Literal

from ..campaign.device import Platform
from .dimensions import DISPLACEMENT, TIME, VELOCITY, VOLTAGE, made, typical_value
from .effect import AbstractEffect, Drive, State

Side = Literal["force", "drive", "sensor"]
COORDINATES = ("z", "v", "V", "dV", "t")
_SIDES: tuple[Side, ...] = ("force", "drive", "sensor")

_SMOOTH, _STEEP = 1.0, 1e6  # V/s: hardly any drive is slower, and no smooth one as fast


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


def told_in_reading(effect: AbstractEffect) -> bool:
    """Whether the metres of an effect are those of what the sensor reads, be that a velocity or an acceleration; one
    that asks for the order of that has a motion of its own."""
    if not effect.overrides("sensor") or effect.overrides("force"):
        return False
    state, drive = State(1e-6, 1e-6, effect.state0()), Drive(1e-6, 1e-6, 1.0, 1.0)
    return _answers(lambda order: effect.sensor(state, drive._replace(order=order), 0.0), None)


def runs_by_a_clock(effect: AbstractEffect) -> bool:
    """Whether an effect changes with the time since the first sample, its memory included."""
    state, drive = State(1e-6, 1e-6, effect.state0()), Drive(1e-6, 1e-6, 1.0, 1.0)
    asked = [lambda t: effect.drive(state.hidden, drive, t)] if effect.overrides("drive") else []
    asked += [lambda t, law=law: getattr(effect, law)(state, drive, t) for law in ("force", "sensor") if
              effect.overrides(law)]  # fmt: skip
    if effect.state0() and not effect.overrides("follow"):
        asked.append(lambda t: effect.rate(state, drive, t))
    return any(_answers(law, 0.0) and not _answers(law, None) for law in asked)


@cache
def needs_a_smooth_drive(effect: type[AbstractEffect]) -> bool:
    """Whether a law without a memory grows faster than the rate of the drive: what a jump does to the motion would be
    how steep somebody draws its edge."""
    if effect.needs or effect.hidden_units or not (effect.overrides("force") or effect.overrides("drive")):
        return False
    law = made(effect, {}, {}, {p.name: float(typical_value(p)) for p in effect.parameters}, Platform())

    def given(rate: float) -> float:
        drive = Drive(VOLTAGE, rate, 1.0, 1.0, 1.0)
        acts = law.drive((), drive, TIME) if law.overrides("drive") else 0.0
        return float(acts + (law.force(State(DISPLACEMENT, VELOCITY), drive, TIME) if law.overrides("force") else 0.0))

    try:
        steep, steeper = (abs(given(rate) - given(_SMOOTH)) / rate for rate in (_STEEP, 100 * _STEEP))
    except (TypeError, ValueError, AttributeError, ArithmeticError):  # what a file asks for is told elsewhere
        return False
    return steeper > 2 * steep


def _answers(law: Callable[[Any], object], asked: float | None) -> bool:
    try:
        law(asked)
    except (TypeError, ValueError, AttributeError, ArithmeticError):
        return False
    return True
