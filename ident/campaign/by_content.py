"""Which column is which, and in which unit, by the numbers that a table holds where its names do not tell."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from ..errors import UserError
from ..units import LENGTH, VOLTAGE
from .guess import guess_kind, match_any
from .quality.checks import PLATFORM_TRAVEL
from .tables.columns import sweep_roles, trace_roles
from .tables.table import Column, Table
from .which_drives import Chosen, by_how_much, roughness, switches


def columns_by_content(table: Table) -> Chosen:
    """Columns for a table whose names do not tell."""
    if guess_kind(table) == "sweep":
        return Chosen({})
    roles = [replace(role, dimension=None, needed=False) for role in trace_roles(VOLTAGE, LENGTH)]
    found = match_any(table, tuple(roles))
    if len(found) == 3:
        return Chosen({})
    time = found.get("time") or next((c for c in table.columns if _is_time(c)), None)
    told = [match_any(table, (role,)).get(role.name) for role in roles[1:]] if len(table.columns) > 2 else [None, None]
    # "Source" heads a time.
    drive, response = (None if c is None or time is None or c.position == time.position else c for c in told)
    taken = [c.position for c in (time, drive, response) if c is not None]
    others = [c for c in table.columns if c.position not in taken and _varies(c)]
    if time is None or len(others) != 2 - sum(c is not None for c in (drive, response)):
        return Chosen({})
    named, both = drive is not None or response is not None, [c.numbers(missing=True) for c in others]
    if drive is None and response is not None:
        drive, others = others[0], [response]
    first = 0
    if drive is None:
        first = min((0, 1), key=lambda k: (not switches(both[k]), roughness(both[k])))
        drive = others.pop(first)
    roles = {"time": _name(time, table), "drive": _name(drive, table), "response": _name(others[0], table)}
    if named:
        return Chosen(roles)
    one, other = both[first], both[1 - first]
    return Chosen(roles, True, by_how_much(one, other), switches(one) and not switches(other))


def assumed_units(table: Table) -> dict[str, str]:
    """Volts, for a response without a unit whose numbers no platform can have in metres."""
    response = _response(table)
    if response is None or response.unit is not None or not _varies(response):
        return {}
    return {"response": "V"} if float(np.ptp(_known(response))) > PLATFORM_TRAVEL else {}


def _response(table: Table) -> Column | None:
    """The column of the response, or of its amplitudes, if it can be told."""
    roles = sweep_roles(VOLTAGE, LENGTH) if guess_kind(table) == "sweep" else trace_roles(VOLTAGE, LENGTH)
    found = match_any(table, tuple(replace(role, needed=False) for role in roles))
    return found.get("response", found.get("amplitude"))


def with_units(table: Table, units: Mapping[str, str]) -> Table:
    """The table with the unit that is assumed for its response."""
    told = _response(table) if units else None
    columns = (replace(c, unit=units["response"]) if c is told else c for c in table.columns)
    return replace(table, columns=tuple(columns))


def _name(column: Column, table: Table) -> str | int:
    """The header, or the number of the column if another is called the same."""
    return column.header if sum(c.header == column.header for c in table.columns) == 1 else column.position


def _is_time(column: Column) -> bool:
    try:
        steps = np.diff(column.numbers())
    except UserError:
        return False
    return len(steps) > 10 and bool(np.all(steps > 0)) and float(np.ptp(steps)) < 0.6 * float(np.mean(steps))


def _varies(column: Column) -> bool:
    try:
        known = _known(column)
    except UserError:
        return False
    return len(known) > 0 and float(np.ptp(known)) > 0


def _known(column: Column) -> np.ndarray:
    """The numbers of a column that are there."""
    values = column.numbers(missing=True)
    return values[np.isfinite(values)]
