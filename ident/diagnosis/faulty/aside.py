"""A walk goes on without the records that are suspect: what the others obey is told all the same, and that then tells
better what is wrong with them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import lru_cache

from ...campaign.quality.suspect import ALL, Suspect, set_aside
from ...fit import Fit
from ..linearised.trajectory import Diverged
from .astray import of_these
from .suspects import told_outside


def without_them(fitted: Fit, suspects: Sequence[Suspect]) -> Fit | None:
    """The fit of the others, whose campaign has the suspects as `left_out`; None if these are not clearly the fewer, if
    all records are meant or it is not clear which of one name, or if the motion of the others has no bound."""
    before, campaign = fitted.campaign, set_aside(fitted.campaign, suspects)
    each = len(campaign.left_out) == len(before.left_out) + len(suspects)
    if any(one.file == ALL for one in suspects) or not each or len(campaign.left_out) >= len(campaign.fitted):
        return None
    try:
        return of_these(fitted, campaign)
    except Diverged:
        return None


@lru_cache(maxsize=8)  # the diagnosis, the terminal and the page ask
def left_out(fitted: Fit) -> tuple[Suspect, ...]:
    """The records that were left out of a fit, and what is wrong with them as its model tells; as it was told before
    where that does not explain them."""
    known, float_too = fitted.campaign.left_out, any(record.floats for record in fitted.campaign.fitted)
    traces = (*fitted.campaign.traces, *(replace(one, floats=one.floats or float_too) for one, _ in known))
    at = len(fitted.campaign.traces)
    told = [told_outside(fitted.model, fitted.values, fitted.fitted.error_over_noise, traces, at + k)
            for k in range(len(known))]  # fmt: skip
    return tuple(now or before for now, (_, before) in zip(told, known, strict=True))
