"""An effect that contains simpler ones, or has numbers to spare, taken apart: are a few of these the whole truth?"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from ...effects.effect import AbstractEffect, Parameter
from ...effects.registry import Registry
from ...fit import Fit
from ...pulse import Report
from ..evidence.criterion import STRONG, behind
from ..evidence.enough import ANOTHER_LAW
from ..evidence.family import is_family_of, is_that_member
from ..evidence.held_out import hurts_more
from ..linearised.regression import Regression, prepare
from ..linearised.trajectory import Diverged
from ..ranking.confirm import Confirmed, accept, confirm
from ..ranking.score import score, significant
from ..ranking.weigh import Candidate
from .change import try_without

_TWO = 2  # numbers that two effects have at least


class Parts(NamedTuple):
    """`names`, the simpler effects that do as well as the one called `whole`, or `better`; the fit with them, and that
    with the whole; `near`, whether the whole leaves no more than laws of one kind differ by."""

    whole: str
    names: tuple[str, ...]
    fit: Fit
    better: bool
    undivided: Fit
    near: bool = True

    @property
    def words(self) -> str:
        """Both answers."""
        together = " and ".join(self.names) + (" together" if len(self.names) > 1 else "")
        return f"{together}, or {self.whole} alone" if self.better else f"{self.whole}, or {together}"


def take_apart(
    last: Fit,
    added: Sequence[str],
    library: Registry,
    start: Fit,
    report: Report,
) -> list[Parts]:
    """The added effects that simpler ones explain as well, up to the first that they explain better.

    A law with several parameters mimics any two of the simple ones that it implies, and a walk that adds one effect at
    a time meets it first. One with many bends to what any two do that it does not imply. But one name is a simpler
    answer than two: each further one costs 2 ln(size of the library). Beyond that the evidence must be strong for
    either answer, and held-out records must not contradict it; in between, both are given. On curves alone they are,
    too, where simpler ones with no more numbers leave no more than laws of one kind differ by: a law with more to bend
    may owe its lead to the shape of another.
    """
    alike: list[Parts] = []
    for name in added:
        mine = next(effect for effect in last.model.effects if effect.name == name)
        simple = _simpler(mine, last, library)
        if not simple or last.model.carries(name):
            continue
        report(f"is {name} the sum of simpler effects?")
        whole, current, names = prepare(last), try_without(last, name, start), []
        try:
            regression = without = prepare(current)
            while best := next(iter(significant(score(regression, simple))), None):
                trial = _or_its_member(regression, best, simple)
                if not (trial.possible and behind(trial, regression) < 0):
                    break
                more, part = accept(trial, current), trial.candidate.name
                left = prepare(more)
                # With more numbers than the whole has they are no simpler, however well they do.
                if part not in mine.contains and trial.numbers > whole.numbers:
                    fewer = without_one(more, names, start)
                    if fewer is None or not (fewer[1].numbers <= whole.numbers and behind(fewer[1], regression) < 0):
                        break
                    more, left, gone = fewer
                    names.remove(gone)
                current, regression, names = more, left, [*names, part]
            while fewer := without_one(current, names[:-1], start):  # taken up for want of those that came later
                if not behind(fewer[1], regression) < 0:
                    break
                current, regression, gone = fewer
                names.remove(gone)
            for part in tuple(names):
                wider = _of_its_family(part, current, regression, simple, start)
                if wider is not None and wider[1].numbers <= whole.numbers:
                    current, regression, names[names.index(part)] = wider
        except Diverged:  # a motion without bound explains nothing
            continue
        worse = behind(regression, whole) + 2 * np.log(len(library)) * (len(names) - 1)
        if names and worse < -STRONG and not hurts_more(last, current):
            near = whole.fit_chi2 - regression.fit_chi2 < ANOTHER_LAW * without.excess
            return [*alike, Parts(name, tuple(names), current, True, last, near)]
        shape = regression.fit_chi2 - whole.fit_chi2 < ANOTHER_LAW * without.excess
        # Traces would show by a mean and overtones which it is, and harmonics of sweeps do.
        shape = shape and regression.numbers <= whole.numbers and not last.campaign.shows_shape
        if names and (worse < STRONG or shape):
            alike.append(Parts(name, tuple(names), current, False, last))
    return alike


def without_one(full: Fit, names: Sequence[str], start: Fit) -> tuple[Fit, Regression, str] | None:
    """The fit without that one of some effects of which it leaves least, its regression, and which that is."""
    tried = []
    for name in names:
        if full.model.carries(name):
            continue
        less = try_without(full, name, start)
        try:
            tried.append((less, prepare(less), name))
        except Diverged:  # without it the motion has no bound
            continue
    return min(tried, key=lambda one: one[1].fit_chi2, default=None)


def _of_its_family(
    part: str, full: Fit, regression: Regression, simple: Registry, start: Fit
) -> tuple[Fit, Regression, str] | None:
    """The fit with a family in the place of its member, its regression and its name, if that is better."""
    mine = next(effect for effect in full.model.effects if effect.name == part)
    families = {n: e for n, e in simple.items() if n not in full.model.names and is_family_of(e, mine)}
    if not families or full.model.carries(part) or regression.fit_chi2 <= regression.n:  # it leaves noise alone
        return None
    try:
        without = prepare(try_without(full, part, start))
        for wider in score(without, families):
            trial = confirm(without, families[wider.name], wider)
            if trial.possible and behind(trial, regression) < 0:
                found = accept(trial, without.fit)
                return found, prepare(found), wider.name
    except Diverged:  # without it, or with the family, the motion has no bound
        return None
    return None


def _or_its_member(regression: Regression, best: Candidate, simple: Registry) -> Confirmed:
    """The refit of the best candidate, or of a member of its family that does as well, or leaves noise alone."""
    plain = lambda one: confirm(regression, simple[one.name], one, refining=False)  # else it were no simpler
    found = plain(best)
    for member in score(regression, {n: e for n, e in simple.items() if is_family_of(simple[best.name], e())}):
        other = plain(member)
        law = other.model.effects[-1]
        as_well = is_that_member(simple[best.name], law, found.chi2, other.chi2, regression.excess)
        if other.possible and (as_well or other.chi2 <= regression.n):
            return other
    return found


def _simpler(mine: AbstractEffect, last: Fit, library: Registry) -> dict[str, type[AbstractEffect]]:
    """What may stand in an effect's place with others: what it contains, and, if it has more numbers than two effects
    need, any of which it has room for two."""
    room = _numbers(mine.declared()) // 2 if _numbers(mine.declared()) > _TWO else 0
    fits = lambda effect: effect.name in mine.contains or _numbers(effect.parameters) <= room
    there = [effect for effect in last.model.effects if effect is not mine]
    return {
        name: effect
        for name, effect in library.items()
        if fits(effect)
        and name not in last.model.names
        and not any(is_family_of(type(one), effect()) or is_family_of(effect, one) for one in there)
    }


def _numbers(parameters: Sequence[Parameter]) -> int:
    return sum(p.fitted for p in parameters)
