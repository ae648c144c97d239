"""Tables in text files: whatever separator, decimal sign, encoding and preamble the instrument wrote.

The numbers are found first, because they look alike in every format; the header is the text just above them.
"""

from __future__ import annotations

import csv
import io
import re
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ident.errors import UserError

from .opening import MOST_DATA, MOST_TEXT, check_file, read_bytes
from .preamble import preamble_words
from .table import Column, Table, is_number, is_unit, split_header, with_unit_row

_COMMENT = re.compile(r'\s*"?\s*(#|%|//|!|\*\*\*)')
_FORMATS = ((";", ","), (";", "."), ("\t", ","), ("\t", "."), (",", "."), (" ", ","), (" ", "."))
LEAST_FOR_PANDAS = 200_000
"""Characters of a table from which on pandas reads it: for less, its import (0.4 s) costs more than it saves."""
_COMMA_NUMBER = re.compile(r"\s*[+-]?(\d+(,\d+)?|,\d+)([eE][+-]?\d+)?\s*")


def decode(data: bytes, name: str, otherwise: str = "export the data as CSV, .mat, .h5, .parquet or .tdms") -> str:
    """The bytes of a file as text with plain line ends."""
    encodings = ("utf-16",) if data[:2] in (b"\xff\xfe", b"\xfe\xff") else ("utf-8-sig", "cp1252", "latin-1")
    for encoding in encodings:
        try:
            text = data.decode(encoding)
            break
        except UnicodeDecodeError:
            continue
    else:
        raise UserError("the text cannot be decoded", where=name, do="save the file as UTF-8")
    if "\0" in text:
        raise UserError("this is not a text file", where=name, do=otherwise)
    return text.replace("\r\n", "\n").replace("\r", "\n")


def _split(line: str, separator: str) -> list[str]:
    if separator == " ":
        return line.split()
    if '"' in line:
        try:
            return [cell.strip() for cell in next(csv.reader([line], delimiter=separator, skipinitialspace=True))]
        except csv.Error:
            return line.split(separator)
    return line.split(separator)


def _numeric(cell: str, decimal: str) -> bool:
    return bool(_COMMA_NUMBER.fullmatch(cell)) if decimal == "," else is_number(cell)


