"""An effect is a term of the model that can be switched off by a zero.

It says where it acts and, in one line of scalar code, what it does:

    class CubicStiffness(AbstractEffect):
        '''Cubic (Duffing) stiffness: restoring force k3 z³.'''
        name = "cubic-stiffness"
        k3 = amplitude("N/m^3")

        def force(self, state, drive, t):
            return -self.k3 * state.z**3

From this one definition come the simulation, its derivatives, the fit, the help page and the test for missing physics.
"""

from __future__ import annotations

import hashlib
from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import cached_property
from inspect import getattr_static
from pathlib import Path
from types import FunctionType, MappingProxyType
from typing import Any, ClassVar, NamedTuple, Self

import jax

from ..campaign.device import Device, Platform
from ..campaign.record import Trace
from .likeness import Likeness
from .parameter import Choice as Choice  # an effect file takes its words from here
from .parameter import Expected as Expected
from .parameter import Parameter as Parameter
from .parameter import amplitude as amplitude
from .parameter import choice as choice
from .parameter import shape as shape

_LIBRARY = f"{__package__}.library."

Scalar = Any  # a float outside, a traced JAX scalar inside a simulation


class State(NamedTuple):
    """State of the stage: displacement `z` (m), velocity `v` (m/s) and the effect's own `hidden` states. A term of the
    sensor finds in `z` what that reads, a velocity or an acceleration where it is one, and in `v` the rate of that."""

    z: Scalar
    v: Scalar
    hidden: tuple[Scalar, ...] = ()


class Drive(NamedTuple):
    """The measured drive: `V` (V), its `rate` (V/s), the record's own frequency `omega` (rad/s) and `gain` (N/V);
    `moving`, 1 in a record that begins in motion, when the drive had been on before its first sample, else 0; `order`
    of the derivative of the displacement that the sensor reads."""

    V: Scalar
    rate: Scalar
    omega: Scalar
    gain: Scalar
    moving: Scalar = 0.0
    order: Scalar = 0.0


class Linear(NamedTuple):
    """The linear part of a stage: `mass` kg, `omega` rad/s, `quality`, and the `push` of the drive, N/V."""

    mass: float
    omega: float
    quality: float
    push: float


