"""What a campaign file says about one record, validated and in SI units."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Literal, get_args

from ..errors import UserError
from ..units import FREQUENCY, LENGTH, MASS, TIME, VOLTAGE, Dimension, find_unit, parse_quantity, to_si
from .device import Device, Oscillator
from .document import Section, shown
from .record import MEASURES, Between, Measures
from .scale import Scale, parse_scale
from .tables.amplitude_unit import TO_PEAK, is_amplitude_unit, split_convention
from .tables.opening import check_file, exists
from .tables.table import Table

_TRACE_ROLES = ("time", "drive", "response", "reference")
HARMONICS = {f"harmonic{order}": order for order in range(2, 9)}
"""Columns of harmonics, by what the campaign calls them."""
_SWEEP_ROLES = ("frequency", "level", "amplitude", "phase", "direction", "real", "imaginary", *HARMONICS)
_OF_KIND = {
    "trace": ("start", "skip", "rate", "drive", "drive_file", "between", "scale", "segment"),
    "sweep": ("direction", "quantity", "level", "sweep_rate", "dwell", "averaging"),
}
SWEEP_NAMES = {"drive": "level", "response": "amplitude"}
"""A sweep's level and amplitude may be called like a trace's columns."""


@dataclass(frozen=True)
class RecordSpec:
    """One `[[record]]`; `sine`: what `drive` tells instead of a column; `undriven`: nothing drove the device; `table`:
    the data, where they were no file; `segment`: which of several recordings in the file, from 1; `part`: which stretch
    of one with outages, from 1, as the file itself tells.

    `noise` and `level` (a peak) are SI, `relative_noise` a fraction of the amplitude, `skip` is seconds (float) or
    samples (int), `rate` is Hz, `sweep_rate` Hz/s, `dwell` and `averaging` s."""

    file: str
    path: Path
    where: str = ""
    kind: Literal["trace", "sweep", ""] = ""
    start: Literal["rest", "steady", "unknown", ""] = ""
    holdout: bool = False
    load: float = 0.0
    noise: float | None = None
    skip: float | int = 0
    rate: float | None = None
    level: float | None = None
    relative_noise: float = 0.0
    sweep_rate: float | None = None
    dwell: float | None = None
    averaging: float | None = None
    direction: str = ""
    quantity: Literal["fundamental", "half-peak-to-peak"] = "fundamental"
    columns: Mapping[str, str | int] = field(default_factory=dict)
    units: Mapping[str, str] = field(default_factory=dict)
    sine: str = ""
    drive_file: Path | None = None
    segment: int | None = None
    part: int = 1
    undriven: bool = False
    measures: Measures = "displacement"
    between: Between = "auto"
    scale: Mapping[str, Scale] = field(default_factory=dict)
    table: Table | None = None

    @property
    def name(self) -> str:
        """How the record is called."""
        called = self.file if self.segment is None else f"{self.file} #{self.segment}"
        return called if self.part == 1 else f"{called}, stretch {self.part}"


def signal_units(
    device: Device, measures: Measures = "displacement"
) -> tuple[tuple[str, Dimension | None], tuple[str, Dimension | None]]:
    """(base unit, dimension) of the drive and of the response; the dimension is None for a unit of the user's own."""
    order = MEASURES.index(measures)
    output = (device.output if isinstance(device, Oscillator) else "m") + ("", "/s", "/s^2")[order]
    response = _dimension(device.output) if isinstance(device, Oscillator) else LENGTH
    if response is not None and order:
        response = (*response[:2], response[2] - order, *response[3:])
    if isinstance(device, Oscillator):
        return (device.input, _dimension(device.input)), (output, response)
    return ("V", VOLTAGE), (output, response)


def _dimension(unit: str) -> Dimension | None:
    found = find_unit(unit)
    return found.dimension if found else None


