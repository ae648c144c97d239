"""A response that came late beside the drive, as it would have been read in time."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from .corners import drive_at
from .record import Trace

_FIRST = 0.4  # of an interval: what one less at the first sample takes from the integral of the drive (0.35 to 0.47)


def in_time(record: Trace, late: float, begin: int = 0) -> Trace:
    """The record with its response from sample `begin` on moved to where it belongs, if it came so many samples late.

    Whole samples move the response, and where it then says nothing it is masked; what is left moves the drive: a curve
    along its spline, one that is held by where its values begin.
    """
    n, whole = len(record.time), round(late)
    index = np.arange(n)
    source = np.where(index < begin, index, index + whole)
    known = (index < begin) | ((source >= begin) & (source < n))
    source = np.clip(source, 0, n - 1)
    lost = ~known if record.masked is None else ~known | record.masked[source]
    own = replace(record, response=record.response[source], masked=lost if np.any(lost) else None)
    if record.edge is not None:
        return replace(own, edge=record.edge + late - whole)
    apart, period = late - whole, record.period or 0.0
    at = index - apart
    at = np.clip(np.where(at < 0, at + period, np.where(at > n - 1, at - period, at)), 0, n - 1)
    drive = drive_at(record.drive, at)
    if record.start == "rest":  # what is switched on acts for so much less of the first interval
        drive[0] -= apart / _FIRST * record.drive[0]
    return replace(own, drive=drive)
