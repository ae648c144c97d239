"""Which effect is missing: score statistics of every candidate, from the one definition of each effect.

The residual of the fit is regressed on what each candidate would add to the readings, after everything that the model
can already absorb (its parameters, initial states, mains hum) is projected out. Shapes are tried on their grids. The
drop of χ² ranks the candidates; whether the best one is real is judged after whitening by the colour of what is left,
so that coloured noise raises no alarm.

Source: C. R. Rao, 1948, Proc. Camb. Phil. Soc. 44, 50; L. G. Godfrey, Misspecification Tests in Econometrics, 1988, §1.
"""

from __future__ import annotations

import itertools
from collections.abc import Mapping, Sequence

import numpy as np
from scipy.special import fdtrc

from ...campaign.campaign import Campaign
from ...campaign.device import Platform
from ...campaign.held_drive import jumps
from ...effects.dependence import needs_a_smooth_drive
from ...effects.effect import AbstractEffect
from ...effects.registry import Registry
from ...model import Model, make_effect, open_words
from ...pulse import Report
from ...response import Equation
from ..evidence.family import is_family_of
from ..linearised.curve_columns import curve_columns
from ..linearised.histories import begun_apart
from ..linearised.pass_columns import pass_columns
from ..linearised.regression import Regression, stack
from ..side_by_side import at_once
from .weigh import Asked, Candidate, weighed

NAMED_BY_CHANCE = 0.002  # probability with which noise alone would name an effect, all candidates together
_USUAL = 0.5  # of what other words promise: refits keep as little of a promise, or twice as much


def score(
    regression: Regression, library: Registry, report: Report = lambda _: None, forms: bool = False
) -> list[Candidate]:
    """Every candidate of the library that the model does not have, best first; each is scored once on a regression.

    A family of which the model has a member is none: that one with other numbers would stand in its place, not beside.
    Nor is another form of an effect, which would stand in the place of that, unless `forms` are asked for.
    """
    missing = _missing(regression, library, forms)
    new = [effect for effect in missing if effect not in regression.scored]
    regression.scored.update(
        zip(new, at_once(lambda effect: _score_one(regression, effect), new, report, "scores"), strict=True)
    )
    return best_first([c for effect in missing if (c := regression.scored[effect]) is not None], regression.n)


def _missing(regression: Regression, library: Registry, forms: bool = False) -> list[type[AbstractEffect]]:
    """The effects that `score` asks for."""
    model = regression.fit.model
    return [
        effect
        for effect in library.values()
        if effect.name not in model.names
        and not any(is_family_of(effect, one) for one in model.effects)
        and (forms or not effect.form_of)
    ]


def score_beside(regressions: Sequence[Regression], library: Registry) -> list[list[Candidate]]:
    """Every candidate on several regressions of one fit that differ in what they absorb: the columns are the same."""
    effects = _missing(regressions[0], library)

    def on_each(effect: type[AbstractEffect]) -> list[Candidate | None]:
        asked = _asked(regressions[0], effect)
        return [_best_weighed(one, asked) for one in regressions]

    by_effect = at_once(on_each, effects)
    found = [[c for c in of_one if c is not None] for of_one in zip(*by_effect, strict=True)]
    return [best_first(own, one.n) for own, one in zip(found, regressions, strict=True)]


def best_first(found: Sequence[Candidate], n: int) -> list[Candidate]:
    """Candidates in the order of Schwarz's criterion, of n samples."""
    return sorted(found, key=lambda c: -c.schwarz(n))


def _score_one(regression: Regression, effect: type[AbstractEffect]) -> Candidate | None:
    return _best_weighed(regression, _asked(regression, effect))


def _best_weighed(regression: Regression, asked: Sequence[Asked]) -> Candidate | None:
    """The candidate with its usual words, unless others promise what a refit with these can hardly keep; `otherwise`:
    with those that may explain as much."""
    found = [candidate for one in asked if (candidate := weighed(regression, one)) is not None]
    most = max((candidate.drop for candidate in found), default=0.0)
    first, *others = [candidate for candidate in found if candidate.drop >= _USUAL * most] or [None]
    return first and first._replace(otherwise=tuple(others))


def _asked(regression: Regression, effect: type[AbstractEffect]) -> list[Asked]:
    """What an effect would add with each of the words that its choices may have; nothing if it cannot act here."""
    fitted = regression.fit
    if effect.platform_only and not isinstance(fitted.model.device, Platform):
        return []
    if effect.needs and effect.needs not in fitted.model.names:
        return []
    if effect.settles_to_a_mean and fitted.campaign.shows_settled_motion_only:
        return []
    if lacks_a_smooth_drive(fitted.campaign, effect):
        return []
    return [_asked_with(regression, effect, words) for words in open_words(fitted.campaign, effect)]


