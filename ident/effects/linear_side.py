"""Which effects the linear model of a device is completed with, where its records ask for that: a constant, and further
modes. The effects say it themselves; of two that stand for the same the first that is known is taken, the library's."""

from __future__ import annotations

from typing import TYPE_CHECKING

from .effect import AbstractEffect

if TYPE_CHECKING:
    from .registry import Registry

MODE = ("travel", "period", "quality")
"""The parameters of a further mode, which a linear model starts: m/V, s, 1."""


def further_modes(known: Registry) -> tuple[str, ...]:
    """The names of the further modes that a device may have, the second mode first."""
    found: dict[int, str] = {}
    for effect in known.values():
        if effect.further_mode:
            found.setdefault(effect.further_mode, effect.name)
    return tuple(found[number] for number in sorted(found))


def constant_on(side: str, known: Registry) -> type[AbstractEffect] | None:
    """The constant that acts on that side, "force" or "sensor"."""
    return next((effect for effect in known.values() if effect.is_constant and effect.acts_on == side), None)
