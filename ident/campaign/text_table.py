"""Tables in text files: whatever separator, decimal sign, encoding and preamble the instrument wrote.

The numbers are found first, because they look alike in every format; the header is the text just above them.
"""

from __future__ import annotations

import io
import re
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from ident.errors import UserError

from .clock import clock_seconds
from .header import header_of, is_comment, split_line
from .opening import MOST_DATA, MOST_TEXT, check_file, read_bytes
from .preamble import Told, preamble_words
from .sampling import is_time, runs_by, with_time, without_repeats
from .table import Column, Table, is_number, no_finite, split_header, with_unit_row

_FORMATS = ((";", ","), (";", "."), ("\t", ","), ("\t", "."), (",", "."), (" ", ","), (" ", "."))
_TOP = 500  # lines in which most tables have begun
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


def _numeric(cell: str, decimal: str) -> bool:
    return (bool(_COMMA_NUMBER.fullmatch(cell)) if decimal == "," else is_number(cell)) or no_finite(cell)


@dataclass(frozen=True)
class _Format:
    """How the rows of a table are written: `numeric` columns hold numbers, `blank` ones nothing."""

    separator: str = ","
    decimal: str = "."
    width: int = 0
    numeric: tuple[int, ...] = ()
    blank: tuple[int, ...] = ()

    def row(self, line: str) -> list[str]:
        """The cells of a line; empty if it is no row of the table."""
        row = split_line(line, self.separator)
        if len(row) > self.width and not any(cell.strip() for cell in row[self.width :]):
            row = row[: self.width]
        return row if len(row) == self.width else []

    def begins(self, line: str) -> bool:
        """Whether a line is a row that has a number where the numbers begin, whatever follows."""
        row = self.row(line)
        return bool(row) and _numeric(row[self.numeric[0]], self.decimal)

    def full(self, line: str) -> bool:
        """Whether a line is a row with numbers where the table has numbers, and nothing where it has nothing."""
        row = self.row(line)
        return bool(row) and all(_numeric(row[j], self.decimal) for j in self.numeric) and (
            not any(row[j].strip() for j in self.blank)
        )  # fmt: skip


