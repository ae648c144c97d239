"""A campaign file written from data files alone: what was found, what was guessed, and every doubt as a comment."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np

from ..errors import UserError
from .added_drive import with_drive
from .by_content import assumed_units, columns_by_content, with_units
from .device import Device, Oscillator
from .drive import drive_frequency
from .guess import guess_device, renamed
from .load import read_table
from .proposal import Source, one_per_level, proposal_of, toml_text, toml_value
from .record import Record, Sweep, Trace, same_level
from .segments import segments
from .spec import RecordSpec
from .tables.opening import check_file
from .tables.table import Table
from .which_drives import Chosen, decided_together

_ONE_OF_TWO = re.compile(
    r"(?i)(?<![a-z])(ch(?:annel)?[ _-]?[1-8]|c[1-8](?=trace|[^a-z]|$)|"
    r"drive|input|excitation|command|response|output|displacement|disp|z)"
    r"(?![a-su-z])"
)
_DRIVING = re.compile(r"(?i)drive|input|excitation|command|1$")

LEFT_OUT = "# left out: "
"""Before each line of the text that says which file could not be read."""


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
    joined = {
        path: _joined(path, tables[path], pairs.get(path), columns or {}) for path in tables if path not in second
    }
    chosen = decided_together(
        {path: Chosen(columns) if columns else columns_by_content(table) for path, table in joined.items()}
    )
    named = {path: renamed(table, chosen[path][0]) for path, table in joined.items()}
    units = {path: assumed_units(table) for path, table in named.items()}
    device, device_notes = guess_device([with_units(table, units[path]) for path, table in named.items()])
    proposals = [
        proposal_of(
            Source(path, tables[path], pairs.get(path), *chosen[path], units[path]), device, columns, folder, segment
        )
        for path, table in named.items()
        for segment in _segments(table)
    ]
    if all(isinstance(p.record, Sweep) for p in proposals):
        proposals = [one for p in proposals for one in one_per_level(p)]
    records = [p.record for p in proposals]
    held = _held_out(records) or _held_out_level(records)
    parts = _head(folder, device, device_notes, columns or {})
    for k, proposal in enumerate(proposals):
        parts += ["[[record]]", *proposal.lines]
        if k in held:
            parts.append("holdout = true                   # suggested: never fitted, only used to judge")
        parts += [f"# doubt: {doubt}" for doubt in proposal.doubts] + [""]
    parts += [f"{LEFT_OUT}{error}" for error in unread]
    if not held:
        parts.append("# Nothing is held out: a record taken under other conditions, with holdout = true, would judge.")
    return "\n".join(_line(part) for part in parts).rstrip() + "\n"


def _head(folder: Path, device: Device, notes: Sequence[str], columns: Mapping[str, str | int]) -> list[str]:
    """What stands above the records."""
    parts = [f"title = {toml_text(folder.resolve().name)}"]
    if isinstance(device, Oscillator):
        output, drive = toml_text(device.output), toml_text(device.input)
        parts.append(f'device = {{ kind = "oscillator", output = {output}, input = {drive} }}')
    else:
        parts.append('# device = "device.toml"        # geometry and materials; without it the nominal platform')
        parts.append(
            '# device = { kind = "oscillator" }      # if it is no such platform: any other thing that vibrates'
        )
    parts += [f"# guessed: {note}" for note in notes]
    parts += ["", "[model]", "effects = []                     # where to start: the plain linear device", ""]
    if columns:
        told = ", ".join(f"{role} = {toml_value(name)}" for role, name in columns.items())
        parts += ["[defaults]                       # for every record", f"columns = {{ {told} }}", ""]
    return parts


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
