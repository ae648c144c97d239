"""Units at the boundary: "12 nm" comes in, 1.2e-08 goes on. Inside the package every number is a plain SI float.

The units of a laboratory (s, V, m, Pa, N/m^3, … with their prefixes) are in a small table; any other name is looked up
in pint, which is imported only then because its import costs more than reading a campaign.

Source: BIPM, The International System of Units, 9th edition, 2019, §§2.3 and 3.
"""

from __future__ import annotations

import math
import re
from dataclasses import dataclass
from functools import cache
from typing import Any

from .errors import UserError

Dimension = tuple[int, int, int, int, int, int, int]
"""Exponents of m, kg, s, A, K, mol, cd."""


def _dimension(m: int = 0, kg: int = 0, s: int = 0, ampere: int = 0, kelvin: int = 0) -> Dimension:
    return (m, kg, s, ampere, kelvin, 0, 0)


NUMBER = _dimension()
LENGTH = _dimension(m=1)
MASS = _dimension(kg=1)
TIME = _dimension(s=1)
FREQUENCY = _dimension(s=-1)
CURRENT = _dimension(ampere=1)
VOLTAGE = _dimension(2, 1, -3, -1)
PRESSURE = _dimension(-1, 1, -2)
VELOCITY = _dimension(m=1, s=-1)
ACCELERATION = _dimension(m=1, s=-2)
FORCE = _dimension(1, 1, -2)
TORQUE = _dimension(2, 1, -2)
ANGLES = {NUMBER: "rad", FREQUENCY: "rad/s", _dimension(s=-2): "rad/s^2"}
"""In which unit an angle, its rate and that of its rate are kept, by their dimensions; a rate has a frequency's."""

_PREFIXES = {"p": 1e-12, "n": 1e-9, "u": 1e-6, "m": 1e-3, "k": 1e3, "M": 1e6, "G": 1e9}
_PREFIX_WORDS = {"pico": "p", "nano": "n", "micro": "u", "milli": "m", "kilo": "k", "mega": "M", "giga": "G"}
# symbol: (factor, dimension, word)
_PREFIXED: dict[str, tuple[float, Dimension, str]] = {
    "m": (1.0, LENGTH, "meter"),
    "g": (1e-3, MASS, "gram"),
    "s": (1.0, TIME, "second"),
    "A": (1.0, CURRENT, "ampere"),
    "V": (1.0, VOLTAGE, "volt"),
    "Hz": (1.0, FREQUENCY, "hertz"),
    "N": (1.0, FORCE, "newton"),
    "Pa": (1.0, PRESSURE, "pascal"),
    "Nm": (1.0, TORQUE, "newtonmeter"),  # of a torque; the textile number of pint is nobody's here
    "J": (1.0, _dimension(2, 1, -2), "joule"),
    "W": (1.0, _dimension(2, 1, -3), "watt"),
    "C": (1.0, _dimension(s=1, ampere=1), "coulomb"),
    "rad": (1.0, NUMBER, "radian"),
}
_PLAIN: dict[str, tuple[float, Dimension]] = {
    "1": (1.0, NUMBER),
    "%": (1e-2, NUMBER),
    "K": (1.0, _dimension(kelvin=1)),
    "F": (1.0, _dimension(-2, -1, 4, 2)),
    "min": (60.0, TIME),
    "h": (3600.0, TIME),
    "sec": (1.0, TIME),
    "cm": (1e-2, LENGTH),
    "micron": (1e-6, LENGTH),
    "bar": (1e5, PRESSURE),
}


_DEGREE, _TURN = math.pi / 180, 2 * math.pi
_TURNING: dict[str, tuple[float, Dimension]] = {  # of which each is one of the radian
    **dict.fromkeys(("deg", "degree", "°"), (_DEGREE, NUMBER)),
    **dict.fromkeys(("rpm", "RPM"), (_TURN / 60, FREQUENCY)),
    "rps": (_TURN, FREQUENCY),
    "dps": (_DEGREE, FREQUENCY),
}
_TURNS = ("rev", "revs", "turn", "cycle")
"""Words that are units in brackets ("z [rev]") and in compounds ("rev/s") only: "z, rev" is a direction."""


