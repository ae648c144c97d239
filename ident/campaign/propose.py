"""A campaign file written from data files alone: what was found, what was guessed, and every doubt as a comment."""

from __future__ import annotations

import json
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from ..errors import UserError
from ..units import LENGTH, VOLTAGE
from .added_drive import with_drive
from .device import Oscillator, Platform
from .drive import drive_frequency
from .guess import guess_device, guess_kind, match_any, renamed
from .held_drive import jumps
from .load import load_record, read_table
from .quality.checks import PLATFORM_TRAVEL
from .quality.rest_level import level_before
from .record import Record, Sweep, Trace, same_level
from .segments import segments
from .spec import RecordSpec
from .sweeps.form import direction_in, level_in
from .tables.columns import sweep_roles, trace_roles
from .tables.opening import check_file, seen_from
from .tables.table import Column, Table
from .which_drives import Chosen, by_how_much, decided_together, roughness, switches

_ONE_OF_TWO = re.compile(
    r"(?i)(?<![a-z])(ch(?:annel)?[ _-]?[1-8]|c[1-8](?=trace|[^a-z]|$)|"
    r"drive|input|excitation|command|response|output|displacement|disp|z)"
    r"(?![a-su-z])"
)
_DRIVING = re.compile(r"(?i)drive|input|excitation|command|1$")
_LOAD = re.compile(r"(?i)(\d+(?:[.,p]\d+)?)[ _]?(mg|ug)(?![a-z])")
_ANSWERED = re.compile("start is not given|direction is not given|read from the name of the file")
_LEVEL_ROLE = tuple(role for role in sweep_roles(VOLTAGE, LENGTH) if role.name == "level")


LEFT_OUT = "# left out: "
"""Before each line of the text that says which file could not be read."""


@dataclass(frozen=True)
class _Proposal:
    """One record to be: its settings as TOML lines, the record as it reads with them, and the doubts."""

    lines: tuple[str, ...]
    record: Record | None
    doubts: tuple[str, ...]


def propose(paths: Sequence[Path], folder: Path, columns: Mapping[str, str | int] | None = None) -> str:
    """The text of a campaign.toml in `folder` for these data files, which stay where they are.

    **Arguments:** `columns`: which column is which, where the user says so.

    **Raises:** UserError for a file that is none, and if no table can be read in any of them.
    """
    for path in paths:
        check_file(path, str(path))
    tables, unread = _tables(paths)
    pairs = _pairs(tables)
    second = set(pairs.values())
    alone = [path for path in tables if path not in second]
    joined = {path: _joined(path, tables[path], pairs.get(path), columns or {}) for path in alone}
    chosen = decided_together(
        {path: Chosen(columns) if columns else _columns_by_content(joined[path]) for path in alone}
    )
    units = {path: _units(renamed(joined[path], chosen[path][0])) for path in alone}
    device, device_notes = guess_device([_with_units(renamed(joined[p], chosen[p][0]), units[p]) for p in alone])
    proposals = [
        _record(path, tables[path], pairs.get(path), device, (*chosen[path], units[path]), columns, folder, segment)
        for path in alone
        for segment in _segments(renamed(joined[path], chosen[path][0]))
    ]
    if all(isinstance(p.record, Sweep) for p in proposals):
        proposals = [one for p in proposals for one in _one_per_level(p)]
    records = [p.record for p in proposals]
    held = _held_out(records) or _held_out_level(records)
    parts = [f"title = {_text(folder.resolve().name)}"]
    if isinstance(device, Oscillator):
        parts.append(
            f'device = {{ kind = "oscillator", output = {_text(device.output)}, input = {_text(device.input)} }}'
        )
    else:
        parts.append('# device = "device.toml"        # geometry and materials; without it the nominal platform')
        parts.append(
            '# device = { kind = "oscillator" }      # if it is no such platform: any other thing that vibrates'
        )
    parts += [f"# guessed: {note}" for note in device_notes]
    parts += ["", "[model]", "effects = []                     # where to start: the plain linear device", ""]
    if columns:
        told = ", ".join(f"{role} = {_value(name)}" for role, name in columns.items())
        parts += ["[defaults]                       # for every record", f"columns = {{ {told} }}", ""]
    for k, proposal in enumerate(proposals):
        parts += ["[[record]]", *proposal.lines]
        if k in held:
            parts.append("holdout = true                   # suggested: never fitted, only used to judge")
        parts += [f"# doubt: {doubt}" for doubt in proposal.doubts] + [""]
    parts += [f"{LEFT_OUT}{error}" for error in unread]
    if not held:
        parts.append("# Nothing is held out: a record taken under other conditions, with holdout = true, would judge.")
    return "\n".join(_line(part) for part in parts).rstrip() + "\n"


