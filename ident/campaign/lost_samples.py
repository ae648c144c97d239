"""Samples that a recorder lost: a frame that was dropped leaves a gap in the column of times, of whole intervals, or
nearly so where the others are uneven, too."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from .quality.checks import MOST_JITTER, gaps_in
from .quality.gaps import crossed_by_drive
from .tables.table import Column

_ROUNDS = 3  # of the interval, which printed times tell to a digit only, and of the number of samples in each step


def with_lost_samples(columns: Mapping[str, Column]) -> dict[str, Column]:
    """The columns of a record with the rows that are missing in its times put in, their cells as if they had been
    empty; as they are, if no step in time is of several intervals, or what is lost of the drive nobody knows.

    **Arguments:** `columns`: of each role; without one of times nothing is known to be lost.
    """
    if "time" not in columns:
        return dict(columns)
    printed = columns["time"].numbers()
    index = _intervals(printed)
    if index is None or index[-1] + 1 >= 2 * len(index):
        return dict(columns)
    there = np.zeros(index[-1] + 1, dtype=bool)
    there[index] = True
    times = np.interp(np.arange(len(there)), index, printed)
    if "drive" in columns and not crossed_by_drive(columns["drive"], there, times):
        return dict(columns)
    after = np.searchsorted(index, np.arange(len(there)))  # the row of a sample, or the next that there is
    found = {}
    for role, column in columns.items():
        values = times if role == "time" else np.where(there, column.numbers(missing=True)[after], np.nan)
        lines = [column.lines[row] for row in after] if len(column.lines) else ()
        texts = column.printed or (column.cells if not isinstance(column.cells, np.ndarray) else ())
        found[role] = replace(column, cells=values, lines=lines, printed=texts)
    return found


def lost_between(columns: Mapping[str, Column]) -> np.ndarray | None:
    """(n − 1,) how many samples are missing between the rows, by their times; None if none is known to be."""
    index = _intervals(columns["time"].numbers()) if "time" in columns else None
    return None if index is None else np.diff(index) - 1


def times_of(columns: Mapping[str, Column]) -> np.ndarray | None:
    """(n,) the printed times, if there are some and they run on."""
    if "time" not in columns:
        return None
    printed = columns["time"].numbers()
    return printed if np.all(np.diff(printed) > 0) else None


def _intervals(printed: np.ndarray) -> np.ndarray | None:
    """(n,) which sample each time is, if they are those of a uniform grid, or nearly, and some are missing."""
    steps = np.diff(printed)
    step = float(np.median(steps)) if len(steps) else 0.0
    if not step > 0:
        return None
    for _ in range(_ROUNDS):
        counts = np.round(steps / step)
        if not (np.min(counts) >= 1 and 1 < np.max(counts) < len(printed)):
            return None
        index = np.concatenate([[0.0], np.cumsum(counts)])
        step, origin = np.polyfit(index, printed, 1)
    off = np.max(np.abs(printed - origin - step * index))
    if off < MOST_JITTER * step:
        return index.astype(int)
    usual = float(np.median(steps))  # where the others are uneven, too, no grid tells the interval better
    if not len(gaps_in(steps, usual)):
        return None
    return np.concatenate([[0.0], np.cumsum(np.maximum(np.round(steps / usual), 1.0))]).astype(int)
