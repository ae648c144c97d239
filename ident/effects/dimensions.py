"""Unit errors in an effect are caught when it is registered, by changing the units of the world.

A formula is right in its dimensions if and only if its result scales as it should when metre, kilogram, second and
volt are replaced by other units. So the effect is evaluated twice, once in SI and once with every input converted to
arbitrary units; a force that does not convert like a force has a unit error or a hard-coded number with a hidden
unit.

Source: G. I. Barenblatt, Scaling, 1996, §1.1 (covariance of physical laws).
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import fields, replace
from itertools import product
from typing import TYPE_CHECKING, Any

import numpy as np

from ..campaign.device import Device, Platform
from ..errors import UserError
from ..units import exponents
from .effect import AbstractEffect, Drive, Parameter, State

if TYPE_CHECKING:
    from .registry import Registry

_WORLD = {"kg": 1.7, "m": 2.3, "s": 0.6, "V": 3.1}  # one SI unit, measured in the other world's units
DISPLACEMENT, VELOCITY, VOLTAGE, TIME = 3e-6, 2e-2, 5.0, 1e-3  # m, m/s, V, s: a typical state
_TOLERANCE = 1e-6
MOTIONS = (1.0, -4.0)  # times the typical state: a contact or a slip shows on one side, or far out, only


def _factor(unit: str) -> float:
    return float(np.prod([_WORLD[base] ** power for base, power in exponents(unit).items()]))


def check_units(effect: type[AbstractEffect], known: Registry, where: str = "") -> None:
    """Test that each formula of an effect has the dimension of its side, for every choice of its settings; `known`:
    the effects that it may build on.

    **Raises:** UserError naming the formula and the declared units if it has not.
    """
    for parameter in effect.parameters:
        try:
            exponents(parameter.unit)
        except UserError as error:
            raise UserError(f"{effect.name}.{parameter.name}: {error.what}", where=where, do=error.do) from error
    names = [setting.name for setting in effect.choices]
    for words, motion in product(product(*(setting.words for setting in effect.choices)), MOTIONS):
        _check_formulas(effect, known, dict(zip(names, words, strict=True)), motion, where)


def _check_formulas(
    effect: type[AbstractEffect], known: Registry, settings: dict[str, str], motion: float, where: str
) -> None:
    here, there = (_evaluate(effect, known, settings, motion, scaled) for scaled in (False, True))
    for formula, (value, unit) in here.items():
        expected = value * _factor(unit)
        if not abs(there[formula][0] - expected) <= _TOLERANCE * max(abs(expected), 1e-300):  # so that NaN is caught
            declared = ", ".join(f"{p.name} in {p.unit}" for p in effect.parameters)
            raise UserError(
                f"the formula {formula} of {effect.name} does not come out in {unit} ({declared})",
                where=where,
                do="correct a unit, or declare a number that carries a unit as a parameter",
            )


def _evaluate(
    effect: type[AbstractEffect], known: Registry, settings: dict[str, str], motion: float, scaled: bool
) -> dict[str, tuple[float, str]]:
    """Value and unit of each formula of the effect, for arbitrary inputs."""
    to = (lambda value, unit: value * _factor(unit)) if scaled else (lambda value, unit: value)
    device = _in_other_units(Platform()) if scaled else Platform()
    instance = made(effect, known, settings, _typical_values(effect, to), device, to)
    hidden = tuple(to(motion * typical(unit), unit) for unit in effect.hidden_units)
    state = State(to(motion * DISPLACEMENT, "m"), to(motion * VELOCITY, "m/s"), hidden)
    drive = Drive(to(motion * VOLTAGE, "V"), to(3e3, "V/s"), to(2e3, "1/s"), to(1e-4, "N/V"), 1.0)
    t = to(TIME, "s")
    found: dict[str, tuple[float, str]] = {}
    if effect.overrides("force"):
        found["force"] = (float(instance.force(state, drive, t)), "N")
    if effect.overrides("inertia"):
        found["inertia"] = (float(instance.inertia(state.z)), "kg")
    if effect.overrides("drive"):
        found["drive"] = (float(instance.drive(hidden, drive, t)), "N")
    if effect.overrides("sensor"):
        found["sensor"] = (float(instance.sensor(state, drive, t)), "m")
    if effect.overrides("rate"):
        rates = instance.rate(state, drive, t)
        _one_for_each(instance, len(rates), "rates")
        for i, (value, unit) in enumerate(zip(rates, effect.hidden_units, strict=True)):
            found[f"rate[{i}]"] = (float(value), f"{unit}/s" if unit != "1" else "1/s")
    if effect.overrides("follow"):
        if effect.overrides("force") or effect.overrides("sensor"):
            raise UserError(
                f"{effect.name} follows the drive and acts on more than the drive",
                do="write `rate` instead of `follow`, or `drive` instead of `force` and `sensor`",
            )
        followed = instance.follow(hidden, drive, drive, t)
        _one_for_each(instance, len(followed), "values of `follow`")
        for i, (value, unit) in enumerate(zip(followed, effect.hidden_units, strict=True)):
            found[f"follow[{i}]"] = (float(value), unit)
    return found


def _one_for_each(effect: AbstractEffect, count: int, what: str) -> None:
    states = len(effect.state0())
    if not count == states == len(effect.hidden_units):
        raise UserError(
            f"{effect.name} has {states} hidden states, {count} {what} and {len(effect.hidden_units)} hidden_units",
            do="give every hidden state one of each",
        )


def made(
    effect: type[AbstractEffect],
    known: Registry,
    settings: Mapping[str, str],
    values: Mapping[str, Any],
    device: Device,
    to: Callable[[float, str], float] = lambda value, unit: value,
) -> AbstractEffect:
    """An effect with these values, beside the one that it builds on, which has typical values turned by `to`.

    **Raises:** UserError if that one is not known.
    """
    instance = effect(device, settings, **values)
    if not effect.needs:
        return instance
    if effect.needs not in known:
        raise UserError(
            f"the effect {effect.name} builds on {effect.needs}, which is not known here",
            do="check the word; an effect of your own must be defined above, or in a file that is listed before",
        )
    partner = known[effect.needs]
    return instance.beside(made(partner, known, {}, _typical_values(partner, to), device, to))


def _typical_values(effect: type[AbstractEffect], to: Callable[[float, str], float]) -> dict[str, float]:
    return {p.name: to(typical_value(p), p.unit) for p in effect.parameters}


def typical_value(parameter: Parameter) -> float:
    """A value of typical size, so that the formula is tested where it will be used."""
    if parameter.kind == "amplitude":
        return parameter.default or 0.7
    size = {
        "displacement": 5e-6,
        "velocity": 3e-2,
        "voltage": 8.0,
        "period": 2e-3,
        "duration": 0.03,
        "induction": 3e2,
        "nearness": 1e6,
        "squared_nearness": 1e12,
        "slowness": 5e-5,
        "per_squared_velocity": 1e3,
        "one": 1.0,
    }
    return parameter.default * size[parameter.scale] or 0.7


def typical(unit: str) -> float:
    """A hidden state of typical size."""
    return {"m": 0.4 * DISPLACEMENT, "m/s": 0.4 * VELOCITY, "V": 0.3 * VOLTAGE, "N": 1e-4}.get(unit, 0.3)


_FIELD_UNITS = {"modulus": "Pa", "thickness": "m", "width": "m", "length": "m", "mass": "kg", "voltage": "V",
                "frequency": "Hz", "poisson": "1"}  # fmt: skip


def _in_other_units(device: Platform) -> Platform:
    changed: dict[str, Any] = {"beam_end": tuple(x * _factor("m") for x in device.beam_end)}
    for field in fields(device):
        unit = next((u for word, u in _FIELD_UNITS.items() if word in field.name), None)
        if unit is not None:
            changed[field.name] = getattr(device, field.name) * _factor(unit)
    return replace(device, **changed)