def _tables(paths: Sequence[Path]) -> tuple[dict[Path, Table], list[UserError]]:
    """The tables in files, and what is wrong with files without one: notes and settings lie beside the records."""
    tables: dict[Path, Table] = {}
    unread: list[UserError] = []
    for path in paths:
        try:
            tables[path] = read_table(path, path.name)
        except UserError as error:
            unread.append(error)
    if not tables and unread:
        raise unread[0]
    return tables, unread


def _segments(table: Table) -> list[int | None]:
    """The numbers of the recordings in a file; None stands for the only one."""
    count = len(segments(table))
    return [None] if count < 2 else list(range(1, count + 1))


def _joined(path: Path, table: Table, drive: Path | None, told: Mapping[str, str | int]) -> Table:
    spec = RecordSpec(file=path.name, path=path, columns=told, drive_file=drive)
    return with_drive(spec, table, read_table, "V", None)


def _line(text: str) -> str:
    return text if text.isprintable() else "".join(c if c.isprintable() else "?" for c in text)


def _text(value: str) -> str:
    """A TOML text; JSON writes them alike."""
    return json.dumps(value, ensure_ascii=not value.isprintable())


def _value(value: str | int) -> str:
    return str(value) if isinstance(value, int) else _text(value)


def _record(
    path: Path,
    table: Table,
    drive: Path | None,
    device: Platform | Oscillator,
    chosen: tuple[Mapping[str, str | int], str, Mapping[str, str]],
    told: Mapping[str, str | int] | None,
    folder: Path,
    segment: int | None,
) -> _Proposal:
    lines = [f"file = {_text(seen_from(folder, path))}"]
    if segment is not None:
        lines.append(f"segment = {segment}                      # time starts again with each recording in the file")
    if drive is not None:
        lines.append(f"drive_file = {_text(seen_from(folder, drive))}")
    kind = guess_kind(table)
    lines.append(f'kind = "{kind}"')
    given, why, units = chosen
    given = {role: name for role, name in given.items() if told or drive is None or role != "drive"}
    spec = RecordSpec(file=path.name, path=path, kind=kind, columns=given, drive_file=drive, units=units,  # type: ignore[arg-type]
                      segment=segment)  # fmt: skip
    if given and not told:
        lines.append("columns = { " + ", ".join(f"{r} = {_value(n)}" for r, n in given.items()) + " }")
    doubts = [why] if why else []
    if units:
        lines.append("units = { " + ", ".join(f"{r} = {_text(u)}" for r, u in units.items()) + " }")
        doubts.append(
            "no unit is stated, and the response is too large for a displacement in metres; volts are assumed"
        )
    if load := _LOAD.search(path.stem):
        lines.append(f'load = "{load[1].replace(",", ".").replace("p", ".")} {load[2]}"')
        doubts.append("the load is read from the name of the file")
    try:
        ((_, record), *_), notes = load_record(spec, table, device)
    except UserError as error:
        return _Proposal(tuple(lines), None, (*doubts, f"as it stands it cannot be read: {error}"))
    doubts += [note.removeprefix(f"{path.name}: ") for note in notes if not _ANSWERED.search(note)]
    if isinstance(record, Trace):
        if isinstance(device, Oscillator) and jumps(record.drive):
            doubts.append('the drive jumps; where between two samples a fit tells, or between = "hold": at the first')
        start, why = _start(record)
        lines.append(f'start = "{start}"' + " " * max(1, 24 - len(start)) + f"# {why}")
    else:
        lines += _sweep_lines(path, table, record)
    return _Proposal(tuple(lines), record, tuple(doubts))


def _columns_by_content(table: Table) -> Chosen:
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


def _units(table: Table) -> dict[str, str]:
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


def _with_units(table: Table, units: Mapping[str, str]) -> Table:
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


