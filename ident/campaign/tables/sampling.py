"""The column of times: found where it has no name, made where a file tells the time step instead, kept only once."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from ...errors import UserError
from ...units import LENGTH, VOLTAGE
from .columns import Role, claim, sweep_roles, trace_roles
from .preamble import Told
from .table import Column, Table

_TIME = trace_roles(VOLTAGE, LENGTH)[0]
_FREQUENCY = sweep_roles(VOLTAGE, LENGTH)[0]
_AS_TOLD = 0.01  # of the time step: printed with three digits it is off by half of that


def with_time(table: Table, told: Told) -> Table:
    """The table with times, s, in place of a count of samples, or as a further column, if its file tells the step."""
    counter = next((c for c in table.columns if c.doubtful.lower() == "sequence"), None)
    if told.step is None or not table.columns:
        if counter is not None:
            raise UserError("the time increment is missing", where=table.name, do="export time, not sample numbers")
        return table
    if any(_plays(c, role) for c in table.columns for role in (_TIME, _FREQUENCY) if c is not counter):
        return table
    if any(runs_by(told.step, c) for c in table.columns):
        return table
    counter = counter or (table.columns[0] if runs_by(1.0, table.columns[0]) else None)
    count = np.arange(float(len(table.columns[0].cells))) if counter is None else counter.numbers()
    time = Column(
        table.name, "time (s)", "time", "s", counter.position if counter else 0, told.start + told.step * count
    )
    note = f"{table.name}: no column of times; a sample every {told.step:.6g} s, as the file says elsewhere."
    return _instead(replace(table, notes=(*table.notes, note)), counter, time)


def is_time(column: Column) -> bool:
    """Whether a column holds times, by its name or by its unit."""
    return _plays(column, _TIME)


def _plays(column: Column, role: Role) -> bool:
    """Whether a column is a time, or a frequency, by its name or by its unit."""
    return claim(column, role) > 1 or (column.unit is not None and role.accepts(column.unit))


def _instead(table: Table, old: Column | None, new: Column) -> Table:
    """The table with a column in place of another, or in front."""
    kept = tuple(new if c is old else c for c in table.columns)
    return replace(table, columns=kept if old is not None else (new, *kept))


def runs_by(step: float, column: Column) -> bool:
    """Whether each number is the one before plus the step."""
    try:
        steps = np.diff(column.numbers())
    except UserError:
        return False
    return len(steps) > 0 and bool(np.all(np.abs(steps - step) < 0.5 * step)) and (
        abs(float(np.mean(steps)) - step) < _AS_TOLD * step
    )  # fmt: skip


def without_repeats(table: Table) -> Table:
    """The table with the times once, where they stand beside each channel."""
    times = [c for c in table.columns if _TIME.accepts(c.unit) and is_time(c)]
    again = [c for c in times[1:] if _same(times[0].cells, c.cells)]
    return replace(table, columns=tuple(c for c in table.columns if all(c is not one for one in again)))


def without_counter(table: Table) -> Table:
    """The table without a column that only counts the samples (frames, points), where times stand beside it: it is no
    signal."""
    if not any(is_time(c) for c in table.columns):
        return table
    return replace(table, columns=tuple(c for c in table.columns if c.unit is not None or is_time(c) or not c.counts))


def _same(one: Sequence[str] | np.ndarray, other: Sequence[str] | np.ndarray) -> bool:
    return len(one) == len(other) and bool(np.array_equal(np.asarray(one), np.asarray(other)))
