"""Outages of a recorder: where nobody knows what the drive did in a gap, a record ends and another begins in motion."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

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


def spec_of(spec: RecordSpec, part: int) -> RecordSpec:
    """What is said of a stretch of a record, counted from 1; the first is called and begins like the whole."""
    return spec if part == 1 else replace(spec, part=part, skip=0, start="unknown")


def note_on(spec: RecordSpec, parts: Sequence[Mapping[str, Column]]) -> str:
    """What was made of a record with outages, in words."""
    first = parts[1]["time"].place(0)
    return (
        f"{spec.file}: the recorder stopped on the way (before {first}), and nobody knows what the drive did then: "
        f"its {len(parts)} stretches are records of their own; the later ones begin in motion."
    )