def _format(lines: list[tuple[int, str]]) -> _Format:
    """How the table is written, from up to 60 of its lines."""
    sample = [line for _, line in lines[:: max(1, len(lines) // 40)]][:60]
    best, best_score = _Format(), 0.0
    for separator, decimal in _FORMATS:
        rows = [split_line(line, separator) for line in sample]
        width, _ = Counter(len(row) for row in rows).most_common(1)[0] if rows else (0, 0)
        rows = [row for row in rows if len(row) == width]
        counts = [sum(_numeric(row[j], decimal) for row in rows) for j in range(width)]
        numeric = tuple(j for j, count in enumerate(counts) if 2 * count >= len(rows))
        good = sum(all(_numeric(row[j], decimal) for j in numeric) for row in rows) if numeric else 0
        score = sum(counts) + 0.1 * good if width > 1 else 0.01 * sum(counts)
        if numeric and score > best_score:
            blank = tuple(j for j in range(width) if not any(row[j].strip() for row in rows))
            best, best_score = _Format(separator, decimal, width, numeric, blank), score
    return best


def _content(lines: Sequence[str]) -> list[tuple[int, str]]:
    """The lines that are neither empty nor remarks, with their numbers from 1."""
    return [(number, line) for number, line in enumerate(lines, 1) if line.strip() and not is_comment(line)]


def _first_row(lines: list[tuple[int, str]], form: _Format) -> int:
    """Index of the first line of the table: it and the next are full of numbers where the table has numbers.

    Lines above it that begin with a number belong to it too, whatever is wrong with them: no row is lost silently.
    """
    found = next(
        (
            k
            for k, (_, one) in enumerate(lines)
            if form.full(one) and (k + 1 == len(lines) or form.row(lines[k + 1][1]))
        ),
        -1,
    )
    while found > 0 and form.begins(lines[found - 1][1]) and (
        form.numeric[0] > 1 or not any(form.row(lines[found - 1][1])[j].strip() for j in form.blank)
    ):  # fmt: skip
        found -= 1
    return found


def read_text_table(path: Path, name: str, own_unit: str = "") -> Table:
    """The table in a text file; a `UserError` with line and column if there is none that can be used."""
    if check_file(path, name).stat().st_size > MOST_TEXT:
        with open(path, "rb") as file:
            _check_head(file.read(MOST_TEXT), name)
    return parse_text_table(decode(read_bytes(path, name, MOST_DATA), name), name, own_unit)


def _check_head(head: bytes, name: str) -> None:
    """Whether a large file begins like a table, before it is read whole."""
    if len(head) == MOST_TEXT and b"\n" not in head and b"\r" not in head:
        raise UserError("a line of more than 1 MB", where=f"{name}, line 1", do="is this a table of numbers at all?")


def parse_text_table(text: str, name: str, own_unit: str = "") -> Table:
    """The table in a text with plain line ends."""
    head = text[:MOST_TEXT]
    head = head if len(head) == len(text) else head[: head.rfind("\n") + 1]
    lines = head.split("\n")
    if not any(line.strip() for line in lines):
        raise UserError("the file is empty", where=name, do="export the record again")
    form = _format(_content(lines[len(lines) // 2 :: max(1, len(lines) // 80)]))
    form = form if form.width else _format(_content(lines))
    content, first = [], -1
    for top in (lines[:_TOP], lines):
        content = _content(top)
        first = _first_row(content, form) if form.width else -1
        if first >= 0 and content[first:][2:]:
            break
    if first < 0:
        what = f"no table of numbers in {'this file' if len(head) == len(text) else 'the first megabyte of this file'}"
        raise UserError(what, where=name, do="a record is a CSV with one row per sample")
    start = content[first][0]
    header = header_of([line for line in lines[: start - 1] if line.strip()], form.separator, form.width)
    body = text.split("\n", start - 1)[-1] if start > 1 else text
    by_pandas = len(body) > LEAST_FOR_PANDAS and _by_pandas(body, start, form)
    cells = by_pandas or _by_hand(body, start, name, form, header.line)
    beside = [form.row(line)[: form.numeric[0]] for _, line in content[first:]] if form.numeric[0] >= 2 else []
    told = preamble_words([*header.rows, *beside])
    names = [*header.names, *(f"column {j + 1}" for j in range(len(header.names), form.width))]
    first = Column(name, "", "", None, 1, cells.column(form.numeric[0])[0], (), form.decimal)
    steps = told.step is not None and runs_by(told.step, first)
    if not header.names and (told.horizontal or told.step):
        timed = steps or told.step is None
        own = told.sources or [f"CH{j + 1}" for j in range(len(form.numeric))]
        for j, one in zip(form.numeric, [*["time"] * timed, *own], strict=False):
            names[j] = one
    told = replace(told, horizontal="s") if steps and not told.horizontal else told
    columns = _columns(name, cells, form, names, header.units, told, own_unit)
    notes = () if header.names or told.horizontal or told.step else (_UNNAMED.format(name),)
    if told.sensitivity:
        notes += (_SENSITIVITY.format(name, told.sensitivity),)
    table = Table(name, tuple(columns), (*notes, *cells.notes))
    return without_repeats(with_time(table, told))


_UNNAMED = "{}: no header row; the columns are numbered from 1."
_SENSITIVITY = (
    '{}: "{}" stands above the table; if that is the sensor of a column in volts, write it into its [[record]], as in '
    'scale = {{ response = "5 um/V" }}.'
)


def _columns(
    name: str, cells: _Cells, form: _Format, names: Sequence[str], row: Sequence[str], told: Told, own_unit: str
) -> list[Column]:
    """The columns that hold something: numbers, times of day, or words.

    `row`: the units, if they have a row of their own.
    """
    columns: list[Column] = []
    channels = 0
    for j in range(form.width):
        values, printed = cells.column(j)
        decimal = form.decimal
        seconds = None if j in form.numeric or isinstance(values, np.ndarray) else clock_seconds(values)
        beside = form.numeric[0] >= 2 and j < form.numeric[0]  # the preamble stands beside the table
        if seconds is None and (beside or (j in form.blank and not any(cell.strip() for cell in values))):
            continue
        header = names[j].strip().strip("\"'").strip() or f"column {j + 1}"
        stem, unit, doubtful = split_header(header, own_unit)
        if seconds is not None:
            values, unit, decimal, doubtful = seconds, "s", ".", ""
        column = Column(name, header, stem, unit, j + 1, values, cells.lines, decimal, doubtful, printed)
        if j < len(row):
            column = with_unit_row(column, row[j])
        elif j in form.numeric and (is_time(column) or (not columns and told.horizontal and told.step is None)):
            column = with_unit_row(column, told.horizontal)
        elif j in form.numeric and told.vertical:
            column = with_unit_row(column, told.vertical[min(channels, len(told.vertical) - 1)])
            channels += 1
        columns.append(column)
    return columns


@dataclass(frozen=True)
class _Cells:
    """The body of a table: its columns, some of their texts as printed, and the line of each row."""

    columns: Sequence[Sequence[str] | np.ndarray]
    lines: Sequence[int]
    printed: Sequence[Sequence[str]] = ()
    notes: tuple[str, ...] = ()

    def column(self, j: int) -> tuple[Sequence[str] | np.ndarray, Sequence[str]]:
        return self.columns[j], [row[j] for row in self.printed if j < len(row)]


def _by_pandas(body: str, start: int, form: _Format) -> _Cells | None:
    """The columns of a table without flaws; None for one that has some, whose place only a walk by hand can tell."""
    import pandas

    body = body.rstrip()
    count = body.count("\n") + 1
    try:
        frame = pandas.read_csv(
            io.StringIO(body), sep=r"\s+" if form.separator == " " else form.separator, decimal=form.decimal,
            header=None, na_filter=False, index_col=False, skip_blank_lines=False,
            skipinitialspace=True, low_memory=False,
        )  # fmt: skip
    except (ValueError, OverflowError, pandas.errors.ParserWarning):  # ParserError is a ValueError
        return None
    if len(frame) != count or any(j >= frame.shape[1] or frame[j].dtype.kind not in "fi" for j in form.numeric):
        return None
    columns = [frame[j].to_numpy() for j in range(frame.shape[1])]
    if not all(np.all(np.isfinite(columns[j])) for j in form.numeric):
        return None
    columns = [c.astype(float) if c.dtype.kind in "fi" else [str(cell).strip() for cell in c] for c in columns]
    places = np.linspace(0, len(body), 500).astype(int)
    ends = [(body.rfind("\n", 0, int(p)) + 1, int(p)) for p in places]
    sample = [body[a : body.find("\n", p) if body.find("\n", p) >= 0 else len(body)] for a, p in ends]
    return _Cells(
        columns, range(start, start + count), [split_line(line, form.separator) for line in sample if line.strip()]
    )


def _by_hand(body: str, start: int, name: str, form: _Format, header: str) -> _Cells:
    """The cells as texts, whatever they hold. **Raises:** UserError at the first row that has too few or too many."""
    kept = [(k, line) for k, line in enumerate(body.split("\n"), start) if line.strip() and not is_comment(line)]
    kept, notes = _without_footer(kept, name, form)
    kept = _without_further_headers(kept, form, header)
    rows = []
    for number, line in kept:
        row = form.row(line)
        if not row:
            count = len(split_line(line, form.separator))
            raise UserError(
                f"{count} columns where the table has {form.width}: {line.strip()[:40]!r}",
                where=f"{name}, line {number}",
                do="complete the row, or delete it if the file was cut off there",
            )
        rows.append(row)
    return _Cells(list(zip(*rows, strict=True)), [number for number, _ in kept], notes=notes)


def _without_footer(
    lines: list[tuple[int, str]], name: str, form: _Format
) -> tuple[list[tuple[int, str]], tuple[str, ...]]:
    """The lines up to the last that begins with a number, or with what stands for one; the rest sums them up."""
    end = len(lines)
    while end > 0 and not _may_be_row(lines[end - 1][1], form):
        end -= 1
    if end in (0, len(lines)):
        return lines, ()
    first, count = lines[end], len(lines) - end
    what = f"{count} line{'s' if count > 1 else ''} below the table, from line {first[0]} on"
    return lines[:end], (f"{name}: {what} ({first[1].strip()[:30]!r}), hold no samples and are left out.",)


def _may_be_row(line: str, form: _Format) -> bool:
    """Whether a line begins as a row does, be it cut off: with a number, an empty cell, or what stands for a number."""
    row = split_line(line, form.separator)
    cell = row[form.numeric[0]].strip() if len(row) > form.numeric[0] else row[0].strip()
    return not cell or _numeric(cell, form.decimal) or no_finite(cell)


def _without_further_headers(lines: list[tuple[int, str]], form: _Format, header: str) -> list[tuple[int, str]]:
    """The lines without the headers that stand above each further segment: from the first line after a row that is
    none, to a line that repeats the names."""
    if not header:
        return lines
    repeats = [k for k, (_, line) in enumerate(lines) if line == header]
    gone: set[int] = set()
    for k in repeats:
        first = k
        while first > 0 and not form.full(lines[first - 1][1]):
            first -= 1
        gone.update(range(first, k + 1))
    return [line for k, line in enumerate(lines) if k not in gone]