def parse_record(section: Section, folder: Path, device: Device, usual: Measures = "displacement") -> RecordSpec:
    """The record that a `[[record]]` table describes; a `UserError` for anything in it that cannot be right."""
    file, table = _data(section, folder)
    measures = section.choice("measures", MEASURES, usual)
    (drive_unit, drive_dimension), (response_unit, response_dimension) = signal_units(device, measures)  # type: ignore[arg-type]
    kind = section.choice("kind", ("trace", "sweep"), "")
    sine = _sine(section)
    undriven = sine.lower() == "none"
    noise, relative = _noise(section, response_unit, response_dimension)
    spec = RecordSpec(
        file=file,
        path=folder / file,
        where=section.where(),
        kind=kind,  # type: ignore[arg-type]
        start=section.choice("start", ("rest", "steady", "unknown"), ""),  # type: ignore[arg-type]
        holdout=section.flag("holdout"),
        load=_load(section, device),
        noise=noise,
        relative_noise=relative,
        skip=_skip(section),
        rate=_amount(section, "rate", "Hz", FREQUENCY, "10 kHz"),
        level=_amount(section, "level", drive_unit, drive_dimension, "3 V"),
        sweep_rate=_amount(section, "sweep_rate", "Hz/s", (0, 0, -2, 0, 0, 0, 0), "0.5 Hz/s"),
        dwell=_amount(section, "dwell", "s", TIME, "0.2 s"),
        averaging=_amount(section, "averaging", "s", TIME, "20 ms"),
        direction=section.text("direction"),
        quantity=section.choice("quantity", ("fundamental", "half-peak-to-peak"), "fundamental"),  # type: ignore[arg-type]
        columns=_columns(section, kind),
        units=_units(section, device),
        sine="" if undriven else sine,
        drive_file=_drive_file(section, folder),
        segment=_segment(section),
        undriven=undriven,
        measures=measures,  # type: ignore[arg-type]
        between=section.choice("between", get_args(Between), "auto"),  # type: ignore[arg-type]
        scale=_scale(
            section, {"drive": (drive_unit, drive_dimension), "response": (response_unit, response_dimension)}
        ),
        table=table,
    )
    section.check_keys()
    if spec.sweep_rate is not None and spec.dwell is not None:
        raise section.error("dwell", "sweep_rate says already how long each frequency was held", "remove one of them")
    _check_kind(section, kind)
    return spec


def _data(section: Section, folder: Path) -> tuple[str, Table | None]:
    """The file of a record, and its table where that was no file."""
    file = section.text("file")
    if not file:
        raise UserError("a [[record]] without a file", where=section.where(), do='add file = "a.csv"')
    table = section.values.get("data")
    if isinstance(table, Table):
        section.used.add("data")
        return file, table
    if "\0" in file or not exists(folder / file):
        raise section.error("file", f'there is no file "{file}" in {folder}', "correct the name")
    check_file(folder / file, f"{section.where('file')}: {file}")
    return file, None


def _check_kind(section: Section, kind: str) -> None:
    """A `UserError` for a key of the other kind of records."""
    other = {"trace": "sweep", "sweep": "trace"}.get(kind, "")
    for key in _OF_KIND.get(other, ()):
        if key in section.values:
            what = f"belongs to a {other}, and this record is a {kind}"
            raise section.error(key, what, f'remove it, or write kind = "{other}"')


def _load(section: Section, device: Device) -> float:
    load = section.quantity("load", MASS, "40 mg")
    if load is None:
        return 0.0
    if load < 0 or load > 1:
        raise section.error(
            "load", f"{shown(section.values['load'])} is no mass that a stage can carry", 'write "40 mg"'
        )
    if load > 0 and isinstance(device, Oscillator):
        raise section.error("load", "an oscillator has no stage mass to compare a load with", "remove the load")
    return load


def _amount(section: Section, key: str, unit: str, dimension: Dimension | None, example: str) -> float | None:
    """A positive number with its unit, SI. For a unit of the user's own: "3 counts"."""
    text = section.get(key, str, f'a number with its unit ("{example}")')
    if text is None:
        return None
    where = section.where(key)
    text, how = split_convention(text) if key == "level" else (text.strip(), "")
    own = dimension is None and text.endswith(unit)
    value = parse_quantity(text.removesuffix(unit) if own else text, None if own else dimension, where=where)
    if not value > 0:
        raise section.error(key, f'"{text}" is not positive', f'write for example "{example}"')
    return value * TO_PEAK[how]


