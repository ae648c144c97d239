"""Long records are ranked and confirmed on excerpts of themselves; the model at the end is fitted to all of them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ..campaign.campaign import Campaign
from ..campaign.record import Trace
from ..fit import Fit
from ..fit.rebuild import fit_at

_MOST = 12_000  # samples of all fitted records together that are still worked on as a whole
_KEPT = 8_000  # samples of longer ones: enough to name an effect, few enough to try several
_BEFORE = 0.25  # of a stretch, simulated before it and not counted, to build up memory
_QUIETER = 0.6  # a second stretch must move less than this, so that what grows with the amplitude shows


def is_long(campaign: Campaign) -> bool:
    """Whether the fitted records are too long to try several models on all of them."""
    return sum(len(r.time) for r in campaign.fitted if not r.excerpt) > _MOST


def working(fitted: Fit) -> Fit:
    """The fit on shortened records, at the same parameter values, without the held-out ones; the fit itself if its
    records are short."""
    campaign = fitted.campaign
    if not is_long(campaign):
        return fitted
    share = _KEPT // len(campaign.fitted)
    records = []
    for record in campaign.fitted:
        records += _excerpts(record, share) if len(record.time) > share else [record]
    return fit_at(fitted.model, replace(campaign, records=tuple(records)), fitted.values)


def _excerpts(record: Trace, length: int) -> list[Trace]:
    """The stretch that moves most and, where the record has one that moves much less, that one too."""
    whole = _sizes(record, length)
    half = _sizes(record, length // 2)
    loudest = max(whole.values())
    middle = min(half, key=lambda i: abs(half[i] / loudest - _QUIETER / 2))
    if abs(half[middle] / loudest - _QUIETER / 2) > _QUIETER / 2:
        return [_part(record, max(whole, key=lambda i: whole[i]), length)]
    return [_part(record, max(half, key=lambda i: half[i]), length // 2), _part(record, middle, length // 2)]


def _sizes(record: Trace, length: int) -> dict[int, float]:
    """How much the response moves in stretches of a length, by their first sample."""
    starts = range(record.skip, len(record.time) - length + 1, max(length // 4, 1))
    return {i: float(np.std(record.response[i : i + length])) for i in starts}


def _part(record: Trace, first: int, length: int) -> Trace:
    """A stretch of a record, and what leads up to it."""
    before = min(first, int(_BEFORE * length))
    part = slice(first - before, first + length)
    start = record.start if part.start == 0 else "unknown"
    return replace(
        record,
        time=record.time[part],
        drive=record.drive[part],
        response=record.response[part],
        start=start,
        skip=before,
        period=None,
        excerpt=True,
    )
