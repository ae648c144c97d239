"""Times of day: "13:05:33.512", "2024-03-05T13:05:33.512", "03/05/2024 01:05:33.512 PM"."""

from __future__ import annotations

import re
from collections.abc import Sequence

_DAY = 86400.0
_CLOCK = re.compile(
    r"(?:\d{1,4}[-/.]\d{1,2}[-/.]\d{1,4}[T ,]+)?(?:(\d{1,2}):)?(\d{1,2}):(\d{1,2})(?:[.,:](\d+))?\s*([AP]M)?"
    r"(?:Z|[+-]\d\d:?\d\d)?",
    re.IGNORECASE,
)


def clock_seconds(cells: Sequence[str]) -> list[str] | None:
    """Seconds since midnight of the first day, with as many decimals as are printed; None unless all are times of day.

    A time earlier than the one before by more than half a day is one of the next day.
    """
    found: list[str] = []
    days, before = 0.0, 0.0
    for cell in cells:
        match = _CLOCK.fullmatch(cell.strip().strip('"').strip())
        if match is None:
            return None
        hours, minutes, whole, fraction, half = match.groups()
        hour = int(hours or 0) % 12 + (12 if half.upper() == "PM" else 0) if half else int(hours or 0)
        seconds = days + 3600.0 * hour + 60.0 * int(minutes) + int(whole)
        if seconds < before - _DAY / 2:
            days, seconds = days + _DAY, seconds + _DAY
        before = seconds
        found.append(f"{seconds:.0f}.{fraction}" if fraction else f"{seconds:.0f}")
    return found
