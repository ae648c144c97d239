"""A model is a device and a tuple of effects. `model + CubicStiffness()` is a model."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Any

from ..campaign.device import Device, Platform
from ..effects.dependence import told_in_reading
from ..effects.effect import AbstractEffect
from ..errors import UserError
from ..units import in_reading
from .linear import MASS, LinearPart, linear_part
from .parameters import ModelParameter

COARSE = 40
"""Solver steps in a period of the resonance, at least, where those that meet a kink are divided: a contact with a stop
ten times as stiff as the suspension lasts six of them."""

ABOVE_THE_DRIVE = 15.0
"""Times the drive's band lies the resonance that stands for none in a quasi-static model: there inertia changes the
answer by 1/15², and at a quality of as much damping shifts it by less."""
_OTHER_STAGE = 3.0  # times as heavy or as light: no stage of the given geometry
_LEAST_QUALITY = {"oscillator": 0.5, "overdamped": 1e-4, "base": 1e-2, "shaken": 1e-2}

_GAINS = {
    "base": "travel of the base per unit of the drive",
    "shaken": "acceleration of the base per unit of the drive",
}


@dataclass(frozen=True)
class Model:
    """A device with its effects; a value, changed only by making another one.

    **Arguments:**

    - `device`: what was measured; `effects`: the terms beyond the linear part, in order.
    - `start`: starting values of single parameters by full name (SI), as the campaign or a parent fit gave them.
    - `held`: full names of parameters that a fit must not move; `freed`: of those that it must; `undetermined`: of
      those that a fit holds because its records do not determine them.
    - `form` of the linear part: "oscillator"; "overdamped", the same without a least quality factor; "no-spring",
      whose second parameter is the decay time of a velocity, and whose first only sets the scale of time; "base", an
      oscillator whose spring and damper stand on what the drive moves; "shaken", one whose drive is the acceleration of
      its base, and whose accelerometer rides on the body;
      "quasi-static", an oscillator so far above the drive's band that its inertia does nothing there, both held.
    - `weighed`: whether the mass is a parameter, too, as where records with another load tell it.
    """

    device: Device
    effects: tuple[AbstractEffect, ...] = ()
    start: tuple[tuple[str, float], ...] = ()
    held: frozenset[str] = frozenset()
    freed: frozenset[str] = frozenset()
    undetermined: frozenset[str] = frozenset()
    form: str = "oscillator"
    weighed: bool = False

    def __post_init__(self) -> None:
        for effect in self.effects:
            if effect.platform_only and not isinstance(self.device, Platform):
                raise UserError(
                    f"the effect {effect.name} needs the geometry of the platform, but the device is an oscillator",
                    do="leave it out, or describe the platform in the device table",
                )
            if effect.needs and effect.needs not in self.names:
                raise UserError(f"the effect {effect.name} builds on {effect.needs}", do=f"add {effect.needs} too")
        object.__setattr__(self, "effects", tuple(effect.on(self.device) for effect in self.effects))

    def __add__(self, effect: AbstractEffect) -> Model:
        if effect.name in self.names:
            raise UserError(f"the model has the effect {effect.name} already", do="add each effect once")
        return replace(self, effects=(*self.effects, effect))

    def __sub__(self, name: str) -> Model:
        if name not in self.names:
            raise UserError(f"the model has no effect {name}", do=f"it has: {', '.join(self.names) or 'none'}")
        return replace(self, effects=tuple(e for e in self.effects if e.name != name))

    def beneath(self, effect: type[AbstractEffect]) -> tuple[AbstractEffect, ...]:
        """The effects on which one builds, and on which those build, the lowest first."""
        own = tuple(e for e in self.effects if e.name == effect.needs)
        return self.beneath(type(own[0])) + own if own else ()

    def carries(self, name: str) -> bool:
        """Whether another effect builds on this one, which then cannot go alone."""
        return any(effect.needs == name for effect in self.effects)

    @property
    def names(self) -> tuple[str, ...]:
        return tuple(effect.name for effect in self.effects)

    @property
    def linear(self) -> LinearPart:
        return linear_part(self.device)

    @property
    def numbers(self) -> int:
        """How many parameters a fit moves."""
        return sum(p.fitted for p in self.parameters)

    @property
    def steps_per_period(self) -> int:
        """Solver steps per period of the resonance that the sharpest effect needs."""
        return max((effect.steps_per_period for effect in self.effects), default=0)

    @property
    def coarsest(self) -> int:
        """The same where steps are divided that meet a kink."""
        needed = (COARSE if effect.has_kink else effect.steps_per_period for effect in self.effects)
        return max(needed, default=0)

    @property
    def key(self) -> tuple[Any, ...]:
        """What decides the compiled code."""
        return (self.kind, self.weighed, tuple(effect.key for effect in self.effects))

    @property
    def kind(self) -> str:
        """The form as far as it decides the equation of motion."""
        return self.form if self.form in ("no-spring", "base", "shaken") else ""

    @property
    def parameters(self) -> tuple[ModelParameter, ...]:
        """Every parameter of the model: frequency (Hz), quality factor and drive gain first, the mass (kg) where it is
        weighed, then effect by effect."""
        linear = self.linear
        own = [
            *self._times(),
            ModelParameter(f"{linear.prefix}.{linear.gain_name}", "m/V" if self.form == "base" else linear.gain_unit,
                           1e-12, False, kind="linear", expected=linear.expected_gain,
                           doc=_GAINS.get(self.form, "drive gain")),
        ]  # fmt: skip
        if self.weighed:
            own.append(ModelParameter(f"{linear.prefix}.mass", "kg", linear.mass, True, kind="linear",
                                      limits=(linear.mass / _OTHER_STAGE, linear.mass * _OTHER_STAGE),
                                      expected=linear.expected_mass, doc="mass of the stage"))  # fmt: skip
        for effect in self.effects:
            own += [
                ModelParameter(f"{effect.name}.{p.name}", p.unit, p.default, p.positive, p.fitted, p.kind,
                               p.grid, p.scale, p.limits, p.scale, p.doc, p.expected)
                for p in effect.declared()
            ]  # fmt: skip
        start = dict(self.start)
        return tuple(self._as_told(parameter, start) for parameter in own)

    def units(self, order: int) -> tuple[str, ...]:
        """Units of the parameters where the sensor reads the `order`-th derivative of the displacement."""
        read = {effect.name for effect in self.effects if order and told_in_reading(effect)}
        return tuple(in_reading(p.unit, order) if p.name.partition(".")[0] in read else p.unit for p in self.parameters)

    def _times(self) -> tuple[ModelParameter, ModelParameter]:
        """The first two parameters: those of spring and damper."""
        prefix = self.linear.prefix
        if self.form == "no-spring":
            return (
                ModelParameter(f"{prefix}.reference-frequency", "Hz", 1.0, True, False, kind="linear",
                               doc="time scale of the motion; there is no spring"),
                ModelParameter(f"{prefix}.decay-time", "s", 1.0, True, kind="linear", limits=(1e-6, 1e3),
                               limits_scale="duration", doc="time in which a velocity decays, mass over damping"),
            )  # fmt: skip
        if self.form == "quasi-static":
            return (
                ModelParameter(f"{prefix}.reference-frequency", "Hz", 1.0, True, False, kind="linear",
                               doc="far above all that is driven; inertia is left out"),
                ModelParameter(f"{prefix}.reference-quality", "1", 10.0, True, False, kind="linear",
                               doc="of what is left out, held"),
            )  # fmt: skip
        # Below one half nothing oscillates, and a missing effect could hide behind slow exponentials.
        least = _LEAST_QUALITY[self.form]
        nominal = self.linear.nominal_frequency or 1.0
        return (
            ModelParameter(f"{prefix}.frequency", "Hz", nominal, True, kind="linear",
                           doc="natural frequency of the unloaded linear part",
                           expected=self.linear.expected_frequency),
            ModelParameter(f"{prefix}.quality", "1", 30.0, True, kind="linear", limits=(least, 1e6),
                           doc="quality factor"),
        )  # fmt: skip

    def mass_of(self, values: Any) -> Any:
        """Mass of the linear part, kg, at values (m,) SI of the parameters."""
        return values[MASS] if self.weighed else self.linear.mass

    def spring_and_damper(self, first: Any, second: Any, mass: Any) -> tuple[Any, Any]:
        """Stiffness (N/m) and damping (N s/m) of the linear part from its first two parameters and its mass, kg."""
        if self.form == "no-spring":
            return 0.0 * first, mass / second
        omega = 2 * math.pi * first
        return mass * omega**2, mass * omega / second

    def times_of(self, stiffness: float, damping: float, mass: float, first: float) -> tuple[float, float]:
        """The inverse of `spring_and_damper`: the first two parameters of a linear part. Without a spring the `first`
        stays what it is."""
        if self.form == "no-spring":
            return first, mass / damping
        omega = math.sqrt(stiffness / mass)
        return omega / (2 * math.pi), mass * omega / damping

    def _as_told(self, parameter: ModelParameter, start: dict[str, float]) -> ModelParameter:
        if parameter.name in start:
            parameter = replace(parameter, value=start[parameter.name], scale="one", grid=())
        if parameter.name in self.held | self.undetermined:
            parameter = replace(parameter, fitted=False)
        elif parameter.name in self.freed:
            parameter = replace(parameter, fitted=True)
        return parameter

    def bind(self, values: Any) -> tuple[tuple[Any, Any, Any], tuple[AbstractEffect, ...]]:
        """Split a parameter vector into (frequency, quality, gain) and the effects carrying their own values."""
        linear, rest, bound = tuple(values[:3]), 4 if self.weighed else 3, []
        for effect in self.effects:
            names = [p.name for p in effect.parameters]
            bound.append(effect.with_values(**{n: values[rest + i] for i, n in enumerate(names)}))
            rest += len(names)
        by_name = {effect.name: effect for effect in bound}
        return linear, tuple(e.beside(by_name[e.needs]) if e.needs else e for e in bound)
