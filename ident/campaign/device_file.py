"""The device from a campaign: a file or a table with the fields of `Platform` or `Oscillator`."""

from __future__ import annotations

import math
from dataclasses import fields, replace
from pathlib import Path
from typing import Any

from ..errors import UserError
from ..units import (
    FREQUENCY,
    LENGTH,
    MASS,
    NUMBER,
    PRESSURE,
    VOLTAGE,
    base_unit,
    find_unit,
    kept_unit,
    parse_frequency,
    parse_quantity,
)
from .device import Device, Oscillator, Platform
from .document import Section, read_document, shown
from .record import Measures
from .tables.columns import rate_of
from .tables.opening import exists
from .tables.table import signal_unit

_DIMENSIONS = {
    "silicon_modulus": PRESSURE,
    "pzt_modulus": PRESSURE,
    "silicon_poisson": NUMBER,
    "pzt_poisson": NUMBER,
    "silicon_thickness": LENGTH,
    "pzt_thickness": LENGTH,
    "width": LENGTH,
    "length_1": LENGTH,
    "length_2": LENGTH,
    "stage_mass": MASS,
    "max_voltage": VOLTAGE,
    "max_frequency": FREQUENCY,
}
# A value outside is a slip of the unit (30 for "30 um"), not a device that can vibrate.
_RANGES = {
    PRESSURE: (1e6, 2e12),
    NUMBER: (-0.99, 0.499),
    LENGTH: (1e-8, 0.2),
    MASS: (1e-12, 1.0),
    VOLTAGE: (1e-6, 1e4),
    FREQUENCY: (1e-2, 1e9),
}


def read_device(campaign: Section, folder: Path) -> tuple[Device | None, Path | None]:
    """The device of a campaign (None if it names none), and the file it came from."""
    value = campaign.get(
        "device", (str, dict, Platform, Oscillator), 'a file ("device.toml") or a table ({ kind = "oscillator" })'
    )
    if value is None:
        return None, None
    if isinstance(value, (Platform, Oscillator)):
        return value, None
    if isinstance(value, dict):
        return parse_device(campaign.inside("device", value)), None
    path = folder / value
    if "\0" in value or not exists(path):
        raise campaign.error("device", f'there is no file "{value}" in {folder}', "correct the name of the device file")
    document = read_document(path, value)
    inner = document.values.get("device")
    if isinstance(inner, dict) and len(document.values) == 1:
        document = document.inside("device", inner)
    return parse_device(document), path


def parse_device(section: Section) -> Device:
    """The device that a table describes."""
    kind = section.choice("kind", ("platform", "oscillator"), "platform")
    if kind == "oscillator":
        return _oscillator(section)
    section.used.update(one.name for one in fields(Platform))
    section.check_keys()
    values: dict[str, Any] = {}
    for key in section.values:
        if key in _DIMENSIONS:
            values[key] = _positive(section, key)
        elif key == "beam_end":
            values[key] = _beam_end(section)
        elif key == "in_plane":
            values[key] = section.choice(key, ("yaw", "clamped", "free"), "yaw")
        elif key == "moment":
            values[key] = section.choice(key, ("neutral-axis", "paper-integral", "paper-printed"), "neutral-axis")
    return Platform(**values)


def _number(section: Section, key: str, value: Any, dimension: tuple[int, ...], example: str) -> float:
    if isinstance(value, str) and dimension == FREQUENCY:
        return parse_frequency(value, where=section.where(key))
    if isinstance(value, str):
        return parse_quantity(value, dimension, where=section.where(key))  # type: ignore[arg-type]
    if isinstance(value, bool) or not isinstance(value, (int, float)) or not math.isfinite(value):
        raise section.error(key, f"{shown(value)} is not a number with a unit", f'write for example "{example}"')
    return float(value)


def _positive(section: Section, key: str) -> float:
    dimension = _DIMENSIONS[key]
    unit = base_unit(dimension)
    value = _number(section, key, section.values[key], dimension, "0.22" if dimension == NUMBER else f"30 {unit}")
    low, high = _RANGES[dimension]
    if not low <= value <= high:
        what = f"{shown(section.values[key])} is {value:.4g} {unit if unit != '1' else ''}, which cannot be right"
        do = "a bare number is in SI units; give the unit" if dimension != NUMBER else "Poisson's ratio is below 0.5"
        raise section.error(key, what.strip(), do)
    return value


def _beam_end(section: Section) -> tuple[float, float]:
    value = section.values["beam_end"]
    if not isinstance(value, list) or len(value) != 2:
        raise section.error("beam_end", f"{shown(value)} is not a pair of lengths", 'write ["0 mm", "-1.5 mm"]')
    x, y = (_number(section, "beam_end", one, LENGTH, "-1.5 mm") for one in value)
    if max(abs(x), abs(y)) > 0.2:
        raise section.error(
            "beam_end", f"{shown(value)} is more than 0.2 m", "a bare number is in metres; give the unit"
        )
    return x, y


def _oscillator(section: Section) -> Oscillator:
    """An oscillator; a unit that the table does not give is "" until the columns of its records tell it."""
    limits: dict[str, float | None] = {}
    told = {key: signal_unit(section.text(key), "") or "" for key in ("output", "input")}  # g, of the Earth
    units = {key: own_base_unit(section, key, name) if key in section.values else "" for key, name in told.items()}
    for key in ("max_voltage", "max_frequency"):
        value = section.get(key, (str, int, float), 'a number with its unit ("10 V")')
        if value is None:
            limits[key] = None
            continue
        found = find_unit(units["input"] or "V") if key == "max_voltage" else None
        dimension = FREQUENCY if key == "max_frequency" else (found.dimension if found else NUMBER)
        limits[key] = _number(section, key, value, dimension, "10 V" if key == "max_voltage" else "2 kHz")
        if not limits[key] > 0:  # type: ignore[operator]
            raise section.error(key, f"{shown(value)} is not positive", "write a positive number")
    section.check_keys()
    return Oscillator(units["output"], units["input"], limits["max_voltage"], limits["max_frequency"])


def of_displacement(device: Device) -> tuple[Device, Measures, list[str]]:
    """The device with its output as a displacement, what its records then measure, and a sentence that says so."""
    rate = rate_of(device.output) if isinstance(device, Oscillator) else None
    if rate is None or not isinstance(device, Oscillator):
        return device, "displacement", []
    moved, measures = rate
    note = (
        f"The response is in {device.output}, which is read as the {measures} of a displacement in {moved} "
        f'(output = "{moved}", and measures = "{measures}" in its records).'
    )
    return replace(device, output=moved), measures, [note]


def own_base_unit(section: Section, key: str, name: str) -> str:
    """The unit in which an oscillator's numbers are kept: "mV" becomes "V"; a word that is no unit stays ("counts")."""
    kept = kept_unit(name)
    if kept is not None:
        return kept
    if not name.strip() or len(name) > 20 or any(mark in name for mark in '"[](){}=,\n\0') or name[:1].isdigit():
        raise UserError(f'{key}: "{name}" is not a unit', where=section.where(key), do='write for example output = "V"')
    return name.strip()
