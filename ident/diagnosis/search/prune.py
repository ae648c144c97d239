"""Terms that a greedy walk picked up too early: taken out when later ones make them superfluous, or swapped."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType
from typing import NamedTuple

import numpy as np

from ...effects.registry import Registry
from ...fit import Fit
from ...fit.rebuild import values_without
from ...pulse import Report
from ..evidence.criterion import VERY_STRONG, behind, criteria
from ..evidence.enough import ANOTHER_LAW, SAME_SHAPE, laws_differ_by, superfluous, worth_a_name
from ..evidence.equivalences import mistaken
from ..evidence.family import is_that_member
from ..evidence.held_out import hurts, hurts_more
from ..linearised.regression import Regression, prepare
from ..linearised.shorten import is_long, working
from ..linearised.trajectory import Diverged
from ..ranking.confirm import accept, confirm, near_its_minimum
from ..ranking.score import score, significant
from ..ranking.weigh import Candidate
from ..side_by_side import at_once
from .change import ENOUGH, still_possible, try_without
from .parts import Parts, take_apart

_MOST_CHANGES = 10  # each has to be for the better, but by two measures: criterion and held-out error
_NEARLY, _TRIED = 0.98, 3  # of what the best score promises, and how many of those are refitted
_PROMISING = 0.5  # of what the score of the one in place promises: a rival that promises less is not tried


class Pruned(NamedTuple):
    """The effects that are needed, in order, and the fit with them; `alike`: where one and a few simpler ones do as
    well; `even`: by name, the rival in its place beside all the others between which the records do not choose."""

    names: tuple[str, ...]
    fit: Fit
    alike: tuple[Parts, ...]
    even: Mapping[str, str] = MappingProxyType({})


def rivals(name: str, regression: Regression, library: Registry) -> list[Candidate]:
    """Who may stand in an effect's place: those that score best and nearly so, and the best of those that it is
    mistaken for."""
    scored = significant(score(regression, library))
    enough = _PROMISING * next((c.drop for c in scored if c.name == name), 0.0)
    candidates = [c for c in scored if c.drop > enough]
    near = [c for c in candidates if c.drop > _NEARLY * candidates[0].drop][:_TRIED]
    better = [c for c in near if c.name != name]
    others = mistaken(library[name], library) if name in library else ()
    alike = [c for c in candidates if c.name in others and c.name not in {b.name for b in better}]
    return [*better, *alike[:1]]


def _replaced(
    name: str,
    last: Fit,
    full: Regression,
    regression: Regression,
    library: Registry,
    first: Regression,
    report: Report,
    even: dict[str, str],
) -> tuple[str, Fit] | None:
    """A rival in an effect's place, with the fit, if the criterion clearly prefers it, or prefers one with fewer
    numbers; between laws that the fitted records do not tell apart, or by no more than a simpler one may lack in shape,
    the held-out ones decide. One between which and the effect nothing decides is told in `even`.

    `regression`: without the effect. Refits start from what its presence has made of the other parameters. What stands
    by a term that only refines shapes is no rival: such a term bends to what the rival does not say.
    """
    likely, rest = rivals(name, regression, library), values_without(last, name)
    refit = lambda rival: confirm(regression, library[rival.name], rival, ENOUGH, rest)
    tried = [found for found in at_once(refit, likely, report, "rivals") if found.possible]
    if not tried:
        return None
    best = tried[int(np.argmin(criteria(tried)))]
    mine = next(effect for effect in last.model.effects if effect.name == name)
    if is_that_member(type(best.model.effects[-1]), mine, best.chi2, full.fit_chi2, regression.excess):
        return None
    # A refit counts all of its parameters: with only those that it needs it may yet be better.
    perhaps = behind(best, full) < len(library[best.candidate.name].parameters) * np.log(full.n)
    simpler = best.model.numbers < last.model.numbers
    alike = best.chi2 - full.fit_chi2 < (SAME_SHAPE if simpler else ANOTHER_LAW) * regression.excess
    if not (perhaps or (alike and last.holdout is not None)):
        return None
    after = accept(best, regression.fit)
    # A part of it, or one with fewer numbers, is the simpler answer; a law with more may owe its lead to them.
    margin = 0.0 if simpler or best.candidate.name in library[name].contains else VERY_STRONG
    wider = best.model.numbers > last.model.numbers
    there = prepare(after)
    lead = full.fit_chi2 - there.fit_chi2
    clearly = perhaps and behind(full, there) > margin and not (wider and lead < laws_differ_by(regression, best.chi2))
    wins = (not hurts_more(last, after) if clearly else alike and hurts(after, last)) and still_possible(after, last)
    if wins and _unrefined(name, last, best.candidate.name, after, first):
        return best.candidate.name, after
    near = wins or abs(behind(full, there)) < VERY_STRONG
    if near and still_possible(after, last) and not hurts(last, after):
        even[name] = best.candidate.name
    return None


def _unrefined(name: str, last: Fit, rival: str, after: Fit, first: Regression) -> bool:
    """Whether a rival, in the fit `after`, says as much as the effect in whose place it is, but for a shape, where
    every other term that is not worth a name beside the effect is left out of both."""
    most = SAME_SHAPE * first.above_noise
    for other in last.model.names:
        if other in (name, rival) or last.model.carries(other) or after.model.carries(other):
            continue
        without = try_without(last, other, first.fit)
        if not worth_a_name(without.fitted.chi2 - last.fitted.chi2, first):
            last, after = without, try_without(after, other, first.fit)
            if after.fitted.chi2 - last.fitted.chi2 > most:
                return False
    return True


def prune(
    last: Fit, added: list[str], library: Registry, first: Regression, report: Report, weighed: bool = False
) -> Pruned:
    """What is left of the added effects once each has been questioned.

    `first`: the regression before any was added; `weighed`: whether the last effect has been, beside all the others,
    when it was added.
    """
    names, given, last = list(added), last, working(last)
    as_given, begun, even = Pruned(tuple(added), given, ()), last, dict[str, str]()
    names, last = _questioned(names, last, library, first, report, even, int(weighed))
    compared = take_apart(last, names, library, first.fit, report)
    alike = tuple(parts for parts in compared if parts.near)
    for parts in compared:
        if parts.better:
            at = names.index(parts.whole)
            names, last = [*names[:at], *parts.names, *names[at + 1 :]], parts.fit
            report(f"now {', '.join(names)}: error over noise {last.fitted.error_over_noise:.3g}{_held_out(last)}")
            # What the whole could not say beside the others, its parts may say without them.
            names, last = _questioned(names, last, library, first, report, even)
    if names == added and last is begun:
        return as_given._replace(alike=alike, even=even)
    if not is_long(given.campaign):
        return Pruned(tuple(names), last, alike, even)
    # Swaps were judged on excerpts, which hold nothing out, and whose values are not yet those of all samples.
    on_all = near_its_minimum(last.model, given.campaign, last.values)
    return as_given if hurts(given, on_all) else Pruned(tuple(names), on_all, alike, even)


def _questioned(
    names: list[str], last: Fit, library: Registry, first: Regression, report: Report, even: dict[str, str],
    asked: int = 0,
) -> tuple[list[str], Fit]:  # fmt: skip
    """The effects and the fit after every change that is for the better: each effect is asked in turn, until all that
    are left have been asked since the last change; `asked`: how many, the last ones, have been before any; `even` is
    told the rivals that are left."""
    at = changes = 0
    # The rivals of a single effect were weighed when it was added.
    while asked < len(names) > 1 and changes < _MOST_CHANGES:
        at %= len(names)
        change = _changed(at, names, last, library, first, report, even)
        at, asked = at + 1, asked + 1
        if change is not None:
            at -= len(names) - len(change[0])
            names, last = change
            even.clear()  # said beside what is there no more
            asked, changes = 0, changes + 1
            report(f"now {', '.join(names)}: error over noise {last.fitted.error_over_noise:.3g}{_held_out(last)}")
    return names, last


def _held_out(fit: Fit) -> str:
    return "" if fit.holdout is None else f", held out {fit.holdout.error_over_noise:.3g}"


def _changed(
    i: int, names: list[str], last: Fit, library: Registry, first: Regression, report: Report, even: dict[str, str]
) -> tuple[list[str], Fit] | None:
    """The effects and the fit without the i-th, or with another in its place, if that is for the better."""
    full, name = prepare(last), names[i]
    if last.model.carries(name):
        return None
    report(f"does the model still need {name}?")
    without = try_without(last, name, first.fit)
    try:
        regression = prepare(without)
        if superfluous(regression, full, first) and still_possible(without, last) and not hurts(last, without):
            return [*names[:i], *names[i + 1 :]], without
        # Where scores cannot be believed, every effect has been refitted already.
        found = _replaced(name, last, full, regression, library, first, report, even) if full.credible else None
    except Diverged:  # without it, or with another in its place, the motion has no bound
        return None
    return None if found is None else ([*names[:i], found[0], *names[i + 1 :]], found[1])
