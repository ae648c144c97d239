"""From a table and what the campaign says about it to a record in SI units."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

from ..errors import UserError
from ..units import NUMBER, VOLTAGE, find_unit
from .added_drive import with_drive
from .channel import own_units
from .device import Device
from .guess import guess_kind, match_any
from .outages import of_use, stretches
from .record import Record
from .segments import segment_of
from .spec import RecordSpec, signal_units
from .sweeps.load import load_sweep
from .tables.amplitude_unit import is_amplitude_unit
from .tables.binary import READERS
from .tables.columns import Role, match_columns, trace_roles, without_reference
from .tables.instruments import INSTRUMENT_READERS
from .tables.table import Column, Table
from .tables.text import read_text_table
from .trace import trace_of


def read_table(path: Path, name: str, own_units: tuple[str, ...] = ()) -> Table:
    """The table in a data file of any known kind."""
    suffix = path.suffix.lower()
    reader = READERS.get(suffix) or INSTRUMENT_READERS.get(suffix)
    if reader is not None:
        return reader(path, name)
    own = next((unit for unit in own_units if find_unit(unit) is None), "")
    return read_text_table(path, name, own)


def load_record(spec: RecordSpec, table: Table, device: Device) -> tuple[list[tuple[RecordSpec, Record]], list[str]]:
    """The record, or the stretches of one with outages, each with what is said of it, and the notes on them."""
    (unit, dimension), _ = signal_units(device)
    table = with_drive(spec, table, read_table, unit, dimension)
    kind = spec.kind or guess_kind(table)
    notes = list(table.notes)
    if kind == "sweep":
        if not spec.kind:
            notes.append(f'{spec.file}: taken as a sweep (kind = "sweep"), because it has a frequency and no time.')
        sweep, found = load_sweep(spec, table, device)
        return [(spec, sweep)], notes + found
    told = _columns(spec, segment_of(spec, table), device, notes)
    parts, found = of_use(spec, stretches(told))
    notes += found
    traces = [(own, trace_of(own, columns, device, notes)) for own, columns in parts]
    begun = traces[0][1].time[0]
    return [(own, replace(trace, into=float(trace.time[0] - begun))) for own, trace in traces], notes


def _no_peak_unit(column: Column) -> None:
    if column.unit is not None and find_unit(column.unit) is None and is_amplitude_unit(column.unit):
        what = f'"{column.unit}" is a unit of amplitudes, but a trace needs the instantaneous value'
        raise UserError(what, where=f'{column.file}, column "{column.header}"', do="name the column of the waveform")


def _columns(spec: RecordSpec, table: Table, device: Device, notes: list[str]) -> dict[str, Column]:
    """The columns of a trace by their roles."""
    if spec.relative_noise:
        what = f"{spec.file} is a trace: its noise is no share of an amplitude"
        raise UserError(what, where=spec.where, do='write for example noise = "12 nm"')
    (_, drive_dimension), (_, response_dimension) = signal_units(device, spec.measures)
    roles = trace_roles(drive_dimension or NUMBER, response_dimension or NUMBER, own_units(device, spec.measures))
    roles = tuple(replace(r, dimension=spec.scale[r.name].dimension, own_unit="") if r.name in spec.scale else r
                  for r in roles)  # fmt: skip
    given = dict(spec.columns)
    if spec.drive_file is not None and "drive" in given:
        given["drive"] = "drive"  # as it is called here, whatever its own file says
    if "reference" in given:
        table = without_reference(table, given.pop("reference"), spec.where)
        notes.append(
            f"{spec.file}: a loop is closed around the device; the drive that was measured is what counts, but noise "
            "that the loop feeds back may bias a fit."
        )
    if spec.rate is not None:
        roles = roles[1:]
        if "time" in given:
            raise UserError("both rate and a time column are given", where=spec.where, do="remove one of them")
    try:
        columns = _matched(spec, table, roles, given, notes)
    except UserError:
        if spec.measures == "displacement" or "response" in spec.scale or signal_units(device)[1][1] != VOLTAGE:
            raise
        # A sensor's output is in V whatever it reads.
        roles = tuple(replace(r, dimension=VOLTAGE) if r.name == "response" else r for r in roles)
        columns = _matched(spec, table, roles, given, notes)
        rate = signal_units(device, spec.measures)[1][0]
        notes.append(f"{spec.file}: a sensor in V reads a {spec.measures}: its V are taken for {rate}.")
    for column in columns.values():
        _no_peak_unit(column)
    return columns


def _matched(
    spec: RecordSpec, table: Table, roles: tuple[Role, ...], given: Mapping[str, str | int], notes: list[str]
) -> dict[str, Column]:
    """The columns that play these roles; none a drive's, where nothing drives."""
    without = tuple(role for role in roles if role.name != "drive")
    fewer = "drive" not in given and len(table.columns) < len(roles)
    undriven = spec.undriven or (fewer and bool(match_any(table, without)))
    if undriven and not spec.undriven:
        notes.append(f"{spec.file}: there is no drive column; the record is taken as a free decay.")
    return match_columns(table, without if undriven else roles, given, spec.units, where=spec.where)
