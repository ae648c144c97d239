"""Tables in text files: whatever separator, decimal sign, encoding and preamble the instrument wrote.

The numbers are found first, because they look alike in every format; the header is the text just above them.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from ...errors import UserError
from .body import Cells, by_hand, by_pandas
from .clock import clock_seconds
from .header import header_of
from .opening import MOST_DATA, MOST_TEXT, check_file, read_bytes
from .preamble import Told, preamble_words
from .row_format import RowFormat, table_in
from .sampling import is_time, runs_by, with_time, without_counter, without_repeats
from .table import Column, Table, split_header, with_unit_row

LEAST_FOR_PANDAS = 200_000
"""Characters of a table from which on pandas reads it: for less, its import (0.4 s) costs more than it saves."""


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


def read_text_table(path: Path, name: str, own_unit: str) -> Table:
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
    form, rows = table_in(lines)
    if not rows:
        what = f"no table of numbers in {'this file' if len(head) == len(text) else 'the first megabyte of this file'}"
        raise UserError(what, where=name, do="a record is a CSV with one row per sample")
    start = rows[0][0]
    header = header_of([line for line in lines[: start - 1] if line.strip()], form.separator, form.width)
    body = text.split("\n", start - 1)[-1] if start > 1 else text
    at_once = by_pandas(body, start, form) if len(body) > LEAST_FOR_PANDAS else None
    cells = at_once or by_hand(body, start, name, form, header.line)
    beside = [form.row(line)[: form.numeric[0]] for _, line in rows] if form.numeric[0] >= 2 else []
    told = preamble_words([*header.rows, *beside])
    begin = Column(name, "", "", None, 1, cells.column(form.numeric[0])[0], (), form.decimal)
    if told.step is not None and runs_by(told.step, begin) and not told.horizontal:
        told = replace(told, horizontal="s")
    timed = told.step is None or runs_by(told.step, begin)
    columns = _columns(name, cells, form, _names(header.names, form, told, timed), header.units, told, own_unit)
    notes = () if header.names or told.horizontal or told.step else (_UNNAMED.format(name),)
    if told.sensitivity:
        notes += (_SENSITIVITY.format(name, told.sensitivity),)
    table = Table(name, tuple(columns), (*notes, *cells.notes))
    return without_counter(without_repeats(with_time(table, told)))


def _names(given: Sequence[str], form: RowFormat, told: Told, timed: bool) -> list[str]:
    """A name for each column; where there is no header, those of the channels that the preamble tells, and `timed`, if
    they begin with the time."""
    names = [*given, *(f"column {j + 1}" for j in range(len(given), form.width))]
    if not given and (told.horizontal or told.step):
        own = told.sources or [f"CH{j + 1}" for j in range(len(form.numeric))]
        for j, one in zip(form.numeric, [*["time"] * timed, *own], strict=False):
            names[j] = one
    return names


_UNNAMED = "{}: no header row; the columns are numbered from 1."
_SENSITIVITY = (
    '{}: "{}" stands above the table; if that is the sensor of a column in volts, write it into its [[record]], as in '
    'scale = {{ response = "5 um/V" }}.'
)


def _columns(
    name: str, cells: Cells, form: RowFormat, names: Sequence[str], row: Sequence[str], told: Told, own_unit: str
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
