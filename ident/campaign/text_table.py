"""Tables in text files: whatever separator, decimal sign, encoding and preamble the instrument wrote.

The numbers are found first, because they look alike in every format; the header is the text just above them.
"""

from __future__ import annotations

import csv
import re
from collections import Counter
from pathlib import Path

from ident.errors import UserError

from .table import Column, Table, is_number, is_unit, split_header, with_unit_row

_COMMENT = re.compile(r'\s*"?\s*(#|%|//|!|\*\*\*)')
_FORMATS = ((";", ","), (";", "."), ("\t", ","), ("\t", "."), (",", "."), (" ", ","), (" ", "."))
_COMMA_NUMBER = re.compile(r"\s*[+-]?(\d+(,\d+)?|,\d+)([eE][+-]?\d+)?\s*")


def read_text(path: Path, name: str) -> str:
    """The text of a file in UTF-8 (with or without BOM), UTF-16 with BOM, or the Western European code page."""
    data = path.read_bytes()
    return decode(data, name)


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


def _looks_like_data(cells: list[str], decimal: str) -> bool:
    filled = [cell for cell in cells if cell.strip()]
    count = sum(_numeric(cell, decimal) for cell in filled)
    return len(filled) > 0 and 2 * count >= len(filled) and (len(cells) == 1 or count > 0)


def _format(lines: list[tuple[int, str]]) -> tuple[str, str, int]:
    """Separator, decimal sign and number of columns, from up to 40 lines spread over the second half of the file."""
    half = lines[len(lines) // 2 :]
    sample = [line for _, line in half[:: max(1, len(half) // 40)]][:60]
    best, best_score = (",", ".", 0), 0.0
    for separator, decimal in _FORMATS:
        rows = [_split(line, separator) for line in sample]
        rows = [row for row in rows if _looks_like_data(row, decimal)]
        if not rows:
            continue
        width, count = Counter(len(row) for row in rows).most_common(1)[0]
        numbers = sum(_numeric(cell, decimal) for row in rows if len(row) == width for cell in row)
        score = numbers + 0.1 * count if width > 1 else 0.01 * numbers
        if score > best_score:
            best, best_score = (separator, decimal, width), score
    return best


def _preamble_units(rows: list[list[str]]) -> tuple[str, list[str]]:
    """Units of time and of the channels, from the key-value lines above the table (Tektronix, Keysight)."""
    horizontal, vertical = "", []
    for row in rows:
        key = row[0].strip().strip('"').lower() if row else ""
        values = [cell.strip().strip('"') for cell in row[1:] if cell.strip().strip('"')]
        if re.fullmatch(r"(horizontal|x|time)[ _]?(unit|units)", key) and values:
            horizontal = values[0]
        if re.fullmatch(r"(vertical|y)[ _]?(unit|units)", key):
            vertical = values
    return horizontal, vertical


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
    return parse_text_table(read_text(path, name), name, own_unit)


def parse_text_table(text: str, name: str, own_unit: str = "") -> Table:
    """The table in a text with plain line ends."""
    lines = [(number, line) for number, line in enumerate(text.split("\n"), 1) if line.strip()]
    if not lines:
        raise UserError("the file is empty", where=name, do="export the record again")
    content = [(number, line) for number, line in lines if not _COMMENT.match(line)]
    separator, decimal, width = _format(content)
    if width == 0:
        raise UserError("no table of numbers in this file", where=name, do="a record is a CSV with one row per sample")
    first = next(
        (
            k
            for k, (_, line) in enumerate(content)
            if len(row := _split(line, separator)) == width
            and _looks_like_data(row, decimal)
            and (k + 1 == len(content) or _looks_like_data(_split(content[k + 1][1], separator), decimal))
        ),
        None,
    )
    if first is None:
        raise UserError("no rows of numbers in this file", where=name, do="a record is a CSV with one row per sample")
    start = content[first][0]
    names, units, preamble, has_header = _header_rows([item for item in lines if item[0] < start], separator, width)
    body = content[first:]
    rows = [line.split(separator) for _, line in body] if separator != " " else [line.split() for _, line in body]
    if '"' in text:
        rows = [_split(line, separator) for _, line in body]
    width = max(width, len(names)) if separator != " " else width
    while width > 1 and not any(row[width - 1].strip() for row in rows if len(row) >= width):
        width -= 1  # instruments like to end every line with a separator
    for (number, line), row in zip(body, rows, strict=True):
        if len(row) != width and (len(row) < width or any(cell.strip() for cell in row[width:])):
            raise UserError(
                f"{len(row)} columns where the table has {width}: {line.strip()[:40]!r}",
                where=f"{name}, line {number}",
                do="complete the row, or delete it if the file was cut off there",
            )
    numbers = [number for number, _ in body]
    cells = list(zip(*(row[:width] for row in rows), strict=True))
    names = (names + [f"column {j + 1}" for j in range(len(names), width)])[:width]
    horizontal, vertical = _preamble_units(preamble)
    columns = []
    for j in range(width):
        header = names[j].strip().strip("\"'").strip() or f"column {j + 1}"
        stem, unit, doubtful = split_header(header, own_unit)
        column = Column(name, header, stem, unit, j + 1, cells[j], numbers, decimal, doubtful)
        if j < len(units):
            column = with_unit_row(column, units[j])
        elif column.unit is None and (horizontal if j == 0 else vertical):
            column = with_unit_row(column, horizontal if j == 0 else vertical[min(j, len(vertical)) - 1])
        columns.append(column)
    notes = () if has_header else (f"{name}: no header row; the columns are numbered from 1.",)
    return _rigol(Table(name, tuple(columns), notes), names, units)


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
