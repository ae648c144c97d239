"""Long records are ranked and confirmed on their liveliest stretch; the accepted model is fitted to all of them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ..campaign.record import Trace
from ..fit import Fit
from ..fit.rebuild import fit_at

_MOST = 12_000  # samples of all fitted records together: enough to name an effect, few enough to try several


def working(fitted: Fit) -> Fit:
    """The fit on shortened records, at the same parameter values; the fit itself if its records are short."""
    records = fitted.campaign.fitted
    if sum(len(r.time) for r in records) <= _MOST:
        return fitted
    share = _MOST // len(records)
    kept = {id(r): _liveliest(r, share) if len(r.time) > share else r for r in records}
    campaign = replace(fitted.campaign, records=tuple(kept.get(id(r), r) for r in fitted.campaign.records))
    return fit_at(fitted.model, campaign, fitted.values)


def _liveliest(record: Trace, length: int) -> Trace:
    """The stretch that moves most, with half as much before it, simulated but not counted, to build up memory."""
    starts = range(record.skip, len(record.time) - length + 1, max(length // 4, 1))
    first = max(starts, key=lambda i: float(np.std(record.response[i : i + length])))
    before = min(first, length // 2)
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