def _format(lines: list[tuple[int, str]]) -> tuple[str, str, int, tuple[int, ...]]:
    """Separator, decimal sign, number of columns and those that hold numbers, from up to 40 lines of the second half
    of what was looked at."""
    half = lines[len(lines) // 2 :]
    sample = [line for _, line in half[:: max(1, len(half) // 40)]][:60]
    best, best_score = (",", ".", 0, ()), 0.0
    for separator, decimal in _FORMATS:
        rows = [_split(line, separator) for line in sample]
        width, _ = Counter(len(row) for row in rows).most_common(1)[0] if rows else (0, 0)
        rows = [row for row in rows if len(row) == width]
        counts = [sum(_numeric(row[j], decimal) for row in rows) for j in range(width)]
        numeric = tuple(j for j, count in enumerate(counts) if 2 * count >= len(rows))
        good = sum(all(_numeric(row[j], decimal) for j in numeric) for row in rows) if numeric else 0
        score = sum(counts) + 0.1 * good if width > 1 else 0.01 * sum(counts)
        if numeric and score > best_score:
            best, best_score = (separator, decimal, width, numeric), score
    return best


def _first_row(lines: list[tuple[int, str]], separator: str, decimal: str, width: int, numeric: tuple[int, ...]) -> int:
    """Index of the first line of the table: it and the next are full of numbers where the table has numbers.

    Lines above it that begin with a number belong to it too, whatever is wrong with them: no row is lost silently.
    """

    def cells(k: int) -> list[str]:
        row = _split(lines[k][1], separator)
        return row if len(row) == width else []

    def full(k: int) -> bool:
        row = cells(k)
        return bool(row) and all(_numeric(row[j], decimal) for j in numeric)

    found = next((k for k in range(len(lines)) if full(k) and (k + 1 == len(lines) or cells(k + 1))), -1)
    while found > 0 and (row := cells(found - 1)) and _numeric(row[numeric[0]], decimal):
        found -= 1
    return found


def _filled_width(row: list[str]) -> int:
    return max((j + 1 for j, cell in enumerate(row) if cell.strip()), default=0)


def _header_rows(
    above: list[tuple[int, str]], separator: str, width: int
) -> tuple[list[str], list[str], list[list[str]], bool]:
    """(names, units, preamble rows, whether there is a header) from the lines above the data."""
    plain = [_split(line, separator) for _, line in above if line.strip() and not _COMMENT.match(line)]
    comments = [re.sub(_COMMENT, "", line, count=1).strip() for _, line in above if _COMMENT.match(line)]
    wide = [row for row in plain if len([cell for cell in row if cell.strip()]) >= min(2, width)]
    if not (plain and wide and plain[-1] is wide[-1]) and comments:
        for text in reversed(comments):
            for mark in (separator, ",", ";", "\t", " "):
                row = [cell.strip() for cell in _split(text, mark)]
                if len(row) == width and (width > 1 or mark == separator):
                    return row, [], plain, True
    if not wide:
        return [f"column {j + 1}" for j in range(width)], [], plain, False
    names, units = [cell.strip() for cell in wide[-1]], []
    bare = [cell.strip().strip("\"'").strip(" ()[]") for cell in names]
    filled = [cell for cell in bare if cell]
    all_units = bool(filled) and all(
        is_unit(cell, False) or cell.lower() == "sequence" or is_number(cell) for cell in filled
    )
    bracketed = any(cell.startswith(("(", "[")) for cell in names)
    if len(wide) > 1 and _filled_width(wide[-2]) == _filled_width(wide[-1]) and (all_units or bracketed):
        names, units = [cell.strip() for cell in wide[-2]], names
    preamble = [row for row in plain if row is not wide[-1]]
    return names, units, preamble, True


def read_text_table(path: Path, name: str, own_unit: str = "") -> Table:
    """The table in a text file; a `UserError` with line and column if there is none that can be used."""
    check_file(path, name)
    with open(path, "rb") as file:
        head = file.read(MOST_TEXT)
    _check_head(head, name)
    return parse_text_table(decode(read_bytes(path, name, MOST_DATA), name), name, own_unit)


def _check_head(head: bytes, name: str) -> None:
    """Whether a large file begins like a table, before it is read whole."""
    if len(head) == MOST_TEXT and b"\n" not in head and b"\r" not in head:
        raise UserError("a line of more than 1 MB", where=f"{name}, line 1", do="is this a table of numbers at all?")


def parse_text_table(text: str, name: str, own_unit: str = "") -> Table:
    """The table in a text with plain line ends."""
    head = text[:MOST_TEXT]
    head = head if len(head) == len(text) else head[: head.rfind("\n") + 1]
    lines = [(number, line) for number, line in enumerate(head.split("\n"), 1) if line.strip()]
    if not lines:
        raise UserError("the file is empty", where=name, do="export the record again")
    content = [(number, line) for number, line in lines if not _COMMENT.match(line)]
    separator, decimal, width, numeric = _format(content)
    first = _first_row(content, separator, decimal, width, numeric) if width else -1
    if first < 0:
        what = f"no table of numbers in {'this file' if len(head) == len(text) else 'the first megabyte of this file'}"
        raise UserError(what, where=name, do="a record is a CSV with one row per sample")
    start = content[first][0]
    names, units, preamble, has_header = _header_rows([item for item in lines if item[0] < start], separator, width)
    while (
        width > 1
        and numeric[-1] < width - 1
        and not any(_split(line, separator)[width - 1 : width] not in ([], [""]) for _, line in content[first:])
    ):
        width -= 1  # instruments like to end every line with a separator
    body = text.split("\n", start - 1)[-1] if start > 1 else text
    by_pandas = len(body) > LEAST_FOR_PANDAS and _by_pandas(body, start, separator, decimal, numeric)
    cells = by_pandas or _by_hand(body, start, name, separator, width)
    names = (names + [f"column {j + 1}" for j in range(len(names), width)])[:width]
    beside = [_split(line, separator)[:2] for _, line in content[first:]] if numeric[0] >= 2 else []
    horizontal, vertical, sources = preamble_words(preamble + beside)
    if not has_header and horizontal:
        named = [f"CH{j + 1}" for j in range(len(numeric) - 1)] if len(sources) < len(numeric) - 1 else sources
        for j, own in zip(numeric, ["time", *named], strict=False):
            names[j] = own
    columns = []
    for j in range(width):
        if j not in numeric and numeric[0] >= 2 and j < numeric[0]:
            continue  # the preamble stands beside the table
        header = names[j].strip().strip("\"'").strip() or f"column {j + 1}"
        stem, unit, doubtful = split_header(header, own_unit)
        values, printed = cells.column(j)
        column = Column(name, header, stem, unit, j + 1, values, cells.lines, decimal, doubtful, printed)
        if j < len(units):
            column = with_unit_row(column, units[j])
        elif column.unit is None and (horizontal if j == numeric[0] else vertical):
            place = numeric.index(j) if j in numeric else j
            column = with_unit_row(column, horizontal if place == 0 else vertical[min(place, len(vertical)) - 1])
        columns.append(column)
    notes = () if has_header or horizontal else (f"{name}: no header row; the columns are numbered from 1.",)
    return _rigol(Table(name, tuple(columns), notes), names, units)


@dataclass(frozen=True)
class _Cells:
    """The body of a table: its columns, some of their texts as printed, and the line of each row."""

    columns: Sequence[Sequence[str] | np.ndarray]
    lines: Sequence[int]
    printed: Sequence[Sequence[str]] = ()

    def column(self, j: int) -> tuple[Sequence[str] | np.ndarray, Sequence[str]]:
        return self.columns[j], [row[j] for row in self.printed if j < len(row)]


def _by_pandas(body: str, start: int, separator: str, decimal: str, numeric: tuple[int, ...]) -> _Cells | None:
    """The columns of a table without flaws; None for one that has some, whose place only a walk by hand can tell."""
    import pandas

    body = body.rstrip()
    count = body.count("\n") + 1
    try:
        frame = pandas.read_csv(
            io.StringIO(body), sep=r"\s+" if separator == " " else separator, decimal=decimal, header=None,
            na_filter=False, index_col=False, skip_blank_lines=False,
            skipinitialspace=True, low_memory=False,
        )  # fmt: skip
    except (ValueError, OverflowError, pandas.errors.ParserWarning):  # ParserError is a ValueError
        return None
    if len(frame) != count or any(j >= frame.shape[1] or frame[j].dtype.kind not in "fi" for j in numeric):
        return None
    columns = [frame[j].to_numpy() for j in range(frame.shape[1])]
    if not all(np.all(np.isfinite(columns[j])) for j in numeric):
        return None
    columns = [c.astype(float) if c.dtype.kind in "fi" else [str(cell).strip() for cell in c] for c in columns]
    places = np.linspace(0, len(body), 500).astype(int)
    ends = [(body.rfind("\n", 0, int(p)) + 1, int(p)) for p in places]
    sample = [body[a : body.find("\n", p) if body.find("\n", p) >= 0 else len(body)] for a, p in ends]
    return _Cells(columns, range(start, start + count), [_split(line, separator) for line in sample if line.strip()])


def _by_hand(body: str, start: int, name: str, separator: str, width: int) -> _Cells:
    """The cells as texts, whatever they hold. **Raises:** UserError at the first row that has too few or too many."""
    kept = [(k, line) for k, line in enumerate(body.split("\n"), start) if line.strip() and not _COMMENT.match(line)]
    rows = [_split(line, separator) for _, line in kept]
    for (number, line), row in zip(kept, rows, strict=True):
        if len(row) != width and (len(row) < width or any(cell.strip() for cell in row[width:])):
            raise UserError(
                f"{len(row)} columns where the table has {width}: {line.strip()[:40]!r}",
                where=f"{name}, line {number}",
                do="complete the row, or delete it if the file was cut off there",
            )
    return _Cells(list(zip(*(row[:width] for row in rows), strict=True)), [number for number, _ in kept])


def _rigol(table: Table, names: list[str], units: list[str]) -> Table:
    """Rigol's first column counts samples; start and increment stand at the end of the two header rows."""
    lower = [name.lower() for name in names]
    if not (units and units[0].strip().lower() == "sequence"):
        return table
    raw = [unit.strip() for unit in units]
    numbers = [float(unit) for unit in raw if is_number(unit)]
    if len(numbers) < 1:
        raise UserError("the time increment is missing", where=table.name, do="export time, not sample numbers")
    start, increment = (numbers[0], numbers[1]) if len(numbers) > 1 else (0.0, numbers[0])
    count = table.columns[0]
    time = start + increment * count.numbers()
    column = Column(table.name, "time (s)", "time", "s", 1, time, count.lines)
    kept = tuple(c for c in table.columns[1:] if lower[c.position - 1] not in ("start", "increment"))
    return Table(table.name, (column, *kept), (*table.notes, f"{table.name}: time from start and increment."))
