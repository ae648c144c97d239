"""Confirming a candidate: the model with the effect is fitted in full simulation, from the size that the score
predicts."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from ...campaign.campaign import Campaign
from ...effects.effect import AbstractEffect
from ...fit import Fit, fit
from ...fit.minimise import minimise, refit
from ...fit.problem import WORST
from ...fit.rebuild import fit_at
from ...fit.solve import How
from ...fit.zeros import numbers_of_zeros
from ...model import Model
from ..evidence.criterion import behind, clearly_better
from ..evidence.enough import worth_a_name
from ..linearised.regression import Regression
from ..linearised.shorten import CRAWLS, is_long
from ..linearised.whiten import whiten
from .score import score
from .splits import split_starts, takes_over
from .starts import (
    all_free,
    base_of,
    begins_as_it_may,
    is_possible,
    mirrored,
    nearly_absent,
    refinements,
    shapes_of,
    start_of,
    with_effect,
    with_one,
    without_unseen,
)
from .usual_form import numbers_told
from .weigh import Candidate


class Confirmed(NamedTuple):
    """A candidate after its refit.

    **Arguments:** `model` and `values` (SI) of the refit; `chi2`: whitened, comparable with the regression's; `gain`:
    share of the regression's excess over noise that it removed; `left` (n,): the whitened residual, and `numbers` that
    the records had to tell (see `evidence` and `usual_form`); `possible`: whether the effect ended with a sign that it
    can have and a motion that has a bound; `begun`: the initial states there, (records, s) SI, which samples alone do
    not always tell.
    """

    candidate: Candidate
    model: Model
    values: np.ndarray
    chi2: float
    gain: float
    left: np.ndarray
    numbers: float
    possible: bool
    begun: np.ndarray | None = None


_LEAVES = 1.2  # χ² per sample: a memory that leaves more may have started in the wrong place, a law may need refining
_RACE = 12  # steps of the best start, before earlier shapes are freed


def confirm(
    regression: Regression,
    effect: type[AbstractEffect],
    candidate: Candidate,
    most: int = CRAWLS,
    base: np.ndarray | None = None,
    refining: bool = True,
) -> Confirmed:
    """Refit with the candidate on, in at most so many steps.

    Its own shapes race from the best points of their grids, the best also with what it moves the other parameters to,
    and on curves with the other sign: beside an effect that acts by its square, which may grow severalfold to make room
    for it, the slope there may have the wrong one. Then those of effects accepted before race from theirs, as a new
    term may free them. Other words of its choices that are worth it are refitted too, and the best of all is taken.

    `base`: values of the other parameters to start from, if not those of the regression's fit; `refining`: whether what
    refines its law is asked for, where it may be and leaves more than noise.
    """
    asked = (effect, *candidate.words.items(), *candidate.values.items(), most, None if base is None else tuple(base))
    known = regression.refitted
    if asked not in known:
        known[asked] = _best_of_words(regression, effect, candidate, most, base)
    found = known[asked]
    if not refining or not found.possible or leaves_noise(found, regression):
        return found
    if (finer := (*asked, "finer")) not in known:
        known[finer] = refined(regression, effect, found, most)
    return known[finer]


def _best_of_words(
    regression: Regression, effect: type[AbstractEffect], candidate: Candidate, most: int, base: np.ndarray | None
) -> Confirmed:
    """The best refit of those with the words of a candidate's choices that are worth one: that promise clearly more
    than another kept, or that were promising where it leaves more than noise. Where the usual ones end in what cannot
    be others bend to mimic, too, unless they leave nothing but noise."""
    found = _refitted(regression, effect, candidate, most, base)
    for other in candidate.otherwise:
        more = other.promised(regression) - (regression.best_chi2 - found.chi2)
        if worth_a_name(more, regression) or not leaves_noise(found, regression):
            again = _refitted(regression, effect, other, most, base)
            better = behind(again, found) < 0 if found.possible else leaves_noise(again, regression)
            found = again if again.possible and better else found
    return found


def leaves_noise(found: Confirmed, regression: Regression) -> bool:
    """Whether a refit leaves about noise: then nothing is missing from its law."""
    return found.possible and found.chi2 <= _LEAVES * regression.n


def refined(regression: Regression, effect: type[AbstractEffect], found: Confirmed, most: int) -> Confirmed:
    """A refit with what refines its law free, where the records clearly choose that."""
    names = refinements(effect)
    if not names or not np.isfinite(found.chi2):
        return found
    freer = replace(found.model, freed=found.model.freed | names)
    scored = score(regression, {effect.name: all_free(effect)})
    first = scored[0] if scored else found.candidate
    own = [start_of(freer, first._replace(values=one), regression.fit.scales) for one in (first.values, *first.near)]
    candidate = found.candidate._replace(dof=found.candidate.dof + len(names))
    # Where the plain law has ended a search stands well from its first step, and would win a race that it loses.
    begun = [[np.concatenate([found.values[: -len(one)], one]) for one in own], [found.values]]
    tried = [weigh(regression, freer, candidate, starts, most) for starts in begun]
    best = min(tried, key=lambda one: (not one.possible, one.chi2))
    return best if best.possible and clearly_better(best, found) else found


def _refitted(
    regression: Regression, effect: type[AbstractEffect], candidate: Candidate, most: int, base: np.ndarray | None
) -> Confirmed:
    """`confirm`, for the first time."""
    before = regression.fit
    model = without_unseen(with_effect(before, effect, candidate.words), candidate)
    scored = [candidate, *(candidate._replace(values=values) for values in candidate.near)]
    parent = base is None
    base = base_of(regression) if base is None else base
    starts = [np.concatenate([base, start_of(model, one, before.scales)]) for one in scored]
    if candidate.beside is not None:
        starts.insert(1, np.concatenate([candidate.beside, start_of(model, candidate, before.scales)]))
    if regression.plane is not None or regression.passes is not None:
        starts.append(np.concatenate([base, start_of(model, mirrored(candidate, model), before.scales)]))
    if freed := shapes_of(model, before):
        own = refit(model, before.campaign, starts, _RACE).values
        starts = [own, *(with_one(own, i, value) for i, value in freed)]
    found = weigh(regression, model, candidate, starts, most)
    # Damping of the wrong sign, as scores may predict it where little is known, has no motion to start from, nor has a
    # sensor that saturates below what it read.
    faint = start_of(model, nearly_absent(candidate, model), before.scales)
    if not np.max(np.abs(found.left), initial=0.0) < WORST:
        return weigh(regression, model, candidate, [np.concatenate([base, faint])], most)
    if parent and not found.chi2 < regression.best_chi2:  # the search left where the fit without the effect stands
        own = (regression.instead_of or regression).fit.values
        there = [np.concatenate([own, one]) for one in (start_of(model, candidate, before.scales), faint)]
        found = min(found, weigh(regression, model, candidate, there, most), key=lambda one: one.chi2)
    allowed = [start for start in starts if begins_as_it_may(model, start)]
    if not found.possible and 0 < len(allowed) < len(starts):
        found = weigh(regression, model, candidate, allowed, most)
    if takes_over(model) and found.chi2 > _LEAVES * regression.n:
        taken = split_starts(regression, model, base)
        starts = [found.values, *taken] if found.possible else taken  # else it could win, and be refused
        other = weigh(regression, model, candidate, starts, most) if taken else found
        return min(found, other, key=lambda one: (not one.possible, one.chi2))
    return found


def weigh(
    regression: Regression, model: Model, candidate: Candidate, starts: Sequence[np.ndarray], most: int
) -> Confirmed:
    """Refit a model from the best of some starts, in at most so many steps, and weigh it against the regression's own.

    Of the last effect's amplitudes with one sign those that end on the wrong side are held at zero and the rest is
    refitted: a stop may stand on one side only. An effect of which nothing remains is impossible.
    """
    found = _weighed(regression, model, candidate, starts, most)
    if found.possible or not np.isfinite(found.chi2):
        return found
    one_sided = {f"{model.effects[-1].name}.{p.name}" for p in model.effects[-1].declared() if p.one_sided}
    wrong = [i for i, p in enumerate(model.parameters) if p.name in one_sided and found.values[i] < 0]
    if not 0 < len(wrong) < len(one_sided):
        return found
    bounded = replace(model, held=model.held | {model.parameters[i].name for i in wrong})
    values = found.values.copy()
    values[wrong] = 0.0
    return _weighed(regression, bounded, candidate, [values], most)


def _weighed(
    regression: Regression, model: Model, candidate: Candidate, starts: Sequence[np.ndarray], most: int
) -> Confirmed:
    found = refit(model, regression.fit.campaign, starts, most)
    readings = found.best.found.readings
    rows = [
        (record.response - readings[own])[None]
        for record, own in zip(regression.fit.campaign.fitted, found.data.tape.slices, strict=True)
    ]
    with np.errstate(over="ignore", invalid="ignore"):  # a motion without bound
        curves = found.best.found.residuals[found.data.tape.samples :]
        left = np.concatenate(
            [*(whiten(p, row)[0] for p, row in zip(regression.whitenings, rows, strict=True)), curves]
        )
        chi2 = float(left @ left)
    gain = 1.0 - (chi2 - regression.n) / regression.excess
    values = found.values
    possible = np.isfinite(chi2) and is_possible(model, values, model.effects[-1], regression.fit.scales)
    numbers = numbers_told(regression, model, found, left) + numbers_of_zeros(regression.fit.campaign.fitted)
    return Confirmed(candidate, model, values, chi2, gain, left, numbers, bool(possible), found.best.found.starts)


def accept(confirmed: Confirmed, before: Fit) -> Fit:
    """The confirmed model as a Fit with uncertainties.

    The refit saw excerpts of long records; a few steps then lead near the minimum of all samples. A search that crawls
    along a valley of a model in the making is left there too: the walk ends with a fit of its last one. Where what the
    excerpts say leaves more of all samples than there was without the effect, which is in the model, the steps begin
    without it.
    """
    model, campaign, values = confirmed.model, before.campaign, confirmed.values
    if not is_long(campaign):
        return fit(model, campaign, initial=values, begun=confirmed.begun, most=CRAWLS)
    found = near_its_minimum(model, campaign, values)
    if model.names[:-1] != before.model.names or found.fitted.chi2 <= before.fitted.chi2:
        return found
    faint = start_of(model, nearly_absent(confirmed.candidate, model), before.scales)
    known = before.solved.found.starts  # an effect's own memory has none yet
    begun = np.pad(known, [(0, 0), (0, found.solved.found.starts.shape[1] - known.shape[1])])
    other = near_its_minimum(model, campaign, np.concatenate([before.values, faint]), begun)
    return min(found, other, key=lambda one: one.fitted.chi2)


def near_its_minimum(model: Model, campaign: Campaign, values: np.ndarray, begun: np.ndarray | None = None) -> Fit:
    """A model on all samples of long records, a few steps from the values that excerpts of them tell; `begun`: the
    initial states there, if these are known."""
    there = minimise(model, campaign, How(most=_RACE), initial=values, begun=begun)
    return fit_at(model, campaign, there.values, begun=there.best.found.starts)
