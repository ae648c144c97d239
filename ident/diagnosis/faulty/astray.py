"""A record that is faulty may have led the choice of the linear model astray: how late a held drive acts, the constant,
the modes. What the others choose without it, all are then asked beside."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from ...campaign.campaign import Campaign
from ...fit import Fit, fit
from ...fit.linear.start_model import linear_choice, start_model, with_drives
from ..evidence.enough import MOST_OF_IT
from .faults import told_by_others, without


def of_these(fitted: Fit, campaign: Campaign) -> Fit:
    """The fit of fewer records; of the first model of a walk, that which these choose, with their drives."""
    if not _is_first(fitted):
        return fit(fitted.model, campaign, initial=fitted.values)
    campaign = with_drives(campaign)
    return fit(start_model(campaign), campaign)


def as_others_choose(fitted: Fit, records: Sequence[int]) -> Fit | None:
    """The fit of all records with the linear model and the drives that the others choose, without the one of `records`
    that leaves least when it is left out; None if without it no more than before agree, or they choose the same."""
    campaign = fitted.campaign
    if not records or not _is_first(fitted):
        return None
    rests = {i: rest for i in records if (rest := told_by_others(fitted, i)) is not None}
    left = {i: _excess(rest.left) for i, rest in rests.items()}
    worst = min(left, key=lambda i: left[i], default=None)
    if worst is None or not left[worst] < MOST_OF_IT * (fitted.fitted.error_over_noise**2 - 1.0):
        return None
    bare = without(campaign, worst)
    read, choice = with_drives(bare), linear_choice(bare)
    others = fit(start_model(read), read)
    if not others.fitted.error_over_noise**2 - 1.0 < MOST_OF_IT * left[worst]:
        return None
    gone = campaign.traces[worst]
    free = choice is not None and gone.between == "auto" and gone.driven
    as_read = replace(gone, edge=choice.chosen.edges.of(gone.drive)) if choice is not None and free else gone
    rest = iter(others.campaign.records)
    whole = tuple(as_read if record is gone else next(rest) for record in campaign.records)
    return fit(others.model, replace(campaign, records=whole), initial=others.values)


def _is_first(fitted: Fit) -> bool:
    return fitted.model.names == start_model(fitted.campaign).names


def _excess(left: np.ndarray) -> float:
    return float(np.mean(left**2)) - 1.0
