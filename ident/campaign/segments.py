"""Several recordings one below the other in a file: time starts again with each of them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ..errors import UserError
from .guess import time_column
from .record import LEAST
from .spec import RecordSpec
from .tables.table import Column, Table


def segments(table: Table, named: str | int | None = None) -> list[slice]:
    """The rows of each recording in a table, all of them if it holds one; `named`: its time column, if that is told.

    A recording begins where the time goes back to what it was in the first row, to within a sample.
    """
    column = time_column(table, named)
    whole = [slice(0, len(table.columns[0].cells) if table.columns else 0)]
    if column is None:
        return whole
    try:
        time = column.numbers()
    except UserError:
        return whole
    steps = np.diff(time)
    back = np.flatnonzero(steps < 0) + 1
    if not len(back) or np.any(np.abs(time[back] - time[0]) > abs(np.median(steps))):
        return whole
    ends = [0, *(int(k) for k in back), len(time)]
    return [slice(a, b) for a, b in zip(ends, ends[1:], strict=False)] if min(np.diff(ends)) >= LEAST else whole


def segment_of(spec: RecordSpec, table: Table) -> Table:
    """The rows that a record means. **Raises:** UserError if it does not say which of several, or one that is not."""
    found = segments(table, spec.columns.get("time")) if spec.rate is None else []
    if spec.segment is None:
        if len(found) < 2:
            return table
        column = time_column(table) or table.columns[0]
        what = f"time runs backwards to where it began: {len(found)} recordings stand one below the other"
        do = f"write a [[record]] for each, with segment = 1 to {len(found)}; `ident new FOLDER FILE` does so"
        raise UserError(what, where=column.place(found[1].start), do=do)
    if spec.segment > max(len(found), 1):
        what = f"segment = {spec.segment}, but {spec.file} holds {max(len(found), 1)}"
        raise UserError(what, where=spec.where or spec.file, do="correct the number, or leave it out")
    rows = found[spec.segment - 1] if found else slice(None)
    return replace(table, columns=tuple(_part(c, rows) for c in table.columns))


def _part(column: Column, rows: slice) -> Column:
    return replace(column, cells=column.cells[rows], lines=column.lines[rows] if len(column.lines) else ())
