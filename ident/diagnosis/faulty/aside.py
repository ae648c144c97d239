"""A walk goes on without the records that are suspect: what the others obey is told all the same."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from ...campaign.quality.suspect import ALL, Suspect
from ...fit import Fit
from ..linearised.trajectory import Diverged
from .astray import of_the_others


def without_them(fitted: Fit, suspects: Sequence[Suspect]) -> Fit | None:
    """The fit without suspect records, which its campaign then has as `left_out`; None if these are not clearly the
    fewer, if all records are meant, or if the motion of the others has no bound."""
    campaign = fitted.campaign
    left_out = (*campaign.left_out, *suspects)
    whole = len(campaign.fitted) + len(campaign.left_out)
    if any(one.file == ALL for one in suspects) or 2 * len(left_out) >= whole:
        return None
    fitted = replace(fitted, campaign=replace(campaign, left_out=left_out))
    try:
        for one in suspects:
            fitted = of_the_others(fitted, [trace.name for trace in fitted.campaign.traces].index(one.file))
    except Diverged:
        return None
    return fitted
