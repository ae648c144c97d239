"""Adding two effects at once, where neither explains alone what both do together (see `pairs`)."""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache

import numpy as np

from ...effects.registry import Registry
from ...fit import Fit
from ..evidence.coloured_noise import behind_in_colour
from ..evidence.criterion import Left, clearly_better, criteria
from ..evidence.enough import adequate, not_worth_adding, worth_a_name
from ..evidence.held_out import hurts
from ..linearised.regression import Regression, prepare
from ..linearised.shorten import working
from ..linearised.trajectory import Diverged
from ..ranking.confirm import accept, confirm
from ..ranking.look import Look
from ..ranking.pairs import best_pair
from ..ranking.score import score
from ..ranking.weigh import Candidate
from .steps import Step


def hidden_by_each_other(
    regression: Regression,
    candidates: Sequence[Candidate],
    single: tuple[str, Regression] | None,
    first: Regression,
    library: Registry,
) -> tuple[str, str] | None:
    """Names of two effects that by their scores explain clearly more than the best single one, and than any two of
    which that is one: those the next step finds.

    `single`: its name and the regression with it, if there is one; `first`: the regression before any effect was added.

    Where the single effect contains one of the two it stands in that one's place: beside the other it does at least as
    well, but its score, at the shapes of a grid, may not say so.
    """
    pair = best_pair(regression, candidates) if regression.credible else None
    if pair is None:
        return None
    drop = (
        (regression.chi2 - float(pair.left @ pair.left))
        / max(regression.chi2 - regression.n, 1e-9)
        * regression.to_explain
    )
    if not_worth_adding(regression, drop, first) or not worth_a_name(drop, first):
        return None
    if single is not None:
        name, left = single
        with_it = best_pair(regression, candidates, name)
        if not worth_a_name(drop - (regression.best_chi2 - left.fit_chi2), first):
            return None  # the second would only refine the shape of the first
        if adequate(left) or with_it is None or not clearly_better(pair, with_it):
            return None
    if not clearly_better(pair, _instead(regression, single and single[1])):
        return None
    parts = () if single is None else library[single[0]].contains
    whole = [name for name in pair.names if name not in parts]
    return pair.names if single is None or len(whole) != 1 else (single[0], whole[0])


def both(
    current: Fit,
    regression: Regression,
    names: Sequence[str],
    library: Registry,
    single: Regression | None,
    first: Regression,
) -> tuple[list[Step], Regression] | None:
    """Steps that add the named effects whatever the first of them gains alone, and the regression after them; None if
    their refits keep less than is worth a name, are not clearly better than the `single` one, or than the model as it
    is, or worse than either on held-out records. In the place of the second may stand what builds on the first, which
    could not be asked before that was there. `first`: as of `hidden_by_each_other`."""
    needed = {effect.needs for effect in library.values()}
    begins, other = sorted(names, key=lambda name: name not in needed)
    steps, before, now = [], current, regression
    try:
        for name in (begins, other):
            builds = (effect.name for effect in library.values() if steps and effect.needs == begins)
            candidates = score(now, {one: library[one] for one in (name, *builds)})
            tried = [confirm(now, library[one.name], one) for one in candidates]
            tried = [one for one in tried if np.isfinite(one.chi2) and (one.possible or not steps)]
            if not tried:  # the first absorbs all that the second does
                return None
            found = tried[int(np.argmin(criteria(tried)))]
            before = accept(found, before)
            steps.append(
                Step(
                    added=found.candidate.name,
                    predicted_gain=found.candidate.predicted_gain,
                    confirmed_gain=found.gain,
                    tie_set=(),
                    role="effect",
                    fit=before,
                    regression=now,
                )
            )
            now = prepare(working(before))
    except Diverged:
        return None
    # What either is mistaken for shows only once both are in: the walk asks it at its end. What builds on another
    # cannot be without it, and came in the place of one that explained as much.
    one, two = (step.added for step in steps)
    alike = ((one,), (two, other)) if library[two].needs == one else ((one, two), (two, one))
    steps = [
        step._replace(tie_set=tuple(dict.fromkeys(names)), partner=partner)
        for step, names, partner in zip(steps, alike, (two, one), strict=True)
    ]
    if not_worth_adding(regression, regression.best_chi2 - now.fit_chi2, first):
        return None
    better = clearly_better(Left(now.residual, now.numbers), _instead(regression, single))
    better = better and behind_in_colour(now, regression) <= 0
    rivals = (current,) if single is None else (current, single.fit)
    return (steps, now) if better and not any(hurts(rival, before) for rival in rivals) else None


def two_names_do(look: Look, start: Regression, as_much: float = 0.0) -> bool:
    """Whether the two effects that promise most reach the noise once they are refitted, which they are if they promise
    to leave nothing that is worth a name, or no more χ² than `as_much`: a promise is of first order.

    `start`: of the `working` excerpt of the fit that is looked at.
    """
    pair = look.pair
    left = np.inf if pair is None else float(pair.left @ pair.left)
    if pair is None or (left > as_much and worth_a_name(left - look.regression.n, look.regression)):
        return False
    return _reach_the_noise(look, start, pair.names)


@lru_cache(maxsize=4)  # whoever has another answer asks
def _reach_the_noise(look: Look, start: Regression, names: tuple[str, str]) -> bool:
    look.report(f"trying {' and '.join(names)} together")
    found = both(start.fit, start, names, look.library, None, start)
    return found is not None and adequate(found[1])


def _instead(regression: Regression, single: Regression | None) -> Left:
    there = single or regression
    return Left(there.residual, there.numbers)