@dataclass(frozen=True)
class Unit:
    """A unit: value in SI = value × `factor`; `dimension` is its exponents of the base units, `angle` that of the
    radian: a number, but radians per second are no hertz."""

    name: str
    factor: float
    dimension: Dimension
    angle: int = 0


@cache
def _simple_units() -> dict[str, tuple[float, Dimension, int]]:
    units = {name: (*told, angle) for angle, table in enumerate((_PLAIN, _TURNING)) for name, told in table.items()}
    for symbol, (factor, dimension, word) in _PREFIXED.items():
        angle = int(symbol == "rad")
        units[symbol] = units[word] = (factor, dimension, angle)
        for prefix, power in _PREFIXES.items():
            units[prefix + symbol] = (factor * power, dimension, angle)
        for prefix_word, prefix in _PREFIX_WORDS.items():
            units[prefix_word + word] = (factor * _PREFIXES[prefix], dimension, angle)
    return units


@cache
def _registry() -> Any:
    import pint

    return pint.UnitRegistry(cache_folder=None)


@cache
def _one(name: str, rare: bool, compound: bool) -> tuple[float, Dimension, int] | None:
    """Factor, dimension and exponent of the radian of a unit name without operators, or None."""
    units = _simple_units()
    word = name.lower().replace("metre", "meter") if len(name) > 3 else name
    for form in (name, word, word.removesuffix("s") if len(word) > 4 else word):
        if form in units:
            return units[form]
        if (rare or compound) and form in _TURNS:
            return _TURN, NUMBER, 1
    if not rare or not re.fullmatch(r"[A-Za-zΩÅ_]{1,30}", name):
        return None
    import pint

    registry = _registry()
    try:
        quantity = registry.Quantity(1.0, name).to_base_units()
        origin = registry.Quantity(0.0, name).to_base_units()
    except (pint.PintError, AttributeError, ValueError, TypeError, SyntaxError, KeyError):
        return None
    if origin.magnitude != 0.0:  # °C and the like: a factor cannot convert them
        return None
    bases = ("meter", "kilogram", "second", "ampere", "kelvin", "mole", "candela")
    exponents = dict(quantity.unit_items())
    angle = exponents.pop("radian", 0)
    if set(exponents) - set(bases) or any(power != int(power) for power in exponents.values()):
        return None
    dimension = tuple(int(exponents.get(base, 0)) for base in bases)
    return float(quantity.magnitude), dimension, int(angle)  # type: ignore[return-value]


def plain_micro(text: str) -> str:
    """A text with "u" for both micro signs, which not every program may read."""
    return text.replace("µ", "u").replace("μ", "u")


def _normal(text: str) -> str:
    """One spelling: both micro signs are "u", products "*", powers "^"."""
    text = plain_micro(text.strip()).replace("**", "^").replace("⁻", "-")
    for raised, digit in zip("¹²³⁴⁵⁶", "123456", strict=True):
        text = text.replace(raised, digit)
    text = re.sub(r"(?<=N)-(?=[cm]?m\b)", "*", text)  # "N-m"
    if all(re.match(r"[^\W\d]+", part) and part.rstrip("^-0123456789") in _simple_units() for part in text.split(".")):
        text = text.replace(".", "*")  # "N.m", "rad.s-1", not "a.u"
    text = re.sub(r"\s*([*/·⋅×])\s*", r"\1", text)
    return re.sub(r"[·⋅×\s]+", "*", text)


def factor_of(name: str | None) -> float:
    """SI per unit of a column; 1 where it states none, or one of the user's own."""
    found = find_unit(name) if name else None
    return 1.0 if found is None else found.factor


def hertz_of(name: str | None) -> float:
    """Hz per unit of a column of frequencies; a rate of turning (rad/s, rpm) is 2π times as large."""
    found = find_unit(name) if name else None
    return 1.0 if found is None else found.factor / (2 * math.pi if found.angle == 1 else 1.0)