def lacks_a_smooth_drive(campaign: Campaign, effect: type[AbstractEffect]) -> bool:
    """Whether a drive that is held jumps, and what an effect would do then is how steep somebody draws its edges."""
    return any(r.edge is not None and jumps(r.drive) for r in campaign.fitted) and needs_a_smooth_drive(effect)


def _asked_with(regression: Regression, effect: type[AbstractEffect], words: Mapping[str, str]) -> Asked:
    fitted = regression.fit
    # The candidate alone (with the effect it builds on) pushes: the same program then serves every model and campaign.
    # Its own push does not depend on the mass, which stays the nominal one.
    alone = make_effect(fitted.campaign, effect.name, {effect.name: effect}, words)
    own_effects = (*fitted.model.beneath(effect), alone)
    model = Model(fitted.model.device, own_effects, form=fitted.model.form)
    instance = model.effects[-1]
    own = [p.name for p in model.parameters[: len(model.parameters) - len(instance.parameters)]]
    known = np.array([fitted.value(name) for name in own])
    first = len(known)
    amplitudes = [i for i, p in enumerate(instance.declared()) if p.kind == "amplitude" and (p.fitted or p.default)]
    axes = _grid(instance, regression)
    points = [np.array(point) for point in itertools.product(*axes)]
    values = np.array([np.concatenate([known, point]) for point in points])
    directions = np.eye(values.shape[1])[[first + a for a in amplitudes]]
    moves = None
    if regression.plane is not None:
        moves = curve_columns(regression.plane, Equation(model), values, directions)
    passed = None
    if regression.passes is not None:
        there = np.array([np.concatenate([fitted.values, point]) for point in points])
        places = [len(fitted.values) + a for a in amplitudes]
        passed = pass_columns(regression, fitted.model + instance, there, places)
    raw = stack(regression, model, values, directions, moves=moves, passed=passed)
    apart, changed = begun_apart(regression, model, values), None
    if apart is not None:
        again, begun = np.tile(values, (len(apart), 1)), apart.reshape(-1, *apart.shape[2:])
        held = moves and moves.rows(np.tile(np.arange(len(raw)), len(apart)))
        still = None if passed is None else np.tile(passed, (len(apart), 1))
        changed = stack(regression, model, again, directions, begun=begun, moves=held, passed=still)
        changed = changed.reshape(len(apart), *raw.shape)
    return Asked(instance, words, points, [len(axis) for axis in axes], amplitudes, raw, changed, moves)


def _grid(effect: AbstractEffect, regression: Regression) -> list[Sequence[float]]:
    """The grids of the shapes, amplitudes at zero, SI; every combination is tried."""
    axes = []
    for p in effect.declared():
        if p.kind == "amplitude":
            axes.append([0.0])
        else:
            told = regression.fit.campaign.settings.get(effect.name, {}).get(p.name)
            grid = p.grid if p.fitted or len(p.grid) == 1 else (p.default,)
            axes.append(
                [float(told)]
                if isinstance(told, float)
                else [g * getattr(regression.fit.scales, p.scale) for g in grid]
            )
    return axes


def significant(candidates: Sequence[Candidate]) -> list[Candidate]:
    """Those that chance would hardly produce, however many were tried (Bonferroni)."""
    return [c for c in candidates if c.p_value * len(candidates) < NAMED_BY_CHANCE]


def kept_more_than_chance(candidate: Candidate, chi2: float, regression: Regression) -> bool:
    """Whether what a refit has kept of a candidate's promise, which leaves `chi2`, is significant too.

    A score is of first order, or of second in few of the terms: without phases one may promise what no refit can keep.
    """
    tried = len({effect.name for effect, scored in regression.scored.items() if scored is not None})
    return refit_chance(candidate, chi2, regression) * tried < NAMED_BY_CHANCE


def refit_chance(candidate: Candidate, chi2: float, regression: Regression) -> float:
    """The probability that noise alone lets a refit of a candidate fall to `chi2`."""
    freedom = max(regression.n - candidate.dof - regression.absorbed.shape[1], 1)
    fall = max(regression.best_chi2 - chi2, 0.0) / candidate.dof
    return float(fdtrc(candidate.dof, freedom, fall / max(chi2 / freedom, 1e-300)))
