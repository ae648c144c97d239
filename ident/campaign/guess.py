"""What kind of device a set of data files comes from, when no campaign says so."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

from ident.errors import UserError
from ident.units import CURRENT, LENGTH, NUMBER, VOLTAGE, Dimension, base_unit, find_unit

from .columns import match_columns, sweep_roles, trace_roles
from .device import Device, Oscillator, Platform
from .table import Table, peak_unit

# What a sensor of an oscillator may read; a "response" in kg is a slip, not an oscillator.
_READINGS: tuple[Dimension, ...] = (
    VOLTAGE,
    CURRENT,
    NUMBER,
    (1, 0, -1, 0, 0, 0, 0),
    (1, 0, -2, 0, 0, 0, 0),
    (1, 1, -2, 0, 0, 0, 0),
    (-1, 1, -2, 0, 0, 0, 0),
)

_PUSHES: tuple[Dimension, ...] = (CURRENT, (1, 1, -2, 0, 0, 0, 0), (1, 0, -2, 0, 0, 0, 0))
"""What may drive a thing that is no platform: a current, a force, an acceleration of its base."""


def guess_kind(table: Table) -> str:
    """ "sweep" for a table with a frequency but no time, otherwise "trace"."""
    roles = [replace(role, needed=False) for role in trace_roles(VOLTAGE, LENGTH)]
    time = match_any(table, (roles[0],))
    frequency = match_any(table, (replace(sweep_roles(VOLTAGE, LENGTH)[0], needed=False),))
    return "sweep" if frequency and not time else "trace"


def match_any(table: Table, roles: tuple) -> dict:
    """The columns of those roles that can be told, none of them needed; empty if they are ambiguous."""
    try:
        return match_columns(table, roles, {}, {})
    except UserError:
        return {}


def renamed(table: Table, chosen: Mapping[str, str | int], units: Mapping[str, str] | None = None) -> Table:
    """The table with its chosen columns (role: header or number) called by their roles, in the units given."""
    roles = {name: role for role, name in chosen.items()}
    columns = []
    for column in table.columns:
        role = roles.get(column.header, roles.get(column.stem, roles.get(column.position, column.stem)))
        columns.append(replace(column, stem=role, unit=(units or {}).get(role, column.unit)))
    return replace(table, columns=tuple(columns))


def guess_device(tables: list[Table]) -> tuple[Device, list[str]]:
    """A platform, unless every response is in one unit that is no length; and a sentence that says so."""
    outputs, inputs, undriven = set(), set(), 0
    for table in tables:
        kind = guess_kind(table)
        roles = (sweep_roles if kind == "sweep" else trace_roles)(VOLTAGE, LENGTH)
        if kind == "trace" and len(table.columns) < len(roles):
            roles, undriven = tuple(role for role in roles if role.name != "drive"), undriven + 1
        found = match_any(table, tuple(replace(role, dimension=None, needed=False) for role in roles))
        for names, units in ((("response", "amplitude"), outputs), (("drive", "level"), inputs)):
            for name in names:
                unit = found[name].unit if name in found else None
                known = find_unit(peak_unit(unit)[0]) if unit else None
                if known is not None:
                    units.add(known.dimension)
    reading = outputs.pop() if len(outputs) == 1 else None
    pushed = inputs.pop() if len(inputs) == 1 else VOLTAGE
    alone = len(tables) == undriven
    if reading is not None and (reading in _READINGS or (reading == LENGTH and (alone or pushed in _PUSHES))):
        output, source = base_unit(reading), base_unit(pushed)
        units = f'output = "{output}", input = "{source}"'
        why = f"The response is in {output}" if reading in _READINGS else f"The drive is in {source}"
        why = "No record has a drive" if reading == LENGTH and alone else why
        return Oscillator(output, source), [f"{why}, so the device is taken as an oscillator ({units})."]
    return Platform(), ["No device given: the nominal platform is assumed."]