@cache
def find_unit(name: str, rare: bool = True) -> Unit | None:
    """The unit called `name` ("um", "N/m^3", "µm", "millivolt"), or None if there is none.

    `rare`: whether to ask pint for a name that is not among the units of a laboratory.
    """
    normal = _normal(name)
    if not normal or len(normal) > 40:
        return None
    factor, dimension, angle = 1.0, [0] * 7, 0
    parts = re.findall(r"(^|[*/])([^*/]*)", normal)
    for operator, part in parts:
        match = re.fullmatch(r"(1|%|°|[^\W\d]+)(?:\^\(?([+-]?[1-9])\)?|([2-4]|-[1-4]))?", part)
        if match is None or (match[1] == "1" and (match[2] or match[3])):
            return None
        found = _one(match[1], rare, len(parts) > 1)
        if found is None:
            return None
        power = int(match[2] or match[3] or 1) * (-1 if operator == "/" else 1)
        factor *= found[0] ** power
        dimension = [total + power * one for total, one in zip(dimension, found[1], strict=True)]
        angle += power * found[2]
    a, b, c, d, e, f, g = dimension
    return Unit(name.strip(), factor, (a, b, c, d, e, f, g), angle)


def unit(name: str, *, where: str = "") -> Unit:
    """The unit called `name`; a `UserError` if there is none."""
    found = find_unit(name)
    if found is None:
        raise UserError(
            f'"{name}" is not a unit', where=where, do='write for example "um", "ms", "mV", "MPa" or "N/m^3"'
        )
    return found


def _kind(dimension: Dimension) -> str:
    words = {LENGTH: "a length", MASS: "a mass", TIME: "a time", FREQUENCY: "a frequency", VOLTAGE: "a voltage"}
    words |= {PRESSURE: "a stress or modulus", NUMBER: "a number without unit"}
    return words.get(dimension, "in " + base_unit(dimension))


def kept_unit(name: str) -> str | None:
    """The unit in which numbers are kept whose unit is called `name`, None if there is none: "m" of "um", "rad" of
    "deg", though an angle is a number, and "rad/s" of "rpm", though that has the dimension of a frequency."""
    found = find_unit(name)
    if found is None:
        return None
    angle = ANGLES.get(found.dimension) if found.angle == 1 else None
    return angle or base_unit(found.dimension)


def base_unit(dimension: Dimension) -> str:
    """The SI unit of a dimension, without prefix: "m", "V", "N/m", "kg/m/s^3"."""
    for symbol, (factor, known, _) in _PREFIXED.items():
        if known == dimension and factor == 1.0 and symbol != "rad":
            return symbol
    parts = [
        f"{name}^{power}" if power != 1 else name
        for name, power in zip(("m", "kg", "s", "A", "K", "mol", "cd"), dimension, strict=True)
        if power > 0
    ]
    under = [
        f"/{name}^{-power}" if power != -1 else f"/{name}"
        for name, power in zip(("m", "kg", "s", "A", "K", "mol", "cd"), dimension, strict=True)
        if power < 0
    ]
    return "*".join(parts or ["1"]) + "".join(under)


def to_si(value: float, name: str, dimension: Dimension | None = None, *, where: str = "") -> float:
    """A value in the unit `name`, as a plain SI float; a `UserError` if the unit has another dimension."""
    found = unit(name, where=where)
    if dimension is not None and found.dimension != dimension:
        raise UserError(
            f'"{name}" is {_kind(found.dimension)}, but {_kind(dimension)} is needed here',
            where=where,
            do=f"give it in {base_unit(dimension)} or a multiple of it",
        )
    converted = float(value) * found.factor
    if not math.isfinite(converted):
        raise UserError(f"{value} {name} is not a finite number", where=where, do="correct the number")
    return converted


_QUANTITY = re.compile(r"\s*([+-]?(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][+-]?[0-9]+)?)\s*(.*?)\s*", re.DOTALL)


def looks_like_quantity(text: str) -> bool:
    """Whether a text starts with a number, as "80 MPa" does and "axial-force" does not."""
    return _QUANTITY.fullmatch(text) is not None


