"""Ranking by short refits: slower than the score statistics, and right where those cannot be believed."""

from __future__ import annotations

import itertools
from collections.abc import Sequence

import numpy as np

from ...effects.dependence import depends_on
from ...effects.effect import AbstractEffect
from ...effects.registry import Registry
from ...fit.curves import BENT
from ...pulse import Report
from ..evidence.enough import LITTLE
from ..linearised.regression import Regression
from ..side_by_side import at_once
from .confirm import weigh
from .score import best_first, refit_chance
from .starts import base_of, start_of, with_effect, without_unseen
from .weigh import Candidate

FEW = 15  # steps of least squares: enough to tell who gains much
_SMALL = 0.1  # of the size that the score predicts
_REFITTED = 12  # of the candidates, by their scores: others are asked if none of these nearly explains the misfit


def by_refits(
    regression: Regression, candidates: Sequence[Candidate], library: Registry, report: Report, answered: bool = False
) -> list[Candidate]:
    """The first candidates in the order of what a short refit of each gains, then the others as they were; all of them
    in that order where none of the first nearly explains the misfit, unless something else is known to: `answered`.

    A fit that lacks an effect bends its own parameters to mimic it. Where inertia hardly matters they bend far (a lag
    becomes a low quality factor), and what a candidate gains once they are free to bend back is not to be seen from
    the slope at the fit.
    """
    first, rest = candidates[:_REFITTED], candidates[_REFITTED:]
    report(f"scores cannot be believed here: refitting {len(first)} effects instead")
    glimpse = lambda one: _best_glimpse(regression, one, library[one.name])
    found = at_once(glimpse, first, report, "refits")
    if rest and not answered and not any(one.predicted_gain > 1.0 - LITTLE for one in found):
        # A friction that rules a slide had the last place by its score, and explained 88 %; another 93 %, where a brake
        # that fades had explained 87.
        report(f"none of them nearly explains it: refitting {len(rest)} more")
        found, rest = [*found, *at_once(glimpse, rest, report, "refits")], []
    return [*best_first(found, regression.n), *rest]


def bent_readings(regression: Regression, candidates: Sequence[Candidate], library: Registry) -> list[Candidate]:
    """The candidates, those that bend the reading of curves by what a short refit of them gains, in the order of gains.

    Scores take the motion from the reading. Where a sensor saturates that is not the motion, and what it hides beside
    the peaks the linear model has taken for damping; from a small bend of either sign a refit finds its way.
    """
    found = [_bent(regression, one, library[one.name]) if _bends(library[one.name]) else one for one in candidates]
    return best_first(found, regression.n)


def _bends(effect: type[AbstractEffect]) -> bool:
    return effect.overrides("sensor") and depends_on(effect()) == BENT


def _bent(regression: Regression, candidate: Candidate, effect: type[AbstractEffect]) -> Candidate:
    """A candidate with the size and the fall of χ² that a short refit reaches, if it is more than was promised."""
    before = regression.fit
    model = without_unseen(with_effect(before, effect, candidate.words), candidate)
    own = {p.name: p for p in model.effects[-1].declared()}
    shapes = [p.grid for p in own.values() if p.kind == "shape" and p.fitted]
    starts = []
    for sign, shape in itertools.product((_SMALL, -_SMALL), itertools.product(*shapes)):
        bent = iter(shape)
        values = {name: sign * abs(value) if own[name].kind == "amplitude" else next(bent)
                  for name, value in candidate.values.items()}  # fmt: skip
        start = start_of(model, candidate._replace(values=values), before.scales)
        starts.append(np.concatenate([base_of(regression), start]))
    found = weigh(regression, model, candidate, starts, FEW)
    drop = regression.best_chi2 - found.chi2
    if not (found.possible and drop > candidate.drop):
        return candidate
    size = dict(zip(own, found.values[len(before.values) :].tolist(), strict=True))
    p = refit_chance(candidate, found.chi2, regression)
    return candidate._replace(drop=drop, predicted_gain=float(np.clip(found.gain, 0, 1)), values=size,
                              beside=found.values[: len(before.values)], p_value=p)  # fmt: skip


def _best_glimpse(regression: Regression, candidate: Candidate, effect: type[AbstractEffect]) -> Candidate:
    """The candidate with the fall of χ² that a few steps of a fit reach, with those words of its choices that
    are the best by that: these have the name."""
    words = (candidate._replace(otherwise=()), *candidate.otherwise)
    seen = [_glimpsed(regression, one, effect) for one in words]
    best = max(seen, key=lambda c: c.schwarz(regression.n))
    return best._replace(otherwise=tuple(one for one in seen if one is not best))


def _glimpsed(regression: Regression, candidate: Candidate, effect: type[AbstractEffect]) -> Candidate:
    """The candidate with the fall of χ² that a few steps of a fit reach."""
    before = regression.fit
    model = with_effect(before, effect, candidate.words)
    bases = [base_of(regression), *(() if candidate.beside is None else (candidate.beside,))]
    starts = [np.concatenate([base, start_of(model, candidate, before.scales)]) for base in bases]
    found = weigh(regression, model, candidate, starts, FEW)
    if not np.isfinite(found.chi2):
        return candidate._replace(drop=0.0, predicted_gain=0.0, p_value=1.0)
    return candidate._replace(
        drop=max(regression.best_chi2 - found.chi2, 0.0),
        predicted_gain=float(np.clip(found.gain, 0, 1)),
        p_value=refit_chance(candidate, found.chi2, regression),
    )
