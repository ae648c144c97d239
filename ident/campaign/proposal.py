"""One record of a campaign that is proposed: its settings as lines of TOML, and every doubt about them."""

from __future__ import annotations

import json
import re
from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import NamedTuple

import numpy as np

from ..errors import UserError
from ..units import LENGTH, VOLTAGE
from .device import Device, Oscillator
from .guess import guess_kind, match_any
from .held_drive import jumps
from .load import load_record
from .quality.rest_level import level_before
from .record import Record, Sweep, Trace, same_level
from .spec import RecordSpec
from .sweeps.form import direction_in, level_in
from .tables.columns import sweep_roles
from .tables.opening import seen_from
from .tables.table import Table

_LOAD = re.compile(r"(?i)(\d+(?:[.,p]\d+)?)[ _]?(mg|ug)(?![a-z])")
_ANSWERED = re.compile("start is not given|direction is not given|read from the name of the file")
_LEVEL_ROLE = tuple(role for role in sweep_roles(VOLTAGE, LENGTH) if role.name == "level")


class Source(NamedTuple):
    """A data file: its `table`; the file of its `drive`, if that lies beside it; its `columns` by their roles, as far
    as names do not tell them, and what is in `doubt` of these; the `units` that are assumed."""

    path: Path
    table: Table
    drive: Path | None
    columns: Mapping[str, str | int]
    doubt: str
    units: Mapping[str, str]


@dataclass(frozen=True)
class Proposal:
    """One record to be: its settings as TOML lines, the record as it reads with them, and the doubts."""

    lines: tuple[str, ...]
    record: Record | None
    doubts: tuple[str, ...]


def proposal_of(
    source: Source,
    device: Device,
    told: Mapping[str, str | int] | None,
    folder: Path,
    segment: int | None,
) -> Proposal:
    """The record in a file, or in one `segment` of it, as a campaign in `folder` would have it; `told`: which column is
    which, where the user says so, which the campaign then says of all records."""
    path, kind = source.path, guess_kind(source.table)
    given = {role: name for role, name in source.columns.items() if told or source.drive is None or role != "drive"}
    lines, doubts = _settings(source, kind, {} if told else given, folder, segment)
    spec = RecordSpec(file=path.name, path=path, kind=kind, columns=given, drive_file=source.drive,  # type: ignore[arg-type]
                      units=source.units, segment=segment)  # fmt: skip
    try:
        ((_, record), *_), notes = load_record(spec, source.table, device)
    except UserError as error:
        return Proposal(tuple(lines), None, (*doubts, f"as it stands it cannot be read: {error}"))
    doubts += [note.removeprefix(f"{path.name}: ") for note in notes if not _ANSWERED.search(note)]
    if isinstance(record, Trace):
        if isinstance(device, Oscillator) and jumps(record.drive):
            doubts.append('the drive jumps; where between two samples a fit tells, or between = "hold": at the first')
        start, why = _start(record)
        lines.append(f'start = "{start}"' + " " * max(1, 24 - len(start)) + f"# {why}")
    else:
        lines += _sweep_lines(path, source.table, record)
    return Proposal(tuple(lines), record, tuple(doubts))


def _settings(
    source: Source, kind: str, given: Mapping[str, str | int], folder: Path, segment: int | None
) -> tuple[list[str], list[str]]:
    """What is said of a record before it is read, and what of that is in doubt."""
    lines = [f"file = {toml_text(seen_from(folder, source.path))}"]
    if segment is not None:
        lines.append(f"segment = {segment}                      # time starts again with each recording in the file")
    if source.drive is not None:
        lines.append(f"drive_file = {toml_text(seen_from(folder, source.drive))}")
    lines.append(f'kind = "{kind}"')
    if given:
        lines.append("columns = { " + ", ".join(f"{r} = {toml_value(n)}" for r, n in given.items()) + " }")
    doubts = [source.doubt] if source.doubt else []
    if source.units:
        lines.append("units = { " + ", ".join(f"{r} = {toml_text(u)}" for r, u in source.units.items()) + " }")
        doubts.append(
            "no unit is stated, and the response is too large for a displacement in metres; volts are assumed"
        )
    if load := _LOAD.search(source.path.stem):
        lines.append(f'load = "{load[1].replace(",", ".").replace("p", ".")} {load[2]}"')
        doubts.append("the load is read from the name of the file")
    return lines, doubts


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
        lines.append(f"level = {toml_text(level_in(path.stem))}" + "                   # by the name of the file")
    if len({run.up for run in record.runs}) == 1:
        by_name = bool(direction_in(path.stem))
        why = "by the name of the file" if by_name else "by the order of the rows: was it swept that way?"
        lines.append(f'direction = "{"up" if record.up[0] else "down"}"' + f"                # {why}")
    return lines


def one_per_level(proposal: Proposal) -> list[Proposal]:
    """A record for each level of a table of three or more, so that one of them can judge."""
    record = proposal.record
    groups = same_level(record.level) if isinstance(record, Sweep) else ()
    if not isinstance(record, Sweep) or len(groups) < 3:
        return [proposal]
    channel, found = record.drive_channel, []
    for rows in groups:
        level = f"{np.median(record.level[rows]) / channel.factor:.6g} {channel.unit}"
        part = replace(record, level=record.level[rows])
        lines = (*proposal.lines, f"level = {toml_text(level)}" + "                   # these rows of the table")
        found.append(Proposal(lines, part, () if found else proposal.doubts))
    return found


def toml_text(value: str) -> str:
    """A TOML text; JSON writes them alike."""
    return json.dumps(value, ensure_ascii=not value.isprintable())


def toml_value(value: str | int) -> str:
    """A TOML text or number."""
    return str(value) if isinstance(value, int) else toml_text(value)
