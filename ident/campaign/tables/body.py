"""The rows of a table in a text, as columns of cells."""

from __future__ import annotations

import io
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ...errors import UserError
from .header import is_comment, split_line
from .row_format import RowFormat, stands_for_number


@dataclass(frozen=True)
class Cells:
    """The body of a table: its columns, some of their texts as printed, and the line of each row."""

    columns: Sequence[Sequence[str] | np.ndarray]
    lines: Sequence[int]
    printed: Sequence[Sequence[str]] = ()
    notes: tuple[str, ...] = ()

    def column(self, j: int) -> tuple[Sequence[str] | np.ndarray, Sequence[str]]:
        return self.columns[j], [row[j] for row in self.printed if j < len(row)]


def by_pandas(body: str, start: int, form: RowFormat) -> Cells | None:
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
    return Cells(
        columns, range(start, start + count), [split_line(line, form.separator) for line in sample if line.strip()]
    )


def by_hand(body: str, start: int, name: str, form: RowFormat, header: str) -> Cells:
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
    return Cells(list(zip(*rows, strict=True)), [number for number, _ in kept], notes=notes)


def _without_footer(
    lines: list[tuple[int, str]], name: str, form: RowFormat
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


def _may_be_row(line: str, form: RowFormat) -> bool:
    """Whether a line begins as a row does, be it cut off: with a number, an empty cell, or what stands for a number."""
    row = split_line(line, form.separator)
    cell = row[form.numeric[0]].strip() if len(row) > form.numeric[0] else row[0].strip()
    return not cell or stands_for_number(cell, form.decimal)


def _without_further_headers(lines: list[tuple[int, str]], form: RowFormat, header: str) -> list[tuple[int, str]]:
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
