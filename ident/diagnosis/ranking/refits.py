"""Ranking by short refits: slower than the score statistics, and right where those cannot be believed."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ...effects.effect import AbstractEffect
from ...effects.registry import Registry
from ...pulse import Report
from ..linearised.regression import Regression
from ..side_by_side import at_once
from .confirm import base_of, start_of, weigh, with_effect
from .score import Candidate

FEW = 15  # steps of least squares: enough to tell who gains much
_REFITTED = 12  # of the candidates, by their scores: those further down have never gained much


def by_refits(
    regression: Regression, candidates: Sequence[Candidate], library: Registry, report: Report
) -> list[Candidate]:
    """The first candidates in the order of what a short refit of each gains, then the others as they were.

    A fit that lacks an effect bends its own parameters to mimic it. Where inertia hardly matters they bend far (a lag
    becomes a low quality factor), and what a candidate gains once they are free to bend back is not to be seen from
    the slope at the fit.
    """
    report(f"scores cannot be believed here: refitting {min(len(candidates), _REFITTED)} effects instead")
    few = candidates[:_REFITTED]
    found = at_once(lambda one: _glimpsed(regression, one, library[one.name]), few, report, "refits")
    order = sorted(found, key=lambda c: -(c.drop - c.dof * np.log(regression.n)))
    return [*order, *candidates[_REFITTED:]]


def _glimpsed(regression: Regression, candidate: Candidate, effect: type[AbstractEffect]) -> Candidate:
    """The candidate with the fall of χ² that a few steps of a fit reach."""
    before = regression.fit
    model = with_effect(before, effect)
    start = np.concatenate([base_of(regression), start_of(model, candidate, before.scales)])
    found = weigh(regression, model, candidate, [start], FEW)
    if not np.isfinite(found.chi2):
        return candidate._replace(drop=0.0, predicted_gain=0.0)
    return candidate._replace(
        drop=max(regression.best_chi2 - found.chi2, 0.0), predicted_gain=float(np.clip(found.gain, 0, 1))
    )
