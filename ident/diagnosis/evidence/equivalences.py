"""What is known of two effects before any record: whether they pass for one another, why, and what tells them apart.

The effects tell it themselves, in `alike` and `mistaken_for`; so one of the user's own has its place here as well.
"""

from __future__ import annotations

from ...effects.effect import AbstractEffect
from ...effects.likeness import Likeness
from ...effects.registry import Registry

_OTHERWISE = "records at other levels and frequencies"
_SIDES = "the same level below, at and above the resonance: it amplifies and turns a force, but not a reading"

Kind = type[AbstractEffect]


def equivalence(one: Kind, other: Kind) -> Likeness | None:
    """The closest known relation between two effects."""
    return next((likeness for likeness in one.alike if likeness in other.alike), None)


def what_separates(one: Kind, other: Kind) -> str:
    """What tells two effects apart, in words."""
    known = equivalence(one, other)
    if known is not None:
        return known.separate
    sides = {one.acts_on, other.acts_on}
    return _SIDES if "sensor" in sides and len(sides) == 2 else _OTHERWISE


def exact_partners(effect: Kind, library: Registry, linear: bool, in_motion: bool) -> list[str]:
    """Effects of the library that no record tells from this one, of a linear device or begun in motion."""
    exact = {e for e in effect.alike if (e.linear_exact and linear) or (e.in_motion and in_motion)}
    return sorted(name for name, other in library.items() if name != effect.name and exact & {*other.alike})


def mistaken(effect: Kind, library: Registry) -> set[str]:
    """Effects of the library for which one is mistaken, whichever of the two says so."""
    return {name for name, other in library.items() if name in effect.mistaken_for or effect.name in other.mistaken_for}