def _start(record: Trace) -> tuple[str, str]:
    """How the record begins, and by what it was told: at rest if drive and response begin near zero and still, or
    nothing moves before the drive begins."""
    if level_before(record) is not None:
        return "rest", "guessed: nothing moves before the drive begins"
    response, drive, sigma = record.response, record.drive, record.noise.sigma
    size, step = float(np.max(np.abs(response))), float(np.sqrt(np.mean(np.diff(response) ** 2)))
    still = abs(float(np.mean(response[:3]))) < 3 * sigma + 0.02 * size
    still = still and float(np.max(np.abs(np.diff(response[:4])))) < 4 * sigma + 0.3 * step
    if np.ptp(drive) > 0 and still and abs(float(drive[0])) < 0.2 * float(np.max(np.abs(drive))):
        return "rest", "guessed: it begins near zero, and still"
    return "unknown", "the initial state is fitted"


def _sweep_lines(path: Path, table: Table, record: Sweep) -> list[str]:
    """What the names of files and the order of rows told of a curve: the level, and a direction that is one."""
    lines = []
    if level_in(path.stem) and len(same_level(record.level)) == 1 and "level" not in match_any(table, _LEVEL_ROLE):
        lines.append(f"level = {_text(level_in(path.stem))}" + "                   # by the name of the file")
    if len({run.up for run in record.runs}) == 1:
        by_name = bool(direction_in(path.stem))
        why = "by the name of the file" if by_name else "by the order of the rows: was it swept that way?"
        lines.append(f'direction = "{"up" if record.up[0] else "down"}"' + f"                # {why}")
    return lines


def _one_per_level(proposal: _Proposal) -> list[_Proposal]:
    """A record for each level of a table of three or more, so that one of them can judge."""
    record = proposal.record
    groups = same_level(record.level) if isinstance(record, Sweep) else ()
    if not isinstance(record, Sweep) or len(groups) < 3:
        return [proposal]
    channel, found = record.drive_channel, []
    for rows in groups:
        level = f"{np.median(record.level[rows]) / channel.factor:.6g} {channel.unit}"
        part = replace(record, level=record.level[rows])
        lines = (*proposal.lines, f"level = {_text(level)}" + "                   # these rows of the table")
        found.append(_Proposal(lines, part, () if found else proposal.doubts))
    return found


def _held_out_level(records: Sequence[Record | None]) -> frozenset[int]:
    """Sweeps of a middle level, if three levels or more lie in files of their own."""
    levels = {
        k: float(r.level[0]) for k, r in enumerate(records) if isinstance(r, Sweep) and len(same_level(r.level)) == 1
    }
    found = sorted(set(levels.values()))
    return (
        frozenset(k for k, level in levels.items() if level == found[len(found) // 2])
        if len(found) > 2
        else frozenset()
    )


def _held_out(records: Sequence[Record | None]) -> frozenset[int]:
    """A record to judge with: within what the others span, but driven as none of them."""
    traces = [(k, r) for k, r in enumerate(records) if isinstance(r, Trace) and np.ptp(r.drive) > 0]
    if len(traces) < 3:
        return frozenset()
    level = {k: float(np.std(r.drive)) for k, r in traces}
    rate = {k: drive_frequency(r) for k, r in traces}
    inner = sorted(level, key=lambda k: (level[k], rate[k]))[1:-1]

    def distance(k: int) -> float:
        others = [j for j in level if j != k]
        return min(abs(np.log(level[k] / level[j])) + abs(np.log(rate[k] / rate[j])) for j in others)

    return frozenset([max(inner, key=distance)])


def _pairs(tables: Mapping[Path, Table]) -> dict[Path, Path]:
    """Response file: drive file, of recordings whose channels lie in a file each, told by their names."""
    groups: dict[tuple[Path, str], list[Path]] = {}
    for path, table in tables.items():
        if len(table.columns) == 2 and _ONE_OF_TWO.search(path.stem):
            groups.setdefault((path.parent, _ONE_OF_TWO.sub("", path.stem)), []).append(path)
    found = {}
    for group in groups.values():
        if len(group) == 2:
            words = [_ONE_OF_TWO.findall(path.stem)[-1] for path in group]
            drives = [bool(_DRIVING.search(word)) for word in words]
            if drives.count(True) == 1:
                found[group[drives.index(False)]] = group[drives.index(True)]
    return found