def _noise(section: Section, unit: str, dimension: Dimension | None) -> tuple[float | None, float]:
    """Absolute and relative part of the noise: "12 nm", and of a sweep also "12 nm + 0.5 %" or "0.5 %"."""
    text = section.values.get("noise")
    share = re.fullmatch(r"(?:(.*)\+)?\s*(\d+(?:\.\d*)?|\.\d+)\s*%\s*", text) if isinstance(text, str) else None
    if share is None:
        return _amount(section, "noise", unit, dimension, "12 nm"), 0.0
    section.used.add("noise")
    relative = float(share[2]) / 100
    if not 0 < relative < 1:
        raise section.error("noise", f'"{text}" is no share of an amplitude', 'write for example "12 nm + 0.5 %"')
    part = replace(section, values={"noise": share[1].strip()}) if share[1] else None
    return (0.0 if part is None else _amount(part, "noise", unit, dimension, "12 nm")), relative


def _sine(section: Section) -> str:
    """What `drive` tells instead of a column: a sine, or that nothing drives the device."""
    value = section.text("drive")
    if value and value.lower() != "none" and not value.lower().startswith("sine"):
        do = (
            'write drive = "sine 8 V 317 Hz", drive = "none" for a ring-down, or columns = { drive = "…" } to name the '
            "column of the drive"
        )
        raise section.error("drive", f'"{value}" is not a drive', do)
    return value


def _drive_file(section: Section, folder: Path) -> Path | None:
    name = section.text("drive_file")
    if not name:
        return None
    if "drive" in section.values:
        raise section.error("drive_file", "drive says already what the drive is", "remove one of them")
    if "\0" in name or not exists(folder / name):
        raise section.error("drive_file", f'there is no file "{name}" in {folder}', "correct the name")
    return check_file(folder / name, f"{section.where('drive_file')}: {name}")


def _segment(section: Section) -> int | None:
    value = section.get("segment", int, "the number of a recording in its file (1)")
    if value is not None and value < 1:
        raise section.error("segment", f"{shown(value)} is no number of a recording", "count them from 1")
    return value


def _skip(section: Section) -> float | int:
    value = section.get("skip", (str, int), 'a time ("20 ms") or a number of samples (200)', 0)
    if isinstance(value, int):
        if value < 0:
            raise section.error("skip", f"{value} is negative", 'write "20 ms" or a number of samples')
        return value
    time = parse_quantity(value, TIME, where=section.where("skip"))
    if time < 0:
        raise section.error("skip", f'"{value}" is negative', 'write "20 ms" or a number of samples')
    return time


def _columns(section: Section, kind: str) -> dict[str, str | int]:
    table = section.section("columns")
    roles = _TRACE_ROLES if kind == "trace" else _SWEEP_ROLES + ("drive", "response") if kind == "sweep" else ()
    roles = roles or _TRACE_ROLES + _SWEEP_ROLES
    found: dict[str, str | int] = {}
    for role in roles:
        value = table.get(role, (str, int), 'the header of a column ("CH1") or its number')
        if value is not None:
            found[SWEEP_NAMES.get(role, role) if kind == "sweep" else role] = value
    table.check_keys()
    elsewhere = ("drive", "level") if "drive_file" in section.values else ()
    own = [value for role, value in found.items() if role not in elsewhere]
    if len(set(own)) < len(own):
        do = "each role needs a column of its own"
        raise section.error("columns", f"{shown(dict(found))} names one column twice", do)
    return found


def _scale(section: Section, units: Mapping[str, tuple[str, Dimension | None]]) -> dict[str, Scale]:
    table = section.section("scale")
    found: dict[str, Scale] = {}
    for role, (unit, dimension) in units.items():
        text = table.text(role)
        if text and dimension is None:
            raise table.error(
                role, f'"{unit}" is a unit of your own', "leave the scale out: the column is in it already"
            )
        if text and dimension is not None:
            found[role] = parse_scale(text, dimension, unit, table.where(role))
    table.check_keys()
    return found


def _units(section: Section, device: Device) -> dict[str, str]:
    table = section.section("units")
    found: dict[str, str] = {}
    for key in table.values:
        unit = table.text(key).strip()
        own = isinstance(device, Oscillator) and unit in (device.output, device.input)
        if not own and not is_amplitude_unit(unit):
            to_si(1.0, unit, where=table.where(key))
        found[key] = unit
    return found
