"""The zero-point offsets of data and model side by side, one table per periodic record."""

from __future__ import annotations

import numpy as np

from ...campaign.device import Device
from ...campaign.record import Trace
from ...posterior.offset import Offset, offsets
from .drives import drive_words
from .quantity import Scale, scale, show_in
from .sheet import Column, Mark, Sheet

_COLUMNS = (
    Column("measure"), Column("data", True, True), Column("model", True, True), Column("data − model", True, True),
    Column("unit"),
    Column("apart", True),
)  # fmt: skip
_FIXED = {"rad": Scale(np.pi / 180, "°"), "1": Scale(0.01, "%")}
_NOTE = "Second half of the record; data and model share its transient. Apart: difference over its error."


def offset_sheet(record: Trace, reading: np.ndarray, device: Device) -> Sheet | None:
    """The table of one record and the model's reading (n,) of it; None if its drive cannot be folded on a period."""
    rows = offsets(record, reading)
    return None if rows is None else _sheet(record, rows, device)


def _sheet(record: Trace, rows: tuple[Offset, ...], device: Device) -> Sheet:
    cells, marks = [], []
    for row in rows:
        chosen = _FIXED.get(row.measure.unit) or scale(max(abs(row.data.value), row.data.error), "m", device)
        data, apart = (show_in(m.value, m.error, chosen) for m in (row.data, row.difference))
        # A settled model repeats itself to the last digit: more of them than the data bear would only confuse.
        least = 0.01 * row.data.error
        model = show_in(row.model.value, max(row.model.error, least), chosen)
        if row.model.error < least:
            model = model._replace(error="")
        ratio = abs(row.difference.value) / row.difference.error if row.difference.error > 0 else 0.0
        cells.append((row.measure.name, *(_pm(s.value, s.error) for s in (data, model, apart)), chosen.unit,
                      f"{ratio:.1f} σ"))  # fmt: skip
        marks.append("warning" if ratio > 3 else "")
    marks_: tuple[Mark, ...] = tuple(marks)
    title = f"Zero-point offset: {record.name} ({drive_words(record, device)})"
    return Sheet(title, _COLUMNS, tuple(cells), marks_, _NOTE)


def _pm(value: str, error: str) -> str:
    return f"{value} ± {error}" if error else value