class AbstractEffect:
    """A term of the equation of motion, of the drive, or of the sensor. Subclasses are final and immutable.

    A subclass sets `name`, declares its parameters, and writes any of

    - `force(state, drive, t)`: force on the stage, N;
    - `inertia(z)`, beside a `force`: mass that moves along with the stage at a displacement, kg; what its change does
      by the velocity, −m'(z) ż²/2, belongs to that force;
    - `drive(hidden, drive, t)`: force through the actuator, N; sees the drive and its own memory only;
    - `sensor(state, drive, t)`: what the sensor adds to what it reads of the motion, m;
    - `state0()` and `rate(state, drive, t)`: hidden states of its own and their time derivatives, in `hidden_units`;
    - `follow(hidden, before, drive, step)`, instead of a rate, for a memory of the drive alone that is known in closed
      form: the hidden states when the drive has gone from `before` to `drive` in a time `step`;
    - `settled(level, drive)`: hidden states of a memory of the drive alone where that has been a sine of amplitude
      `level` for ever, if that is known in closed form;
    - `begun(drive)`: the hidden states of a record that begins under voltage, if they are not `state0()`;
    - `caution(lowest, highest)`: what a reader of its numbers must know;
    - `prepare()`: whatever is constant along a trajectory, computed once and found in `self.prepared`.

    An effect that builds on another names it in `needs`, and finds it in `self.partner`. One with a kink, as friction
    or a stop, says so in `has_kink`: the steps that meet it are divided. (A loop that bends all along is cheaper in
    steps that are short everywhere.) `steps_per_period` is how finely a period of the resonance must be divided to
    follow an effect all along, or, if it has a kink, in the steady motions of sweeps, whose steps are all alike. One
    whose law implies simpler effects names them in `contains`: they are tried in its place. `form_of`: effects of
    which it is another form; it is looked for in their place only, where they leave more than noise.

    `alike`: the likenesses that it shares with others, the closest first. Of two that share one less is asked before
    both are named, and what separates them is told. `mistaken_for` names single effects, on one side or on both: the
    best of them is refitted in its place once all the others are in. It says what to try, and `alike` what to doubt:
    in a likeness all pass for one another at some frequency or level, too many to refit.

    Some belong to a linear device as well, and a model starts with them where its records ask for that: one whose only
    number is a constant force or reading says `is_constant`, and one that is another mode which of them, the second one
    `further_mode = 2`. One whose memory comes to rest at a mean, which acts like a law without memory, says
    `settles_to_a_mean`: it is not looked for in curves alone. `gains` are parameters through which the drive moves
    hidden states: where nothing is driven they only scale the motion that goes on in those, and keep the values that
    they start with.
    """

    name: ClassVar[str] = ""
    equation: ClassVar[str] = ""
    source: ClassVar[str] = ""
    mistaken_for: ClassVar[tuple[str, ...]] = ()
    alike: ClassVar[tuple[Likeness, ...]] = ()
    hidden_units: ClassVar[tuple[str, ...]] = ()
    platform_only: ClassVar[bool] = False
    contains: ClassVar[tuple[str, ...]] = ()
    needs: ClassVar[str] = ""
    form_of: ClassVar[tuple[str, ...]] = ()
    is_constant: ClassVar[bool] = False
    further_mode: ClassVar[int] = 0
    settles_to_a_mean: ClassVar[bool] = False
    gains: ClassVar[tuple[str, ...]] = ()
    steps_per_period: ClassVar[int] = 0
    has_kink: ClassVar[bool] = False
    acts_on: ClassVar[str] = ""

    parameters: ClassVar[tuple[Parameter, ...]] = ()
    choices: ClassVar[tuple[Choice, ...]] = ()

    device: Device
    values: Mapping[str, Scalar]
    settings: Mapping[str, str]
    partner: Any

    def __init_subclass__(cls) -> None:
        super().__init_subclass__()
        declared: dict[str, Any] = {}
        for one in cls.__mro__:  # its own before those of a base that several effects share
            declared |= {key: value for key, value in vars(one).items() if key not in declared}
        cls.parameters = tuple(value for value in declared.values() if isinstance(value, Parameter))
        cls.choices = tuple(value for value in declared.values() if isinstance(value, Choice))
        if "acts_on" not in vars(cls):
            cls.acts_on = next((side for side in ("sensor", "drive") if cls.overrides(side)), "force")

    def __init__(self, device: Device | None = None, settings: Mapping[str, str] | None = None, **values: Scalar):
        unknown = set(values) - {p.name for p in self.parameters}
        if unknown:
            raise TypeError(f"{type(self).__name__} has no parameter {', '.join(sorted(unknown))}")
        self._set(
            device=Platform() if device is None else device,
            settings=MappingProxyType(dict(settings or {})),
            values=MappingProxyType({p.name: values.get(p.name, p.default) for p in self.parameters}),
        )
        self._set(partner=None)
        if self._traced:
            _ = self.prepared  # now, outside the loop of the simulation

    def _set(self, **fields: Any) -> None:
        for key, value in fields.items():
            object.__setattr__(self, key, value)

    def __setattr__(self, key: str, value: Any) -> None:
        raise AttributeError(
            f"an effect is a value: use {type(self).__name__}(…, {key}={value!r}) to get a changed one"
        )

    def with_values(self, **values: Scalar) -> Self:
        """The same effect with other parameter values."""
        return type(self)(self.device, self.settings, **{**self.values, **values})

    def beside(self, partner: AbstractEffect) -> Self:
        """The same effect with the partner that it needs."""
        changed = type(self)(self.device, self.settings, **self.values)
        changed._set(partner=partner)
        return changed

    def on(self, device: Device) -> Self:
        """The same effect on another device."""
        return type(self)(device, self.settings, **self.values)

    def carrying(self, values: Mapping[str, Scalar], prepared: Any) -> Self:
        """The same effect with other numbers, those of `prepare` included: nothing is prepared again."""
        changed = object.__new__(type(self))
        changed.__dict__.update(self.__dict__, values=MappingProxyType(dict(values)), prepared=prepared)
        return changed

    def accompanied(self, partner: AbstractEffect) -> Self:
        """The same effect with another partner, its own numbers as they are."""
        changed = object.__new__(type(self))
        changed.__dict__.update(self.__dict__, partner=partner)
        return changed

    @property
    def key(self) -> tuple[Any, ...]:
        """What decides the compiled code: the class, its settings and, if it reads it, the device, but not the
        parameter values."""
        return (type(self), tuple(sorted(self.settings.items())), self.device if self._reads_device else None)

    @property
    def fingerprint(self) -> str | None:
        """The same in words that hold for every process; None if no file tells whether the class has changed."""
        cls, told = type(self), ""
        if not cls.__module__.startswith(_LIBRARY):
            written = next((f for f in vars(cls).values() if isinstance(f, FunctionType)), None)
            file = None if written is None else Path(written.__code__.co_filename)
            if file is None or "<locals>" in cls.__qualname__ or not file.is_file():
                return None
            told = hashlib.sha256(file.read_bytes()).hexdigest()
        return repr((cls.__module__, cls.__qualname__, told, *self.key[1:]))

    @property
    def _reads_device(self) -> bool:
        """Whether the device decides the code. Effects of the library read it in `prepare` alone; of others nobody
        knows."""
        cls = type(self)
        return cls.platform_only or cls.overrides("prepare") or not cls.__module__.startswith(_LIBRARY)

    @classmethod
    def overrides(cls, method: str) -> bool:
        """Whether this effect has physics of its own for `method`."""
        return getattr_static(cls, method) is not getattr_static(AbstractEffect, method)

    def parameter(self, name: str) -> Parameter:
        """The declaration of one parameter, as this effect's settings have it."""
        return next(p for p in self.declared() if p.name == name)

    def declared(self) -> tuple[Parameter, ...]:
        """The parameters that matter with the present settings."""
        unused = self.unused()
        return tuple(replace(p, fitted=p.fitted and p.name not in unused) for p in self.parameters)

    @classmethod
    def told_by(cls, records: Sequence[Trace]) -> Mapping[str, str]:
        """Words of its choices that the fitted records decide, where the campaign does not."""
        return {}

    @classmethod
    def in_its_form(cls, there: Linear, usual: Mapping[str, float]) -> tuple[Linear, dict[str, float]] | None:
        """The linear part and the numbers by which this effect makes the same linear device as the one, of `form_of`
        the only one, of which it is another form does beside a linear part, with its `usual` numbers; None if there
        are none. Without it the form begins where its score leads in the place of the other."""
        return None

    def unused(self) -> tuple[str, ...]:
        """Names of the parameters that the present settings leave without meaning."""
        return ()

    @property
    def _traced(self) -> bool:
        return any(isinstance(value, jax.Array) for value in self.values.values())

    @cached_property
    def prepared(self) -> Any:
        """What `prepare` found; from plain numbers only when it is asked for, for that costs dozens of compilations."""
        if self._traced:
            return self.prepare()
        with jax.ensure_compile_time_eval():  # plain numbers stay numbers, whoever asks first
            return self.prepare()

    def prepare(self) -> Any:
        return None

    def caution(self, lowest: float, highest: float) -> tuple[str, bool]:
        """What a reader of its fitted numbers must know, and whether that is a warning; ("", False) if nothing. The
        drives that they were fitted to go from `lowest` to `highest` Hz."""
        return "", False

    def can_be(self, stiffness: float, damping: float) -> bool:
        """Whether its numbers can be beside a linear part of that stiffness, N/m, and damping, N s/m: a refit that ends
        where they cannot bends the law to mimic another, and has not found this one."""
        return True

    def force(self, state: State, drive: Drive, t: Scalar) -> Scalar:
        return 0.0

    def inertia(self, z: Scalar) -> Scalar:
        return 0.0

    def drive(self, hidden: tuple[Scalar, ...], drive: Drive, t: Scalar) -> Scalar:
        return 0.0

    def sensor(self, state: State, drive: Drive, t: Scalar) -> Scalar:
        return 0.0

    def state0(self) -> tuple[Scalar, ...]:
        return ()

    def begun(self, drive: Drive) -> tuple[Scalar, ...]:
        return self.state0()

    def swing(self) -> Scalar:
        """How many times as large as what moves them its hidden states may become: a mode, as its quality says."""
        return 1.0

    def rate(self, state: State, drive: Drive, t: Scalar) -> tuple[Scalar, ...]:
        return ()

    def follow(self, hidden: tuple[Scalar, ...], before: Drive, drive: Drive, step: Scalar) -> tuple[Scalar, ...]:
        return hidden

    def settled(self, level: Scalar, drive: Drive) -> tuple[Scalar, ...]:
        return ()
