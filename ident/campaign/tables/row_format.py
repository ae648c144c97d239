"""How the rows of a table in a text are written, and where they begin: numbers look alike in every file."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass

from .header import is_comment, split_line
from .table import is_number, no_finite

_FORMATS = ((";", ","), (";", "."), ("\t", ","), ("\t", "."), (",", "."), (" ", ","), (" ", "."))
_TOP = 500  # lines in which most tables have begun
_COMMA_NUMBER = re.compile(r"\s*[+-]?(\d+(,\d+)?|,\d+)([eE][+-]?\d+)?\s*")


def stands_for_number(cell: str, decimal: str) -> bool:
    """Whether a cell is a number, or what instruments print in place of one."""
    return (bool(_COMMA_NUMBER.fullmatch(cell)) if decimal == "," else is_number(cell)) or no_finite(cell)


@dataclass(frozen=True)
class RowFormat:
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
        return bool(row) and stands_for_number(row[self.numeric[0]], self.decimal)

    def full(self, line: str) -> bool:
        """Whether a line is a row with numbers where the table has numbers, and nothing where it has nothing."""
        row = self.row(line)
        return bool(row) and all(stands_for_number(row[j], self.decimal) for j in self.numeric) and (
            not any(row[j].strip() for j in self.blank)
        )  # fmt: skip


def _format(lines: list[tuple[int, str]]) -> RowFormat:
    """How the table is written, from up to 60 of its lines."""
    sample = [line for _, line in lines[:: max(1, len(lines) // 40)]][:60]
    best, best_score = RowFormat(), 0.0
    for separator, decimal in _FORMATS:
        rows = [split_line(line, separator) for line in sample]
        width, _ = Counter(len(row) for row in rows).most_common(1)[0] if rows else (0, 0)
        rows = [row for row in rows if len(row) == width]
        counts = [sum(stands_for_number(row[j], decimal) for row in rows) for j in range(width)]
        numeric = tuple(j for j, count in enumerate(counts) if 2 * count >= len(rows))
        good = sum(all(stands_for_number(row[j], decimal) for j in numeric) for row in rows) if numeric else 0
        score = sum(counts) + 0.1 * good if width > 1 else 0.01 * sum(counts)
        if numeric and score > best_score:
            blank = tuple(j for j in range(width) if not any(row[j].strip() for row in rows))
            best, best_score = RowFormat(separator, decimal, width, numeric, blank), score
    return best


def _content(lines: Sequence[str]) -> list[tuple[int, str]]:
    """The lines that are neither empty nor remarks, with their numbers from 1."""
    return [(number, line) for number, line in enumerate(lines, 1) if line.strip() and not is_comment(line)]


def _first_row(lines: list[tuple[int, str]], form: RowFormat) -> int:
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


def table_in(lines: Sequence[str]) -> tuple[RowFormat, list[tuple[int, str]]]:
    """How the table among some lines is written, and its first rows with their numbers; none if there is no table."""
    form = _format(_content(lines[len(lines) // 2 :: max(1, len(lines) // 80)]))
    form = form if form.width else _format(_content(lines))
    for top in (lines[:_TOP], lines) if form.width else ():
        content = _content(top)
        first = _first_row(content, form)
        if first >= 0 and (len(content) > first + 2 or len(top) == len(lines)):
            return form, content[first:]
    return form, []
