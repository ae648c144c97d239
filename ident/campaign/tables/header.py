"""The header of a table in a text: the names, and perhaps the units, that stand directly above its numbers."""

from __future__ import annotations

import csv
import re
from collections.abc import Sequence
from dataclasses import dataclass

from .amplitude_unit import is_amplitude_unit
from .table import is_number

_REMARKS = ("#", "%", "//", "!", "***")
_COMMENT = re.compile(r'\s*"?\s*(?:' + "|".join(map(re.escape, _REMARKS)) + ")")
_MARKS = (",", ";", "\t", " ")


@dataclass(frozen=True)
class Header:
    """`names` and `units` of the columns, as far as there are; `rows`: all other rows above the table, cell by cell;
    `line`: that of the names, as it stands there."""

    names: Sequence[str]
    units: Sequence[str]
    rows: Sequence[Sequence[str]]
    line: str = ""


def is_comment(line: str) -> bool:
    """Whether a line is a remark."""
    return line.lstrip(' \t"').startswith(_REMARKS)


def split_line(line: str, separator: str) -> list[str]:
    """The cells of a line."""
    if separator == " ":
        return line.split()
    if '"' in line:
        try:
            return [cell.strip() for cell in next(csv.reader([line], delimiter=separator, skipinitialspace=True))]
        except csv.Error:
            return line.split(separator)
    return line.split(separator)


def header_of(above: Sequence[str], separator: str, width: int) -> Header:
    """What the lines above a table of `width` columns say.

    Where the last of them is no header, a comment may be one: the last that has as many words as the table has columns.
    """
    plain = [line for line in above if line.strip() and not is_comment(line)]
    comments = [re.sub(_COMMENT, "", line, count=1).strip() for line in above if is_comment(line)]
    rows = [split_line(line, separator) for line in plain]
    told = [split_line(line, next((m for m in _marks(line, separator) if m != " "), "\0")) for line in comments]
    names, units, used = _in_rows(rows, width)
    if names:
        kept = [row for k, row in enumerate(rows) if k not in used]
        return Header(names, units, [*kept, *told, *_beside(names, units)], plain[used[0]])
    for text in reversed(comments):
        for mark in _marks(text, separator):
            cells = [cell.strip() for cell in split_line(text, mark)]
            if len(cells) == width and (width > 1 or mark == separator) and _are_names(cells):
                return Header(cells, [], [*rows, *told])
    return Header([], [], [*rows, *told])


def _marks(text: str, separator: str) -> list[str]:
    """The separators that a comment may have, that of the table first."""
    return [mark for mark in (separator, *_MARKS) if mark in text] + [separator]


def _in_rows(rows: Sequence[Sequence[str]], width: int) -> tuple[list[str], list[str], list[int]]:
    """(names, units, places of both among the rows); empty if the last row that has a word in it is no header.

    What stands above a line like "Waveform Data" is about the file.
    """
    worded = [k for k, row in enumerate(rows) if any(re.search(r"\w", cell) for cell in row)]
    last = worded[-1] if worded else -1
    if last < 0 or _filled(rows[last]) < min(2, width):
        return [], [], []
    cells = [cell.strip() for cell in rows[last]]
    above = worded[-2] if len(worded) > 1 else -1
    if above >= 0 and _reach(rows[above]) == _reach(rows[last]) and _are_units(cells):
        return [cell.strip() for cell in rows[above]], cells, [above, last]
    return (cells, [], [last]) if _are_names(cells) else ([], [], [])


def _filled(row: Sequence[str]) -> int:
    return sum(bool(cell.strip()) for cell in row)


def _reach(row: Sequence[str]) -> int:
    return max((j + 1 for j, cell in enumerate(row) if cell.strip()), default=0)


def _are_units(cells: Sequence[str]) -> bool:
    bare = [cell.strip("\"'").strip(" ()[]") for cell in cells]
    words = [cell for cell in bare if cell]
    known = all(is_amplitude_unit(word, False) or word.lower() == "sequence" or is_number(word) for word in words)
    return known or any(cell.startswith(("(", "[")) for cell in cells)


def _are_names(cells: Sequence[str]) -> bool:
    """Whether cells may name columns: a name has a letter, or is the number of a channel. "Points: 2000" tells a value,
    and so do "Points,2000" and "Date,2024/03/05"."""
    found = [cell.strip().strip("\"'").strip() for cell in cells if cell.strip()]
    named = [bool(re.search(r"[^\W\d_]", cell)) and not is_number(cell) or bool(re.fullmatch(r"[1-9]\d?", cell))
             for cell in found]  # fmt: skip
    if any(re.search(r"[:=]$|^[^\W\d][^(\[]*[:=]\s*\S", cell) for cell in found[:1]):
        return False
    return all(named) and any(re.search(r"[^\W\d_]", cell) for cell in found)


def _beside(names: Sequence[str], units: Sequence[str]) -> list[list[str]]:
    """Numbers that stand where the name of a unit would: Rigol's "Increment" above "2e-5"; and what stands among the
    names themselves, as "tInc = 2e-5"."""
    return [[name, unit] for name, unit in zip(names, units, strict=False) if is_number(unit)] + [list(names[1:])]
