"""When is a model good enough, and when is a term more than a finer shape of another one?"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Literal

import numpy as np

from ...campaign.record import VAGUE, Sweep, Trace
from ...effects.effect import AbstractEffect
from ...fit import Fit
from ..linearised.regression import Regression
from .criterion import Left, behind
from .force_noise import Pushed, pushed_by_noise

Role = Literal["effect", "shape-refinement"]

ANOTHER_LAW = 0.001  # of the first excess: structured misfit beyond which a name is in doubt; see `lacking`
AT_FLOOR = 1.05  # error over noise, and twice the doubt of the floor more, up to a doubt of
_MOST_DOUBT = 0.1
_LEFT_AT_FLOOR = 1 - 1 / AT_FLOOR**2  # of the χ²: what a model at a floor that is known may leave to a law
_SHAPE = 0.01  # of the first excess: less is shape refinement, not an effect
_WORTH = 0.25  # of what is left: a refinement that promises less bends the law of another effect, not the device's
MOST_OF_IT = 0.5  # of what is left: more than that a rival answer must take away
LITTLE = 0.05  # of a misfit: what leaves no more nearly explains it
LEAST = 0.2  # of what is left: where every effect promises less, the library lacks the one that is missing
SAME_SHAPE = 0.003  # of the excess: within this two laws differ in shape only
_SAME_WHILE_LACKING = 0.02  # the same as long as ten times as much is unexplained
FAR = 4.0  # χ² per sample, more than a wrong noise floor would make


def adequate(regression: Regression, promise: float = 0.0) -> bool:
    """Whether the error stands at the noise floor, within what is known of that floor.

    What counts is the whitened error without mains hum and initial states, and without noise of the force: they are no
    shortcoming of a model. `promise`: the most by which one effect lowers the χ². Of noise, whatever its level, none
    takes more than a model at its floor may leave. Not so on curves alone: there a way back that differs is noise, and
    as smooth as they are.
    """
    may_be_noise = promise < _LEFT_AT_FLOOR * regression.chi2 or not regression.fit.campaign.fitted
    return may_be_noise and (at_floor(regression.chi2, regression) or noise_of_force(regression) is not None)


def speaks_for(regression: Regression, whole: Fit) -> bool:
    """Whether what a model leaves of excerpts is what it leaves of all samples: a slow memory shows in these alone."""
    part = regression.chi2 / regression.n
    return regression.fit is whole or whole.fitted.error_over_noise**2 < FAR * part


def noise_of_force(regression: Regression) -> Pushed | None:
    """The noise of the force, where it is all that stands above the noise floors."""
    pushed = None if at_floor(regression.chi2, regression) else pushed_by_noise(regression)
    return pushed if pushed is not None and at_floor(pushed.level**2 * regression.n, regression) else None


def at_floor(chi2: float, regression: Regression) -> bool:
    """Whether so much of the χ² is what noise leaves, as far as the noise floors are known."""
    campaign = regression.fit.campaign
    return float(np.sqrt(chi2 / regression.n)) < floor_of([*campaign.fitted, *campaign.fitted_sweeps])


def floor_of(records: Sequence[Trace | Sweep]) -> float:
    """Error over noise up to which records stand at their noise floors, as far as these are known. Of traces that all
    have vague ones hardly more than the order is known: then what is left tells by its structure, and held-out records.
    """
    vague = all(isinstance(r, Trace) and r.noise.relative_error >= VAGUE for r in records)
    return AT_FLOOR + 2 * _doubt(records) if vague else known_floor_of(records)


def known_floor_of(records: Sequence[Trace | Sweep]) -> float:
    """The same of floors that are vague as of those that are in doubt."""
    return AT_FLOOR + 2 * min(_doubt(records), _MOST_DOUBT)


def _doubt(records: Sequence[Trace | Sweep]) -> float:
    return float(np.mean([r.noise.relative_error for r in records] or [0.0]))


def worth_a_name(drop: float, first: Regression) -> bool:
    """Whether a fall of χ² is more than laws of one kind differ by; `first`: the regression before any effect was
    added.

    No law has exactly the device's shape, so something always remains significant; to add it would name physics that
    is not there.
    """
    return drop > _SHAPE * first.above_noise


def role_of(effect: AbstractEffect, regression: Regression, left: float, first: Regression) -> Role:
    """What a term is that lowers the χ² of a regression to what is `left`: an effect removes a share of the first
    excess that is worth a name; the first one always is, and a constant, which bends to no shape. So is one that leaves
    nothing of what it met: a law bent to refine the shape of another leaves something."""
    named = regression is first or effect.is_constant or worth_a_name(regression.best_chi2 - left, first)
    return "effect" if named or _nothing_left(regression, left) else "shape-refinement"


def _nothing_left(regression: Regression, left: float) -> bool:
    """Whether a term leaves so little of the excess that it met as no verdict calls another law, as far as chance and
    the doubt of the noise floors let one see."""
    campaign, n = regression.fit.campaign, regression.n
    unseen = np.sqrt(2.0 * n) + 2 * _doubt([*campaign.fitted, *campaign.fitted_sweeps]) * n
    return max(left - n, unseen) < ANOTHER_LAW * regression.excess


def another_law(excess: float, first: Regression) -> bool:
    """Whether an excess over noise is as much as no verdict calls a finer shape of what was found."""
    return excess > ANOTHER_LAW * first.above_noise


def not_worth_adding(regression: Regression, best: float, first: Regression) -> bool:
    """Whether the best fall of χ², promised or reached, is little of what is left, or no more than a finer shape of
    what was found where the model is adequate without it."""
    share = best / regression.to_explain
    if first in (regression, regression.instead_of):
        return share < LEAST and regression.chi2 > FAR * regression.n
    if worth_a_name(best, first):
        return share < LEAST
    return share < _WORTH or adequate(regression, promise=best)


def laws_differ_by(regression: Regression, left: float) -> float:
    """Fall of χ² that a law may owe to having more shapes to bend than a simpler one; `regression`: of the model
    without either, `left`: χ² with the better of them.

    No library law has exactly the shape of the device's. But the simpler may win only by as much as the better one
    itself still lacks; where most of the misfit is still to be explained by further effects, a rival bends to mimic
    some of them, and more is allowed for.
    """
    excess, lacks = min(regression.chi2 - regression.n, regression.excess), left - regression.n
    return max(min(SAME_SHAPE * excess, lacks), min(_SAME_WHILE_LACKING * excess, 0.1 * lacks))


def superfluous(without: Regression, with_it: Regression, first: Regression) -> bool:
    """Whether a model does as well without a term: by the information criterion, or at the noise floor and nearly.

    At the floor is what the refit has reached, not what its parameters could still absorb: a limit may stop them.
    """
    loss = without.chi2 - with_it.chi2
    settled = at_floor(without.fit_chi2, without) and loss < _LEFT_AT_FLOOR * without.fit_chi2
    fair = behind(Left(without.residual, without.fit.freedom), Left(with_it.residual, with_it.fit.freedom))
    return fair < 0 or (settled and not worth_a_name(loss, first))
