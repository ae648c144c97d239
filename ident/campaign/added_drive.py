"""A drive that is no column of the record's file: another file holds it, or a sentence tells it."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from dataclasses import replace
from pathlib import Path

import numpy as np

from ..errors import UserError
from ..units import Dimension, factor_of, parse_frequency, parse_quantity
from .guess import time_column
from .spec import RecordSpec
from .tables.amplitude_unit import TO_PEAK, split_convention
from .tables.table import Column, Table

_SINE = re.compile(r"sine\s+(\S+\s*[^\d\s]\S*)\s+(\S+\s*[^\d\s]\S*?)\s*", re.IGNORECASE)


def with_drive(spec: RecordSpec, table: Table, read: Callable[[Path, str], Table], unit: str, kind: Dimension | None):
    """The table with the drive that the record's `drive_file` or `drive` adds to it, as a column called "drive".

    **Arguments:** `read`: reads the table in a file; `unit`, `kind`: the drive's base unit and its dimension.
    """
    if spec.drive_file is not None:
        return _joined(table, read(spec.drive_file, spec.drive_file.name), spec)
    if spec.sine:
        return _with_sine(table, spec, unit, kind)
    return table


def parse_sine(text: str, kind: Dimension | None, where: str) -> tuple[float, float]:
    """(amplitude in the base unit of the drive, frequency in Hz) of "sine 8 V 317 Hz"; "8 Vpp" has half of it."""
    match = _SINE.fullmatch(text.strip())
    if match is None:
        do = 'write drive = "sine 8 V 317 Hz", or columns = { drive = "…" } to name a column'
        raise UserError(f'"{text}" is no drive', where=where, do=do)
    level, convention = split_convention(match[1])
    amplitude = TO_PEAK[convention] * parse_quantity(level, kind, where=where)
    frequency = parse_frequency(match[2], where=where)
    if not (amplitude > 0 and frequency > 0):
        raise UserError(f'"{text}" has no positive amplitude and frequency', where=where, do="correct the numbers")
    return amplitude, frequency


def _time_of(table: Table, spec: RecordSpec) -> tuple[Column, np.ndarray]:
    column = time_column(table, spec.columns.get("time"))
    if column is None:
        do = 'say which with columns = { time = "…" }'
        raise UserError(f"no time column among {table.found}", where=table.name, do=do)
    return column, column.numbers() * factor_of(spec.units.get("time", column.unit or "s"))


def _with_sine(table: Table, spec: RecordSpec, unit: str, kind: Dimension | None) -> Table:
    amplitude, frequency = parse_sine(spec.sine, kind, spec.where)
    _, time = _time_of(table, spec)
    drive = amplitude * np.sin(2 * np.pi * frequency * time)
    others = tuple(c for c in table.columns if c.stem.lower() != "drive")
    column = Column(table.name, f"drive ({unit})", "drive", unit, len(table.columns) + 1, drive)
    note = f'{table.name}: the drive is "{spec.sine}", a sine that passes zero upwards at time 0.'
    return Table(table.name, (*others, column), (*table.notes, note))


def drive_column(drive: Table, named: str | int | None) -> Column:
    """The one column of a drive's own file that is not its time, or the one that is `named`."""
    time = time_column(drive)
    free = [c for c in drive.columns if time is None or c.position != time.position]
    others = [c for c in free if named is None or c.is_called(named)]
    numbers = [c for c in others if isinstance(c.cells, np.ndarray) or c.unit is not None or len(others) == 1]
    if len(numbers) != 1:
        do = 'say which with columns = { drive = "…" }'
        raise UserError(f"the drive can be any of {drive.found}", where=drive.name, do=do)
    return numbers[0]


def beside(table: Table, drive: Column, units: Mapping[str, str]) -> Table:
    """The table of a response with the column of another file as its drive, in the unit that is told of it; a name that
    a column of the response's has too is that column's."""
    told = [name for name in units if drive.is_called(name) and not any(c.is_called(name) for c in table.columns)]
    header = next(iter(told), drive.header)
    unit = units.get("drive", units[header] if told else drive.unit)
    header = "drive" if any(c.is_called(header) for c in table.columns) else header
    drive = replace(drive, header=header, stem="drive", unit=unit, position=len(table.columns) + 1)
    return replace(table, columns=(*(c for c in table.columns if c.stem.lower() != "drive"), drive))


def _joined(table: Table, drive: Table, spec: RecordSpec) -> Table:
    """The response's table with the one other column of the drive's, sampled at the same times."""
    _, time = _time_of(table, spec)
    _, drive_time = _time_of(drive, replace(spec, columns={}))
    column = drive_column(drive, spec.columns.get("drive"))
    values = column.numbers()
    step = float(np.median(np.diff(time))) if len(time) > 1 else 0.0
    if len(time) != len(drive_time) or np.max(np.abs(time - drive_time)) > 0.5 * abs(step):
        what = f"its {len(drive_time)} samples are not taken at the times of the {len(time)} of {table.name}"
        raise UserError(what, where=drive.name, do="give the two files of one recording, or resample one of them")
    both = beside(table, replace(column, cells=values, lines=()), spec.units)
    return replace(both, notes=(*table.notes, f"{table.name}: the drive comes from {drive.name}."))
