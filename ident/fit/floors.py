"""Noise floors that the data alone give as bounds only, lowered to what a model leaves.

Beside a broadband drive or the blow of a hammer no frequency is free of motion, and a floor read off the response is
too high by as much as moves there. In what a model leaves there is less motion, so that the same estimate gives less:
it stays a bound, and is the noise once the model lacks nothing.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ..campaign.campaign import Campaign
from ..campaign.noise.floor import noise_floor
from ..campaign.record import VAGUE, Trace
from .result import Fit

_LOWER = 0.8  # of the floor so far: up to a fifth above a floor in doubt a model is adequate (`diagnosis.enough`)


def sharpened(found: Fit) -> Campaign | None:
    """The campaign of a fit with lower noise floors where its own are in doubt; None if no floor falls."""
    readings = iter(found.readings)
    records = [_lowered(r, next(readings)) if isinstance(r, Trace) else r for r in found.campaign.records]
    if all(a is b for a, b in zip(records, found.campaign.records, strict=True)):
        return None
    return replace(found.campaign, records=tuple(records))


def _lowered(record: Trace, reading: np.ndarray) -> Trace:
    """The record with the noise floor of what the model leaves of it, if it has a doubtful and higher one."""
    told, left = record.noise, record.response - reading
    if told.relative_error < VAGUE or not np.all(np.isfinite(left)):
        return record
    later = slice(record.skip, None)
    masked = None if record.masked is None else record.masked[later]
    floor = noise_floor(record.time[later], record.drive[later], left[later], record.period, masked, record.stuck == 0)
    if not floor.sigma < _LOWER * told.sigma:
        return record
    return replace(record, noise=replace(floor, method=f"{floor.method}, in what the model leaves"))
