"""Numbers as people read them: "106.66 ± 0.21 MPa", one power of ten for value and error.

The error has two significant digits and the value as many decimals (JCGM 100:2008, GUM, §7.2.6).
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterable
from typing import NamedTuple

from ...campaign.device import Device, Oscillator
from ...campaign.record import Record, common_order
from ...units import exponents, kept_unit, signed, significant

_RAISED = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")
_PREFIXES = {9: "G", 6: "M", 3: "k", 0: "", -3: "m", -6: "µ", -9: "n", -12: "p"}
_PREFIXED = ("m", "s", "V", "N", "Pa", "Hz", "A", "J", "W", "Nm", "rad")
# Powers of ten between which a unit is written without change, whatever the size.
_KEPT = {"Hz": (-2, 5), "1": (-3, 5)}


class Scale(NamedTuple):
    """SI value = shown value × `factor`; `unit` is what stands behind the shown value ("MPa", "1e-24 m³/V³", "")."""

    factor: float
    unit: str


class Shown(NamedTuple):
    """A value and its standard error in words, both in `unit`; `error` is "" where there is none."""

    value: str
    error: str
    unit: str

    def __str__(self) -> str:
        number = f"{self.value} ± {self.error}" if self.error else self.value
        grouped = f"({number})" if self.error and self.unit[:2] == "1e" else number
        return f"{grouped} {self.unit}".strip()


def display_unit(unit: str, device: Device, *, plain: bool = False) -> str:
    """A parameter's unit as its device has it: "N/m³" on the platform, "1/(V²·s²)" on an oscillator that reads volts.

    An oscillator has mass 1, so that N is its output over s², m its output and V its input. `plain` writes
    "1/V^2/s^2", which `ident.units` reads back; no unit is "1" if plain, else "".
    """
    powers = _powers(unit)
    if isinstance(device, Oscillator):
        found, powers = exponents(unit), {}
        for name, power in ((device.output, found["m"]), (device.input, found["V"]), ("s", found["s"])):
            for symbol, own in _powers(_base(name)).items():
                powers[symbol] = powers.get(symbol, 0) + own * power
        if powers.get("s") == -1 and len([p for p in powers.values() if p]) == 1 and unit == "Hz":
            return "Hz"
    return _written({symbol: power for symbol, power in powers.items() if power}, plain)


def reading_unit(records: Iterable[Record]) -> str:
    """The unit, SI, of what the sensors of some records read: m, m/s or m/s^2; "m" where they differ."""
    return ("m", "m/s", "m/s^2")[common_order(records)]


def _base(unit: str) -> str:
    """The unit that numbers inside have when a column is in `unit`: V for mV, and an unknown unit itself."""
    return kept_unit(unit) or unit


def _powers(unit: str) -> dict[str, int]:
    """{"N": 1, "m": -3} of "N/m^3"; a name that is no product of units is one symbol."""
    powers: dict[str, int] = {}
    sign = 1
    for part in re.split(r"\s*([*/·])\s*|\s+", unit.strip()):
        if not part or part in "*·":
            continue
        if part == "/":
            sign = -1
            continue
        match = re.fullmatch(r"([^\d^]+)\^?(-?\d+)?", part)
        if match is None and part != "1":
            return {unit: 1}
        if match is not None:
            symbol = match[1].replace("u", "µ", 1) if re.fullmatch(r"u[msVNAJWg]", match[1]) else match[1]
            powers[symbol] = powers.get(symbol, 0) + sign * int(match[2] or 1)
        sign = 1
    return powers


def _written(powers: dict[str, int], plain: bool) -> str:
    def one(symbol: str, power: int) -> str:
        if power == 1:
            return symbol
        return f"{symbol}^{power}" if plain else symbol + str(power).translate(_RAISED)

    above = [one(s, p) for s, p in powers.items() if p > 0]
    below = [one(s, -p) for s, p in powers.items() if p < 0]
    if plain:
        return "*".join(above or ["1"]) + "".join(f"/{part}" for part in below)
    top = "·".join(above) or ("1" if below else "")
    return top + ("/" + below[0] if len(below) == 1 else f"/({'·'.join(below)})" if below else "")


def scale(size: float, unit: str, device: Device) -> Scale:
    """The prefix or power of ten in which an SI value of that `size` is best read.

    Simple units, their ratios and accelerations take a prefix (MPa, pm/V, mm/s²); powers and products take a power of
    ten, because the prefix of a cube misleads.
    """
    name = display_unit(unit, device)
    if not math.isfinite(size) or size == 0.0:
        return Scale(1.0, name)
    power = math.floor(math.log10(size) + 1e-9)
    low, high = _KEPT.get(name or "1", (0, 3))
    if low <= power < high:
        return Scale(1.0, name)
    step = 3 * math.floor(power / 3)
    if name == "Pa" and 4 <= power < 10:
        step = 6  # stresses are compared with one another, and people think of them in MPa
    powers = _powers(display_unit(unit, device, plain=True))
    first = next(iter(powers), "")
    if first == "kg" and len(powers) == 1 and -12 <= step + 3 <= 0:
        return Scale(10.0**step, _PREFIXES[step + 3] + "g")
    # An acceleration in mm/s² is everybody's; a prefix before the cube of a length, as in GN/m³, nobody's.
    ratio = first in _PREFIXED and powers[first] == 1 and all(abs(p) == 1 or s == "s" for s, p in powers.items())
    if ratio and len(powers) <= 2 and step in _PREFIXES:
        return Scale(10.0**step, _PREFIXES[step] + name)
    return Scale(10.0**step, f"1e{step} {name}".strip())


def show(value: float, error: float | None, unit: str, device: Device) -> Shown:
    """An SI value with its standard error, in the unit in which people think of it."""
    chosen = scale(max(abs(value), error or 0.0), unit, device)
    return show_in(value, error, chosen)


def show_in(value: float, error: float | None, chosen: Scale, digits: int = 4) -> Shown:
    """An SI value with its standard error in a unit chosen beforehand, for columns that share one; `digits` where there
    is no error."""
    value = value / chosen.factor
    if not math.isfinite(value):
        return Shown("–", "", chosen.unit)
    if error is None or not math.isfinite(error) or error <= 0.0:
        return Shown(significant(value, digits), "", chosen.unit)
    error = error / chosen.factor
    decimals = 1 - math.floor(math.log10(error))
    decimals = 1 - math.floor(math.log10(round(error, decimals)))  # 0.0996 rounds to 0.10, not to 0.100
    decimals = min(decimals, 12)
    places = max(decimals, 0)
    return Shown(signed(f"{round(value, decimals):.{places}f}"), f"{round(error, decimals):.{places}f}", chosen.unit)


def finite(value: float) -> float | None:
    """A number as JSON can write it."""
    return float(value) if math.isfinite(value) else None


def neat(value: float, digits: int = 4) -> str:
    """Significant digits of a number without zeros behind the point: 317, not 317.0."""
    text = significant(value, digits)
    return text.rstrip("0").rstrip(".") if "." in text and "e" not in text else text
