"""A response that came late beside the drive, as it would have been read in time."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from scipy.interpolate import CubicSpline

from .record import Trace


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
    own = replace(record, response=record.response[source], masked=lost)
    if record.edge is not None:
        return replace(own, edge=record.edge + late - whole)
    return replace(own, drive=CubicSpline(index, record.drive)(np.clip(index - (late - whole), 0, n - 1)))
