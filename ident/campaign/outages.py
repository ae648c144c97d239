"""Outages of a recorder: where nobody knows what the drive did in a gap, a record ends and another begins in motion."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from .channel import channel_of
from .lost_samples import lost_between, with_lost_samples
from .record import LEAST
from .spec import RecordSpec
from .tables.table import Column

_MOST = 8  # stretches of a file, each with a start of its own to be fitted; a logger that stops oftener is at fault


def stretches(columns: Mapping[str, Column]) -> list[dict[str, Column]]:
    """The columns of each stretch of a record between outages, the rows that were lost inside put in; of the whole
    record, as it is, where there are none or too many.

    The longest gaps are taken for outages, no more of them than it takes to say what the drive did in the others.
    """
    whole = with_lost_samples(columns)
    lost = lost_between(whole)
    if lost is None or "drive" not in columns:
        return [whole]
    for least in np.unique(lost[lost > 0])[::-1]:
        ends = [0, *(int(k) + 1 for k in np.flatnonzero(lost >= least)), len(lost) + 1]
        if len(ends) > _MOST + 1 or min(np.diff(ends)) < LEAST:
            break
        rows = [np.arange(a, b) for a, b in zip(ends, ends[1:], strict=False)]
        parts = [with_lost_samples({role: column.at(own) for role, column in columns.items()}) for own in rows]
        if all(lost_between(part) is None for part in parts):
            return parts
    return [whole]


def of_use(
    spec: RecordSpec, parts: Sequence[dict[str, Column]]
) -> tuple[list[tuple[RecordSpec, dict[str, Column]]], list[str]]:
    """The stretches of a record that show something, each with what is said of it, and a note if there are several.

    The first is called and begins like the whole. What is to be skipped is counted from the begin of the record. A
    stretch of which too little is left, or whose response never changes, shows nothing; all stay where none does.
    """
    if len(parts) == 1:
        return [(spec, parts[0])], []
    since = [part["time"].numbers() - parts[0]["time"].numbers()[0] for part in parts]
    said = [spec]
    for k in range(1, len(parts)):
        left = _left_of(spec.skip, since[k], parts[k]["time"])
        said.append(replace(spec, part=k + 1, skip=left, start="unknown"))
    every = list(zip(said, parts, strict=True))
    shown = [pair for pair, times in zip(every, since, strict=True) if _shows(*pair, times)] or every
    return shown, [_note_on(spec.file, parts, len(shown))]


def _left_of(skip: float | int, times: np.ndarray, column: Column) -> float | int:
    """What is still to be skipped of a stretch: samples, or s, as it is given."""
    before = times[0] / _unit_of(skip, times, column)
    return max(0, skip - round(before)) if isinstance(skip, int) else max(0.0, skip - before)


def _shows(spec: RecordSpec, part: Mapping[str, Column], times: np.ndarray) -> bool:
    response, counted = part["response"].numbers(missing=True), len(times)
    if isinstance(spec.skip, int):
        counted -= spec.skip
    else:
        begin = times[0] + spec.skip * _unit_of(spec.skip, times, part["time"])
        counted = np.count_nonzero(times >= begin - 1e-6 * np.median(np.diff(times)))
    return bool(counted >= LEAST and len(np.unique(response[~np.isnan(response)])) > 1)


def _unit_of(skip: float | int, times: np.ndarray, column: Column) -> float:
    """A sample or a second in the unit of a column of times."""
    return float(np.median(np.diff(times))) if isinstance(skip, int) else 1 / channel_of(column, "s", [], "time").factor


def _note_on(file: str, parts: Sequence[Mapping[str, Column]], shown: int) -> str:
    """What was made of a record with outages, in words."""
    first = parts[1]["time"].place(0)
    less = len(parts) - shown
    few = (
        f" {less} of them {'are' if less > 1 else 'is'} left out: all is skipped there, or the response never changes."
        if less
        else ""
    )
    return (
        f"{file}: the recorder stopped on the way (before {first}), and nobody knows what the drive did then: "
        f"its {len(parts)} stretches are records of their own; the later ones begin in motion.{few}"
    )
