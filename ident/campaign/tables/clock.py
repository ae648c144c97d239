"""Times of day: "13:05:33.512", "2024-03-05T13:05:33.512", "03/05/2024 01:05:33.512 PM"."""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from itertools import pairwise
from statistics import median

_HOUR, _DAY = 3600.0, 86400.0
_LONGER = 10.0  # than the usual step, one across the full hour
_CLOCK = re.compile(
    r"(?:\d{1,4}[-/.]\d{1,2}[-/.]\d{1,4}[T ,]+)?(?:(\d{1,2}):)?(\d{1,2}):(\d{1,2})(?:[.,:](\d+))?\s*([AP]M)?"
    r"(?:Z|[+-]\d\d:?\d\d)?",
    re.IGNORECASE,
)


def clock_seconds(cells: Sequence[str]) -> list[str] | None:
    """Seconds since midnight of the first day, with as many decimals as are printed; None unless all are times of day.

    A clock begins anew after what its largest field counts. A time earlier than the one before by more than half of a
    day is one of the next; of half a day or an hour, which a second recording may begin anew as well, if the step to it
    is not much longer than the others.
    """
    matches = [_CLOCK.fullmatch(cell.strip().strip('"').strip()) for cell in cells]
    told = [match.groups() for match in matches if match is not None]
    if len(told) < len(matches):
        return None
    found: list[str] = []
    around = _around(told)
    printed = [_of_day(*fields) for fields in told]
    on = [b - a for a, b in pairwise(printed) if b > a]
    longest = _DAY / 2 if around == _DAY else max(_LONGER * median(on or [0.0]), 2.0)
    rounds, before = 0.0, 0.0
    for seconds, (*_, fraction, _) in zip(printed, told, strict=True):
        if rounds + seconds < before and rounds + seconds + around - before < longest:
            rounds += around
        before = rounds + seconds
        found.append(f"{before:.0f}.{fraction}" if fraction else f"{before:.0f}")
    return found


def _of_day(hours: str | None, minutes: str | None, whole: str | None, _: str | None, half: str | None) -> float:
    """Whole seconds since midnight, or since the hour."""
    hour = int(hours or 0) % 12 + (12 if half.upper() == "PM" else 0) if half else int(hours or 0)
    return _HOUR * hour + 60.0 * int(minutes or 0) + int(whole or 0)


def _around(told: Sequence[Sequence[str | None]]) -> float:
    """Seconds after which a clock begins anew, from the fields of all its times: hours, minutes, …, AM or PM."""
    if all(hours is None for hours, *_ in told):
        counts_on = any(int(minutes or 0) >= 60 for _, minutes, *_ in told)
        return math.inf if counts_on else _HOUR
    without = all(half is None for *_, half in told)
    return _DAY / 2 if without and all(1 <= int(hours or 0) <= 12 for hours, *_ in told) else _DAY
