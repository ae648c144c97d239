"""Levels of sweeps whose drives are not what they are called: a force that droops, a gain that was read wrongly.

Each level then has a number s of its own, a drive of (1 + s) times what the table tells, found by Gauss-Newton steps
beside everything that the model absorbs; what all levels share is the device's gain.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ...campaign.campaign import Campaign
from ...campaign.record import Sweep, same_level
from ...fit import Fit, fit
from ...fit.own_number import own_drive
from ..linearised.regression import Regression, prepare
from ..linearised.shorten import working
from .alternated import FEWEST, alternated
from .differing import Differing


def differing_levels(fitted: Fit) -> Differing | None:
    """The drives of all levels, held-out ones too, of a fit to sweeps; None where too few of them were fitted."""
    levels = _Levels(fitted.campaign)
    inside = levels.inside
    if len(inside) < FEWEST:
        return None
    refit = lambda now, logarithms: fit(fitted.model, levels.driven(np.expm1(logarithms[:, 0])), initial=now.values)
    along = lambda now: _along(prepare(working(now)), levels)
    settled = alternated(fitted, inside, np.zeros((levels.count, 1)), along, refit, shared=True)
    if settled is None:
        return None
    now, logarithms, errors = settled
    for k in np.setdiff1d(np.arange(levels.count), inside):
        logarithms[k], errors[k] = own_drive(now.model, now.values, levels.of(k))
    sizes = np.expm1(logarithms)
    now = fit(fitted.model, levels.driven(sizes[:, 0]), initial=now.values, most=1)
    found = Differing("drive", levels.names, sizes, errors, now, len(inside) - 1)
    return found if np.all(np.isfinite(sizes)) else None


def _along(regression: Regression, levels: _Levels) -> tuple[Regression, np.ndarray]:
    """A regression, and what the logarithms of the drives of the fitted levels do to it, whitened, (levels, n)."""
    plane = regression.plane
    assert plane is not None  # there are sweeps
    curves = plane.curves
    own = np.concatenate([levels.which[s.name][kept] for s, kept in zip(curves.sweeps, curves.settled, strict=True)])
    rows = np.array([curves.rows((own == k).astype(complex)) for k in levels.inside])[:, plane.order]
    return regression, rows


class _Levels:
    """The drive levels of a campaign's sweeps, weakest first.

    `which`: of each sweep, by name, (n,) the level of every point; `inside`: the levels that were fitted.
    """

    def __init__(self, campaign: Campaign) -> None:
        self.campaign = campaign
        sweeps = campaign.sweeps
        level = np.concatenate([sweep.level for sweep in sweeps])
        groups = same_level(level)
        self.count, volts = len(groups), sweeps[0].drive_channel
        self.names = tuple(f"{float(np.median(level[rows])) / volts.factor:.4g} {volts.unit}" for rows in groups)
        all_of = np.zeros(len(level), int)
        for k, rows in enumerate(groups):
            all_of[rows] = k
        parts = np.split(all_of, np.cumsum([len(sweep.level) for sweep in sweeps])[:-1])
        self.which = {sweep.name: part for sweep, part in zip(sweeps, parts, strict=True)}
        fitted = [self.which[sweep.name] for sweep in campaign.fitted_sweeps]
        self.inside = np.unique(np.concatenate([np.zeros(0, int), *fitted]))

    def driven(self, sizes: np.ndarray) -> Campaign:
        """The campaign with drives that are larger by shares, (levels,)."""
        told = (
            replace(one, stronger=sizes[self.which[one.name]]) if isinstance(one, Sweep) else one
            for one in self.campaign.records
        )
        return replace(self.campaign, records=tuple(told))

    def of(self, k: int) -> list[Sweep]:
        """The points of one level."""
        parts = [sweep.only(np.flatnonzero(self.which[sweep.name] == k)) for sweep in self.campaign.sweeps]
        return [part for part in parts if len(part.frequency)]
