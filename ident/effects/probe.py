"""Every law of an effect is run before a fit, at rest and where devices are: what it returns, its values, its slopes.

A fit differentiates the simulation, and one slope that is no number makes every uncertainty one. A law can be finite at
rest and its slope not, and records begin at rest.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from itertools import product
from typing import TYPE_CHECKING, Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np

from ..campaign.device import Platform
from ..errors import UserError
from ..runtime import compiler_options, configure
from .dimensions import DISPLACEMENT, MOTIONS, TIME, VELOCITY, VOLTAGE, made, typical, typical_value
from .effect import AbstractEffect, Drive, State
from .mistakes import place_of_method
from .written import LAWS

if TYPE_CHECKING:
    from .registry import Registry

_FINITE = (
    "keep both branches finite, jnp.where on the argument too: "
    "jnp.where(x > 0, jnp.sqrt(jnp.where(x > 0, x, 1.0)), 0.0); jnp.sqrt(x**2) is jnp.abs(x)"
)
_STEP = 1e-4  # s, between two points of a drive that is followed


class _Point(NamedTuple):
    """Where an effect is evaluated; its laws are differentiated by all of it."""

    z: Any
    v: Any
    hidden: tuple[Any, ...]
    V: Any
    rate: Any
    values: Mapping[str, Any]


def check_runs(effect: type[AbstractEffect], known: Registry) -> None:
    """Test, for every choice of its settings, that each law returns one finite number for each that is expected, and
    has finite slopes by the state, the drive and the parameters; `known`: the effects that it may build on.

    **Raises:** UserError that names the class, the method and the point. What the code of the effect raises passes.
    """
    configure()
    names = [setting.name for setting in effect.choices]
    for words in product(*(setting.words for setting in effect.choices)):
        settings = dict(zip(names, words, strict=True))

        def laws(point: _Point, t: Any, settings: dict[str, str] = settings) -> dict[str, tuple[Any, ...]]:
            return _laws(made(effect, known, settings, point.values, Platform()), point, t)

        def both(point: _Point, t: Any, laws: Any = laws) -> tuple[Any, Any]:
            return laws(point, t), jax.jacfwd(laws)(point, t)

        compiled = jax.jit(both, compiler_options=compiler_options())
        for where, point, t in _points(effect, known, settings):
            values, slopes = compiled(point, t)
            _check_finite(effect, values, slopes, where)


def _points(
    effect: type[AbstractEffect], known: Registry, settings: Mapping[str, str]
) -> Iterator[tuple[str, _Point, float]]:
    """At rest and away from it, on both sides; with the amplitudes at some value, and where a fit begins with them."""
    on = {p.name: float(typical_value(p)) for p in effect.parameters}
    # A positive amplitude never is zero in a fit.
    off = {p.name: 0.0 for p in effect.parameters if p.kind == "amplitude" and not p.positive and not p.default}
    for values, said in ((on, ""), ({**on, **off}, f" and {' = '.join(off)} = 0")) if off else ((on, ""),):
        start = made(effect, known, settings, values, Platform()).state0()
        start = tuple(float(h) for h in _numbers(effect, "state0", start, len(effect.hidden_units)))
        yield f"z = v = 0{said}", _Point(0.0, 0.0, start, 0.0, 0.0, values), 0.0
        for m in MOTIONS:
            hidden = tuple(m * typical(unit) for unit in effect.hidden_units)
            where = f"z = {m * DISPLACEMENT:.2g} m, v = {m * VELOCITY:.2g} m/s, V = {m * VOLTAGE:.2g} V{said}"
            yield where, _Point(m * DISPLACEMENT, m * VELOCITY, hidden, m * VOLTAGE, 3e3, values), TIME


def _laws(effect: AbstractEffect, point: _Point, t: Any) -> dict[str, tuple[Any, ...]]:
    """What every method that the effect has returns, each as a tuple of numbers."""
    kind, count = type(effect), len(effect.hidden_units)
    state = State(point.z, point.v, point.hidden)
    drive = Drive(point.V, point.rate, 2e3, 1e-4, 1.0)
    before = drive._replace(V=0.9 * point.V)
    calls = {
        "force": lambda: effect.force(state, drive, t),
        "inertia": lambda: effect.inertia(point.z),
        "drive": lambda: effect.drive(point.hidden, drive, t),
        "sensor": lambda: effect.sensor(state, drive, t),
        "rate": lambda: effect.rate(state, drive, t),
        "follow": lambda: effect.follow(point.hidden, before, drive, _STEP),
        "state0": effect.state0,
        "begun": lambda: effect.begun(drive),
        "settled": lambda: effect.settled(1.5 * jnp.abs(point.V) + 0.1, drive),
    }
    return {
        name: (_number(kind, name, call()),) if name in (*LAWS, "inertia") else _numbers(kind, name, call(), count)
        for name, call in calls.items()
        if effect.overrides(name)
    }


def _number(effect: type[AbstractEffect], name: str, found: Any) -> Any:
    if not _is_number(found):
        raise _wrong(effect, name, f"must return one number, and returns {_kind(found)}", found)
    return jnp.asarray(found, float)


def _numbers(effect: type[AbstractEffect], name: str, found: Any, count: int) -> tuple[Any, ...]:
    """A tuple of numbers, one for each hidden state."""
    if not isinstance(found, (tuple, list)):
        told = f"must return a tuple, one number for each of hidden_units ({count}), and returns {_kind(found)}"
        raise _wrong(effect, name, told, found)
    if len(found) != count:
        raise _wrong(effect, name, f"returns {len(found)} hidden states, and hidden_units names {count}", found)
    for one in found:
        if not _is_number(one):
            raise _wrong(effect, name, f"must return a tuple of numbers, and one of them is {_kind(one)}", one)
    return tuple(jnp.asarray(one, float) for one in found)


def _wrong(effect: type[AbstractEffect], name: str, told: str, found: Any) -> UserError:
    do = "is its `return` missing?" if found is None else "give every hidden state one, in a tuple as (a,)"
    do = "return the sum, a single number" if name in LAWS and found is not None else do
    return UserError(f"{effect.__name__}.{name} {told}", where=place_of_method(effect, name), do=do)


def _is_number(found: Any) -> bool:
    """Whether something is a real number of no dimension, known or not yet."""
    return isinstance(found, (bool, int, float, np.generic, np.ndarray, jax.Array)) and (
        np.ndim(found) == 0 and not np.iscomplexobj(found)
    )


def _kind(found: Any) -> str:
    if found is None:
        return "nothing"
    if isinstance(found, (np.ndarray, jax.Array)):
        return f"an array of the shape {np.shape(found)}" if np.ndim(found) else "a complex number"
    return f"a {type(found).__name__}"


def _check_finite(
    effect: type[AbstractEffect], values: Mapping[str, tuple[Any, ...]], slopes: Mapping[str, Any], where: str
) -> None:
    for name, found in values.items():
        for value, slope in zip(found, slopes[name], strict=True):
            by = {"the value": value} | {f"the slope by {word}": one for word, one in _by(slope)}
            for word, one in by.items():
                if not np.isfinite(one):
                    what = f"{effect.__name__}.{name}: {word} is {float(one):g} where {where}"
                    raise UserError(what, where=place_of_method(effect, name), do=_FINITE)


def _by(slope: _Point) -> Iterator[tuple[str, Any]]:
    yield from (("z", slope.z), ("v", slope.v), ("drive.V", slope.V), ("drive.rate", slope.rate))
    yield from ((f"hidden[{i}]", one) for i, one in enumerate(slope.hidden))
    yield from slope.values.items()