def parse_quantity(text: str, dimension: Dimension | None = None, *, where: str = "") -> float:
    """A number with its unit ("12 nm", "40 mg", "20 ms", "1.5"), as a plain SI float."""
    match = _QUANTITY.fullmatch(text)
    if match is None:
        raise UserError(f'"{text}" is not a number with a unit', where=where, do='write for example "12 nm"')
    number, name = match.groups()
    if not name and dimension not in (None, NUMBER):
        usual = {MASS: "mg", LENGTH: "um", TIME: "ms", PRESSURE: "MPa"}.get(dimension, base_unit(dimension))
        raise UserError(f'"{text}" has no unit', where=where, do=f'write for example "{number} {usual}"')
    return to_si(float(number), name or "1", dimension, where=where)


def parse_frequency(text: str, *, where: str = "") -> float:
    """A frequency of what oscillates or is sampled, Hz: "317 Hz", "3000 rpm", which are 50 Hz."""
    value, match = parse_quantity(text, FREQUENCY, where=where), _QUANTITY.fullmatch(text)
    return value * hertz_of(match[2]) / factor_of(match[2]) if match else value


_SHOWN = ((1e9, "G"), (1e6, "M"), (1e3, "k"), (1.0, ""), (1e-3, "m"), (1e-6, "µ"), (1e-9, "n"), (1e-12, "p"))


def format_quantity(value: float, name: str = "", digits: int = 4) -> str:
    """An SI value for people: `format_quantity(1.2e-8, "m")` is "12 nm".

    Simple units and their rates ("m/s^2") get a prefix; compound units ("N/m^3") and numbers without unit are printed
    as they are.
    """
    if name in ("", "1") or not math.isfinite(value):
        return f"{value:.{digits}g}" + (f" {name}" if name not in ("", "1") else "")
    scale, symbol = (1e3, "g") if name == "kg" else (1.0, name)
    simple = symbol.removesuffix("/s^2").removesuffix("/s")
    if simple not in _PREFIXED or simple == "rad" or value == 0.0:
        return f"{value:.{digits}g} {name}"
    size = abs(value * scale)
    near = (one for one in _SHOWN if size >= one[0] * (1 - 0.5 * 10.0**-digits))
    power, prefix = next(near, _SHOWN[-1])
    shown = float(f"{value * scale / power:.{digits}g}")  # 900 of two digits, not 9e+02
    return f"{shown:.15g} {prefix}{symbol}"


def significant(value: float, digits: int = 3) -> str:
    """A number with so many significant digits, without exponent unless it is very large or small."""
    if value == 0.0 or not math.isfinite(value):
        return "0" if value == 0.0 else "–"
    power = math.floor(math.log10(abs(float(f"{value:.{digits - 1}e}"))))
    if not -5 <= power <= 9:
        return f"{value:.{digits - 1}e}"
    places = digits - 1 - power
    return signed(f"{round(value, places):.{max(places, 0)}f}")


def signed(text: str) -> str:
    """No minus zero."""
    return text[1:] if text.startswith("-") and not text.strip("-0.") else text


def ratio_text(ratio: float) -> str:
    """Error over noise: two decimals where it is near 1, else three digits; of a motion without bound it is none."""
    if not math.isfinite(ratio):
        return "no bound"
    return f"{ratio:.2f}" if ratio < 9.995 else significant(ratio)


@cache
def exponents(name: str) -> dict[str, int]:
    """Powers of kg, m, s and V in a unit; electric current is written through the volt (1 A = 1 kg m² s⁻³ V⁻¹)."""
    m, kg, s, ampere, *rest = unit(name).dimension
    if any(rest):
        raise UserError(f"the unit {name!r} is not one of mechanics and voltage", do="use kg, m, s, N, Pa, Hz and V")
    return {"kg": kg + ampere, "m": m + 2 * ampere, "s": s - 3 * ampere, "V": -ampere}


@cache
def in_reading(name: str, order: int) -> str:
    """A unit whose metres are those of a reading, where that is the `order`-th derivative of the displacement."""
    later = -order * exponents(name)["m"]
    return f"{name}*s^{later}" if later else name
