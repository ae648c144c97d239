"""Times of day: "13:05:33.512", "2024-03-05T13:05:33.512", "03/05/2024 01:05:33.512 PM"."""

from __future__ import annotations

import math
import re
from collections.abc import Sequence

_HOUR, _DAY = 3600.0, 86400.0
_CLOCK = re.compile(
    r"(?:\d{1,4}[-/.]\d{1,2}[-/.]\d{1,4}[T ,]+)?(?:(\d{1,2}):)?(\d{1,2}):(\d{1,2})(?:[.,:](\d+))?\s*([AP]M)?"
    r"(?:Z|[+-]\d\d:?\d\d)?",
    re.IGNORECASE,
)


def clock_seconds(cells: Sequence[str]) -> list[str] | None:
    """Seconds since midnight of the first day, with as many decimals as are printed; None unless all are times of day.

    A clock begins anew after what its largest field counts. A time earlier than the one before by more than half of
    that is one of the next round.
    """
    matches = [_CLOCK.fullmatch(cell.strip().strip('"').strip()) for cell in cells]
    told = [match.groups() for match in matches if match is not None]
    if len(told) < len(matches):
        return None
    found: list[str] = []
    around = _around(told)
    rounds, before = 0.0, 0.0
    for hours, minutes, whole, fraction, half in told:
        hour = int(hours or 0) % 12 + (12 if half.upper() == "PM" else 0) if half else int(hours or 0)
        seconds = rounds + _HOUR * hour + 60.0 * int(minutes) + int(whole)
        if seconds < before - around / 2:
            rounds, seconds = rounds + around, seconds + around
        before = seconds
        found.append(f"{seconds:.0f}.{fraction}" if fraction else f"{seconds:.0f}")
    return found


def _around(told: Sequence[Sequence[str | None]]) -> float:
    """Seconds after which a clock begins anew, from the fields of all its times: hours, minutes, …, AM or PM."""
    if all(hours is None for hours, *_ in told):
        counts_on = any(int(minutes or 0) >= 60 for _, minutes, *_ in told)
        return math.inf if counts_on else _HOUR
    without = all(half is None for *_, half in told)
    return _DAY / 2 if without and all(1 <= int(hours or 0) <= 12 for hours, *_ in told) else _DAY
