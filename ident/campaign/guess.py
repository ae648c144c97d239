"""What kind of record and of device data files hold, when no campaign says so."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import replace
from pathlib import Path

import numpy as np

from ..errors import UserError
from ..units import (
    ACCELERATION,
    CURRENT,
    FORCE,
    LENGTH,
    NUMBER,
    PRESSURE,
    VELOCITY,
    VOLTAGE,
    Dimension,
    base_unit,
    factor_of,
    find_unit,
    hertz_of,
    kept_unit,
)
from .device import Device, Oscillator, Platform
from .drive import drive_rate
from .quality.checks import PLATFORM_RATE, PLATFORM_TRAVEL, travel_of
from .sweeps.form import curve_form, level_in
from .tables.amplitude_unit import AmplitudeUnit, amplitude_unit, split_convention
from .tables.columns import PUSHES, Role, match_columns, rate_of, sweep_roles, trace_roles
from .tables.table import Column, Table

# What a sensor of an oscillator may read; a "response" in kg is a slip, not an oscillator.
_READINGS: tuple[Dimension, ...] = (
    VOLTAGE,
    CURRENT,
    NUMBER,
    VELOCITY,
    ACCELERATION,
    FORCE,
    PRESSURE,
)

_TIME = trace_roles(VOLTAGE, LENGTH)[:1]
_OCTAVE = 2.0  # by which a thickness or a mass that is not the nominal one does not move a resonance
_BENCH = 0.1  # m: what stands on a bench moves less, and metres in place of micrometres are more


def guess_kind(table: Table) -> str:
    """ "sweep" for a table with a frequency but no time, otherwise "trace"."""
    roles = [replace(role, needed=False) for role in trace_roles(VOLTAGE, LENGTH)]
    time = match_any(table, (roles[0],))
    frequency = match_any(table, (replace(sweep_roles(VOLTAGE, LENGTH)[0], needed=False),))
    return "sweep" if frequency and not (time and _instantaneous(table, roles)) else "trace"


def _instantaneous(table: Table, roles: list[Role]) -> bool:
    """Whether a table with times and frequencies holds a signal, which swings, and not the amplitudes of one."""
    amplitude = match_any(table, (replace(sweep_roles(VOLTAGE, LENGTH)[-2], weak=frozenset(), needed=False),))
    column = amplitude.get("amplitude") or match_any(table, tuple(roles)).get("response")
    try:
        return column is None or bool(np.any(column.numbers(missing=True) < 0))
    except UserError:
        return True


def match_any(table: Table, roles: tuple) -> dict:
    """The columns of those roles that can be told, none of them needed; empty if they are ambiguous."""
    try:
        return match_columns(table, roles, {}, {})
    except UserError:
        return {}


def time_column(table: Table, wanted: str | int | None = None) -> Column | None:
    """The column of times: the one that is wanted, if that is told, or that can be told."""
    own = next((column for column in table.columns if column.is_called(wanted)), None)
    return own or match_any(table, _TIME).get("time")


def renamed(table: Table, chosen: Mapping[str, str | int], units: Mapping[str, str] | None = None) -> Table:
    """The table with its chosen columns (role: header or number) called by their roles, in the units given."""
    roles = {name: role for role, name in chosen.items()}
    columns = []
    for column in table.columns:
        role = roles.get(column.header, roles.get(column.stem, roles.get(column.position, column.stem)))
        columns.append(replace(column, stem=role, unit=(units or {}).get(role, column.unit)))
    return replace(table, columns=tuple(columns))


def _meaning(column: Column) -> AmplitudeUnit | None:
    """What the unit of a column says if it holds amplitudes."""

    def reads(name: str) -> bool:
        found = find_unit(name)
        known = found is not None and (found.dimension in (*_READINGS, LENGTH) or rate_of(name) is not None)
        return known and name not in ("V/V", "mV/V", "A/A")

    def drives(name: str) -> bool:
        found = find_unit(name)
        return found is not None and found.dimension in (VOLTAGE, *PUSHES)

    return None if column.unit is None else amplitude_unit(column.unit, reads, drives)


def _measured(column: Column) -> Dimension | None:
    """The dimension of what a column holds; of a response ratio, that of its numerator."""
    if column.unit is None:
        return None
    meant = _meaning(column)
    if meant is not None and not meant.unit:  # bare decibels: no platform moves a millimetre per volt
        return VOLTAGE if float(np.max(column.numbers(), initial=-np.inf)) > -60.0 else LENGTH
    found = find_unit(meant.unit if meant is not None else column.unit)
    return None if found is None else found.dimension


def _kept(column: Column) -> str:
    """The unit in which the numbers of a column are kept; "" if it states none."""
    dimension, meant = _measured(column), _meaning(column)
    if dimension is None:
        return ""
    unit = column.unit if meant is None else meant.unit
    return (kept_unit(unit) if unit else None) or base_unit(dimension)


def _travel(column: Column, role: str) -> float:
    """How far a column of displacements, or of their amplitudes, goes, m; 0 if its header states no length (a ratio is
    none), or it is empty."""
    meant = _meaning(column) if role == "amplitude" else None
    unit = find_unit(column.unit if meant is None else meant.unit) if column.unit else None
    if unit is None or unit.dimension != LENGTH:
        return 0.0
    numbers = column.numbers(missing=True)
    numbers = numbers[np.isfinite(numbers)]
    if not len(numbers) or (meant is not None and meant.per):
        return 0.0
    far = travel_of(numbers) if meant is None else float(np.max(meant.amplitudes(numbers)))
    return far * unit.factor


def _slow_or_fast(time: Column, drive: Column) -> str:
    """Why a record shows nothing that the nominal platform does, or "": sampled too slowly, or driven too fast."""
    try:
        t, u = time.numbers(), drive.numbers()
    except UserError:
        return ""
    step = factor_of(time.unit) * float(np.median(np.diff(t))) if len(t) > 20 else 0.0
    if not step > 0:
        return ""
    if 1 / step < PLATFORM_RATE:
        return f"{1 / step:.3g} samples a second show no motion of a platform (or is the unit of time another?)"
    frequency, most = drive_rate(u) / (2 * np.pi * step), Platform().max_frequency
    return f"No platform is driven at {frequency:.3g} Hz" if frequency > most else ""


def _elsewhere(frequency: Column) -> str:
    """Why a sweep is none of the nominal platform, or "": it would have passed nowhere near its resonance."""
    try:
        band = hertz_of(frequency.unit) * frequency.numbers(missing=True)
    except UserError:
        return ""
    band = band[np.isfinite(band)]
    if not len(band):
        return ""
    low, high, nominal = float(np.min(band)), float(np.max(band)), PLATFORM_RATE / 2
    far = low > _OCTAVE * nominal or high < nominal / _OCTAVE
    return f"No platform is swept from {low:.6g} to {high:.6g} Hz" if far else ""


def in_units_of(device: Oscillator, tables: Iterable[Table]) -> tuple[Oscillator, list[str]]:
    """An oscillator with the units that its campaign leaves open as the first columns of tables have them that state
    one, volts where none does; and a sentence that says so."""
    names = {"output": _RESPONSES, "input": _DRIVES}
    told = {key: "" for key in names if not getattr(device, key)}
    for table in tables:
        found = _signals(table, device)[1]
        for key in (key for key, unit in told.items() if not unit):
            told[key] = next((_kept(found[name]) for name in names[key] if name in found), "")
        if all(told.values()):
            break  # decays have no drive, and may come first
    told = {key: unit or "V" for key, unit in told.items()}
    said = ", ".join(f'{key} = "{unit}"' for key, unit in told.items() if unit != "V")
    note = f"The units of the oscillator are taken from its columns ({said})."
    return replace(device, **told), [note] if said else []


_RESPONSES, _DRIVES = ("response", "amplitude"), ("drive", "level")


def _signals(table: Table, device: Oscillator | None = None) -> tuple[str, dict[str, Column], bool]:
    """The kind of a table, its columns by their roles whatever their units are, where a device does not tell them, and
    whether it has no drive."""
    kind = guess_kind(table)
    table = curve_form(table) if kind == "sweep" else table
    roles = (sweep_roles if kind == "sweep" else trace_roles)(VOLTAGE, LENGTH)
    undriven = kind == "trace" and len(table.columns) < len(roles)
    if undriven:
        roles = tuple(role for role in roles if role.name != "drive")
    told = (
        dict[str, str]()
        if device is None
        else (dict.fromkeys(_RESPONSES, device.output) | dict.fromkeys(_DRIVES, device.input))
    )

    def known(role: Role) -> Dimension | None:
        unit = find_unit(told.get(role.name, ""))
        return None if unit is None else unit.dimension

    return kind, match_any(table, tuple(replace(role, dimension=known(role), needed=False) for role in roles)), undriven


def guess_device(tables: list[Table]) -> tuple[Device, list[str]]:
    """A platform, unless its units, its travel or its speed are another device's; and a sentence that says so."""
    outputs, inputs, kept = set[Dimension](), set[Dimension](), dict[tuple[bool, Dimension], str]()
    undriven, travel, other = 0, 0.0, list[str]()
    for table in tables:
        kind, found, free = _signals(table)
        undriven += free
        for names, units in ((_RESPONSES, outputs), (_DRIVES, inputs)):
            for name in names:
                if name in found and (dimension := _measured(found[name])) is not None:
                    units.add(dimension)
                    kept.setdefault((units is outputs, dimension), _kept(found[name]))
                    travel = max(travel, _travel(found[name], name) if name in _RESPONSES else 0.0)
        if kind == "trace" and "time" in found and "drive" in found:
            other.append(_slow_or_fast(found["time"], found["drive"]))
        if kind == "sweep" and "level" not in found and (said := level_in(Path(table.name).stem)):
            unit = find_unit(split_convention(said)[0].split()[-1])
            inputs |= set() if unit is None else {unit.dimension}
        if kind == "sweep" and "frequency" in found:
            other.append(_elsewhere(found["frequency"]))
    reading = outputs.pop() if len(outputs) == 1 else None
    pushed = inputs.pop() if len(inputs) == 1 else VOLTAGE
    alone = len(tables) == undriven
    wide = PLATFORM_TRAVEL < travel < _BENCH
    apart = bool(other) and all(other)
    thing = alone or wide or apart or pushed in PUSHES
    other_reading = reading in _READINGS or (reading is not None and rate_of(kept[True, reading]) is not None)
    if reading is not None and (other_reading or (reading == LENGTH and thing)):
        output, source = kept[True, reading], kept.get((False, pushed), base_unit(pushed))
        units = f'output = "{output}", input = "{source}"'
        why = f"The response is in {output}" if other_reading else f"The drive is in {source}"
        why = other[0] if reading == LENGTH and pushed == VOLTAGE and apart else why
        why = f"No platform moves {1e3 * travel:.3g} mm" if reading == LENGTH and wide else why
        why = "No record has a drive" if reading == LENGTH and alone else why
        return Oscillator(output, source), [f"{why}, so the device is taken as an oscillator ({units})."]
    return Platform(), ["No device given: the nominal platform is assumed."]
