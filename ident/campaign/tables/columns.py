"""Which column is which: by the name of the column, by its unit, and by what the campaign says.

A column that is named exactly like its role ("drive", "u") is preferred to one whose name contains the word ("drive
monitor"), and that one to a weaker hint ("voltage"). Two columns of equal claim are an ambiguity, never a guess.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass, replace

from ...errors import UserError
from ...units import (
    ACCELERATION,
    CURRENT,
    FORCE,
    FREQUENCY,
    LENGTH,
    NUMBER,
    TIME,
    TORQUE,
    VELOCITY,
    VOLTAGE,
    Dimension,
    base_unit,
    find_unit,
    kept_unit,
)
from ..record import Measures
from .amplitude_unit import AmplitudeUnit, amplitude_unit, split_convention
from .table import Column, Table, signal_unit

PUSHES: tuple[Dimension, ...] = (CURRENT, FORCE, TORQUE, ACCELERATION)
"""What may drive a thing that is no platform: a current, a force, a torque; an acceleration of its base."""

_MOTIONS: tuple[Dimension, ...] = (LENGTH, VELOCITY, ACCELERATION)
_READINGS = ("response", "amplitude")
_BY_UNIT = ("level", "response", "drive")  # roles that a column may have although no name tells


@dataclass(frozen=True)
class Role:
    """What a column can be: its names in decreasing order of claim, and the dimension it must have.

    `per`: of an amplitude, the role of the drive by which it may be divided; its decibels are accepted too.
    """

    name: str
    exact: frozenset[str]
    strong: frozenset[str]
    weak: frozenset[str] = frozenset()
    dimension: Dimension | None = None
    own_unit: str = ""
    needed: bool = True
    per: Role | None = None

    def accepts(self, unit: str | None) -> bool:
        """Whether a column in this unit can play the role."""
        if unit is None or self.dimension is None and not self.own_unit:
            return True
        return self.amplitude(unit) is not None

    def measures(self, unit: str) -> bool:
        """Whether this is a plain unit of what the role measures."""
        if self.own_unit:
            return unit == self.own_unit
        found = find_unit(unit)
        return found is not None and found.dimension == self.dimension

    def amplitude(self, unit: str) -> AmplitudeUnit | None:
        """What the unit says if the column holds amplitudes."""
        return amplitude_unit(unit, self.measures, self.per.measures if self.per else None)


def _words(text: str) -> frozenset[str]:
    return frozenset(word.strip() for word in text.split(","))


_TIME = _words(
    "t, time, times, zeit, timestamp, time stamp, x axis, x value, second, seconds, sec, elapsed time, temps"
)
_DRIVE = _words(
    "u, drive, drv, input, excitation, vin, v in, u in, uin, stimulus, command, actuation, drive voltage, source, "
    "drive signal, input voltage, driving voltage, excitation voltage, v drive, drive v, u drive, anregung, "
    "base acceleration, base motion, base displacement, base velocity, table acceleration, ground acceleration"
)
_DRIVE_STRONG = _words("drive, driving, input, excitation, stimulus, command, actuation, actuator, vin, uin, anregung")
_BENEATH = _words("base, table, ground")  # whose acceleration drives; a floor or a mount as often answers
_DRIVE_WEAK = _words(
    "v, voltage, volt, volts, u, spannung, in, source, force, kraft, torque, drehmoment, hammer, shaker, current, strom"
)
_RESPONSE = _words(
    "y, z, displacement, disp, deflection, output, response, position, pos, y out, vout, v out, z stage, "
    "stage displacement, weg, auslenkung, out of plane displacement"
)
_RESPONSE_STRONG = _words(
    "displacement, disp, deflection, output, response, position, pos, vibrometer, ldv, motion, travel, vout, weg, "
    "auslenkung"
)
_RESPONSE_WEAK = _words(
    "y, z, x, q, sensor, measured, measurement, laser, out, reading, signal, angle, theta, phi, rotation, tilt, "
    "winkel, strain, velocity, speed, acceleration, accel, accelerometer"
)
_FREQUENCY = _words("f, freq, frequency, frequenz, drive frequency, excitation frequency, w, omega")
_FREQUENCY_STRONG = _words("freq, frequency, frequenz, omega, hz")
_AMPLITUDE = _words(
    "a, amp, amplitude, mag, magnitude, r, amplitude z, z amplitude, z amp, amplitude response, gain, h, frf, s21, "
    "betrag, transfer function, receptance, mobility, accelerance, inertance"
)
_AMPLITUDE_STRONG = _words("amp, amplitude, mag, magnitude, gain, frf, demod, demodulator")
_LEVEL = _DRIVE | _words(
    "level, drive level, drive amplitude, voltage amplitude, v, voltage, drive amp, amplitude drive"
)
_PHASE = _words("phase, phase lag, phase angle")
_PHASE_WEAK = _words("phi, theta, arg")  # angles that a thing may swing by, too
_DIRECTION = _words("direction, dir, sweep, sweep dir, sweep direction, up")


def rate_of(unit: str) -> tuple[str, Measures] | None:
    """Of what a unit is a rate, and which: ("m", "acceleration") of "mm/s^2", ("rad", "velocity") of "rpm"; or None."""
    moved, _, under = (kept_unit(unit) or "").partition("/")
    rates: dict[str, Measures] = {"s": "velocity", "s^2": "acceleration"}
    return (moved, rates[under]) if moved in ("m", "rad") and under in rates else None


def trace_roles(drive: Dimension, response: Dimension, own_units: tuple[str, str] = ("", "")) -> tuple[Role, ...]:
    """Time, drive and response of a time record."""
    return (
        Role("time", _TIME, _words("time, zeit"), dimension=TIME),
        Role("drive", _DRIVE, _DRIVE_STRONG, _DRIVE_WEAK, drive, own_units[0]),
        Role("response", _RESPONSE, _RESPONSE_STRONG, _RESPONSE_WEAK, response, own_units[1]),
    )


def sweep_roles(drive: Dimension, response: Dimension, own_units: tuple[str, str] = ("", "")) -> tuple[Role, ...]:
    """Frequency, drive level, amplitude, and where they were measured phase and direction, of a sweep."""
    strong, read = _DRIVE_STRONG | {"level"}, _RESPONSE | _RESPONSE_STRONG | _RESPONSE_WEAK
    level = Role("level", _LEVEL, strong, _DRIVE_WEAK, drive, own_units[0], needed=False)
    return (
        Role("frequency", _FREQUENCY, _FREQUENCY_STRONG, dimension=FREQUENCY),
        Role("phase", _PHASE, _words("phase"), _PHASE_WEAK, NUMBER, needed=False),
        Role("direction", _DIRECTION, _words("direction, dir"), dimension=NUMBER, needed=False),
        level,
        Role("amplitude", _AMPLITUDE, _AMPLITUDE_STRONG, read, response, own_units[1], per=level),
        Role("time", _TIME, _words("time, zeit"), dimension=TIME, needed=False),
    )


def claim(column: Column, role: Role) -> int:
    """How clearly a column is named like a role: 3 exactly, 2 by a word of it, 1 by a hint, 0 not at all."""
    stem = re.sub(r"([a-z])([A-Z])", r"\1 \2", column.stem) if not column.stem.isupper() else column.stem
    words = re.sub(r"[^a-z0-9]+", " ", (split_convention(stem)[0] or stem).lower()).split()
    if " ".join(words) in role.exact or "".join(words) in role.exact:
        return 3
    if role.strong.intersection(words) or (role.name in ("drive", "level") and _accelerates(column, words)):
        return 2
    return 1 if role.weak.intersection(words) else 0


def _accelerates(column: Column, words: list[str]) -> bool:
    """Whether a column is the acceleration of what a thing stands on."""
    unit = find_unit(column.unit) if column.unit else None
    told = (
        bool({"acceleration", "accel", "acc"}.intersection(words)) if unit is None else unit.dimension == ACCELERATION
    )
    return told and bool(_BENEATH.intersection(words))


def _letter_of_motion(column: Column, table: Table) -> bool:
    """Whether a column is a letter in a unit of motion, beside another of what pushes: there v is a velocity and no
    voltage, and u a displacement."""
    dimension = lambda c: unit.dimension if c.unit and (unit := find_unit(c.unit)) is not None else None
    letter = len(column.stem.strip()) == 1 and dimension(column) in _MOTIONS
    return letter and any(dimension(c) in (VOLTAGE, *PUSHES[:-1]) for c in table.columns)


def _example(roles: tuple[Role, ...], chosen: Mapping[str, Column], table: Table) -> str:
    """The TOML line that would settle the table."""
    left = [column for column in table.columns if column not in chosen.values() and not column.counts]
    parts = []
    for role in roles:
        if role.needed or role.name in chosen:
            fits = [column for column in left if role.accepts(column.unit)] or left or list(table.columns)
            column = chosen.get(role.name, fits[0])
            left = [other for other in left if other is not column]
            parts.append(f'{role.name} = "{column.header}"')
    return "columns = { " + ", ".join(parts) + " }"


def match_columns(
    table: Table,
    roles: tuple[Role, ...],
    given: Mapping[str, str | int],
    units: Mapping[str, str],
    *,
    where: str = "",
) -> dict[str, Column]:
    """The column of each role, each with its unit; a `UserError` if a role is open or a unit cannot be right.

    **Arguments:**

    - `given`: per role, the header (or its part before the unit, or the number of the column from 1).
    - `units`: per role or header, the unit; it overrides the header.
    - `where`: the place in the campaign file, for errors about `given` and `units`.
    """
    own = {role.own_unit for role in roles}
    units = {name: unit if unit in own else signal_unit(unit, name) or "" for name, unit in units.items()}
    table = Table(table.name, tuple(_with_given_unit(c, units) for c in table.columns), table.notes)
    known = {role.name for role in roles} | {c.header for c in table.columns} | {c.stem for c in table.columns}
    for name in units:
        if name not in known:
            what = f'units for "{name}", which is neither a role nor a column; the columns are {table.found}'
            raise UserError(what, where=where or table.name, do=f'write units = {{ {roles[-1].name} = "um" }}')
    chosen: dict[str, Column] = {}
    for role in roles:
        if role.name in given:
            chosen[role.name] = _given_column(table, role, given[role.name], where)
    for least in (3, 2, 1, 0):
        for role in roles:
            if role.name in chosen or (least == 0 and not role.needed and role.name not in _BY_UNIT):
                continue
            free = [column for column in table.columns if column not in chosen.values()]
            fits = [c for c in free if claim(c, role) >= least and role.accepts(units.get(role.name, c.unit))]
            if role.name in ("drive", "level") and role.dimension not in _MOTIONS and role.name not in units:
                fits = [c for c in fits if not _letter_of_motion(c, table)]
            if least == 0:  # no name helps: only the unit can tell
                fits = [c for c in fits if c.unit is not None and not any(claim(c, r) >= 2 for r in roles)]
                fits = fits if role.dimension not in (None, NUMBER) and _tells(role, roles) else []
            if least == 0 and not fits and role.name in ("response", "drive"):
                fits = _only_one_left(role, roles, chosen, free)
            if len(fits) > 1:
                raise _ambiguous(table, roles, chosen, role, fits)
            if fits:
                chosen[role.name] = fits[0]
    for role in roles:
        if role.name not in chosen and role.needed:
            raise _missing(table, roles, chosen, role, units, where)
    return {name: _checked(column, _role(roles, name), units, where) for name, column in chosen.items()}


def _role(roles: tuple[Role, ...], name: str) -> Role:
    return next(role for role in roles if role.name == name)


def _tells(role: Role, roles: tuple[Role, ...]) -> bool:
    """Whether the unit alone can tell the role: no other role that is still open takes the same unit."""
    return all(other is role or other.dimension != role.dimension or other.own_unit != role.own_unit for other in roles)


def _only_one_left(
    role: Role, roles: tuple[Role, ...], chosen: Mapping[str, Column], free: list[Column]
) -> list[Column]:
    """The last column of a table in which every other role has found its own, if it may be what is left; one that
    drives is in a unit of what drives, for a record may also have no drive, and a temperature that nobody asked for.
    The only force, torque or current drives, whatever else is left."""
    others = all(other is role or other.name in chosen for other in roles)
    if role.name == "drive":
        measured = {c.header: unit.dimension for c in free if c.unit and (unit := find_unit(c.unit)) is not None}
        pushing = [c for c in free if measured.get(c.header) in PUSHES[:-1]]
        others = others or len(pushing) == 1
        free = pushing or [c for c in free if measured.get(c.header) in (VOLTAGE, LENGTH, ACCELERATION)]
    column = free[0] if len(free) == 1 and others else None
    return [column] if column is not None and not column.counts and role.accepts(column.unit) else []


def _with_given_unit(column: Column, units: Mapping[str, str]) -> Column:
    unit = units.get(column.header, units.get(column.stem))
    return column if unit is None else replace(column, unit=unit, doubtful="")


def without_reference(table: Table, wanted: str | int, where: str) -> Table:
    """The table without the column that a control loop was told to follow: it is neither drive nor response."""
    reference = _given_column(table, Role("reference", frozenset(), frozenset()), wanted, where)
    return replace(table, columns=tuple(column for column in table.columns if column is not reference))


def _given_column(table: Table, role: Role, wanted: str | int, where: str) -> Column:
    if isinstance(wanted, int):
        fits = [column for column in table.columns if column.position == wanted]
    else:
        name = wanted.strip()
        fits = [column for column in table.columns if column.header == name]
        fits = fits or [column for column in table.columns if column.stem == name]
        fits = fits or [c for c in table.columns if name.lower() in (c.header.lower(), c.stem.lower())]
    if len(fits) == 1:
        return fits[0]
    what = f'{role.name} = "{wanted}" fits {"no column" if not fits else f"{len(fits)} columns"} of {table.name}'
    do = "name one of its columns" if not fits else "give the number of the column instead, counted from 1"
    raise UserError(f"{what}; its columns are {table.found}", where=where or table.name, do=do)


def _ambiguous(table: Table, roles: tuple[Role, ...], chosen: dict[str, Column], role: Role, fits: list[Column]):
    names = " or ".join(f'"{column.header}"' for column in fits)
    example = _example(roles, {**chosen, role.name: fits[0]}, table)
    return UserError(
        f"the {role.name} can be {names}; the columns are {table.found}",
        where=table.name,
        do=f"say which in the [[record]] of the campaign: {example}",
    )


def _missing(
    table: Table,
    roles: tuple[Role, ...],
    chosen: dict[str, Column],
    role: Role,
    units: Mapping[str, str],
    where: str,
) -> UserError:
    if role.name in units and not role.accepts(units[role.name]):
        needed = role.own_unit or (base_unit(role.dimension) if role.dimension is not None else "")
        what = f'"{units[role.name]}" is not a unit of {role.name}'
        return UserError(what, where=where or table.name, do=f"give {needed} or a multiple of it")
    for column in table.columns:  # the name fits, the unit does not: that is the better message
        rate = _rate(role, column.unit or "")
        named = claim(column, role) >= (2 if rate is None or not role.accepts(rate[0]) else 1)
        if column not in chosen.values() and named:
            return _wrong_unit(column, column.unit or "", role, "")
    if len(table.columns) < sum(r.needed for r in roles):
        count = f"{len(table.columns)} column{'s' if len(table.columns) > 1 else ''}"
        what = f"{count} where {' and '.join(r.name for r in roles if r.needed)} are needed"
        return UserError(f"{what}; found {table.found}", where=table.name, do="export all of them into one file")
    return UserError(
        f"no column is recognised as the {role.name}; the columns are {table.found}",
        where=table.name,
        do=f"say which in the [[record]] of the campaign: {_example(roles, chosen, table)}{_or_sweep(table, role)}",
    )


def _rate(role: Role, unit: str) -> tuple[str, Measures] | None:
    """`rate_of` what a reading is in, or its amplitude (per drive)."""
    if role.name not in _READINGS:
        return None
    meant = amplitude_unit(unit, lambda name: rate_of(name) is not None, role.per.measures if role.per else None)
    return None if meant is None else rate_of(meant.unit)


def _or_sweep(table: Table, role: Role) -> str:
    """A table with a frequency and no time is a sweep."""
    frequency = Role("frequency", _FREQUENCY, _FREQUENCY_STRONG, dimension=FREQUENCY)
    is_sweep = role.name == "time" and any(claim(c, frequency) and frequency.accepts(c.unit) for c in table.columns)
    return '; or write kind = "sweep"' if is_sweep else ""


def _wrong_unit(column: Column, unit: str, role: Role, where: str) -> UserError:
    needed = role.own_unit or (base_unit(role.dimension) if role.dimension is not None else "")
    what = f'the {role.name} "{column.header}" is in {unit or "no unit"}, which is not a unit of {role.name}'
    do = f"give it in {needed} or a multiple of it, or name another column"
    found, rate = find_unit(unit), _rate(role, unit)
    if rate is not None and role.accepts(rate[0]):
        do = f'write measures = "{rate[1]}" in its [[record]], or name another column'
    elif role.name in _READINGS and role.dimension == LENGTH:
        if role.name == "response" and found is not None and found.dimension == VOLTAGE:
            do += f'; of a sensor in {unit} write its scale = {{ response = "0.5 um/V" }} under [[record]]'
        output = "" if found is None else f', output = "{kept_unit(unit)}"'
        do += f'; for a thing that is no platform write device = {{ kind = "oscillator"{output} }}'
    elif role.name in _READINGS and found is not None:
        do += f'; or write output = "{kept_unit(unit)}" in the device table'
    if role.name in ("drive", "level") and role.dimension == VOLTAGE:
        do += "; the drive of a platform is a voltage"
    return UserError(what, where=where or f"{column.file}, column {column.position}", do=do)


def _checked(column: Column, role: Role, units: Mapping[str, str], where: str) -> Column:
    unit = units.get(role.name, column.unit)
    if unit is None:
        if column.doubtful and not role.own_unit and role.dimension != NUMBER and not _label(column.doubtful):
            raise UserError(
                f'"{column.doubtful}" is not a unit',
                where=f'{column.file}, column {column.position} ("{column.header}")',
                do=f'correct the header, or write units = {{ {role.name} = "…" }} in the [[record]] of the campaign',
            )
        return column
    if not role.accepts(unit):
        raise _wrong_unit(column, unit, role, where if role.name in units else "")
    return replace(column, unit=unit)


def _label(text: str) -> bool:
    """Whether a text in brackets is a name ("CH1", "measured"), not a unit that was misspelt."""
    return bool(re.match(r"(ch|ai|ao|in|out|raw|meas|set|dev|input|chan)", text.lower())) or len(text) > 8
