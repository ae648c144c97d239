"""The loop by itself: fit, look where the error is, add the effect that explains it, until the noise floor.

Greedy addition with swaps. A term is added only if chance would not produce its gain; held-out records judge it once
the fitted ones have nothing more to say, because until then what is still missing spoils both. They also decide between
laws that the fitted ones do not tell apart: the error held out is then the best of a few, not of one. What stays of a
walk, and how sure it is, says `conclude`.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import NamedTuple

import numpy as np

from ...effects.registry import Registry
from ...fit import Fit
from ...fit.start_score import taken_by_starts
from ...pulse import Report
from ..evidence.coloured_noise import behind_in_colour
from ..evidence.criterion import VERY_STRONG, Left, behind, clearly_better, criteria
from ..evidence.enough import Role, adequate, laws_differ_by, not_worth_adding, role_of
from ..evidence.family import is_that_member
from ..evidence.held_out import foretold, hurts
from ..linearised.regression import Regression, prepare
from ..linearised.shorten import is_long, working
from ..linearised.trajectory import Diverged
from ..ranking.confirm import Confirmed, accept
from ..ranking.look import Look, best_drop, first_look
from ..ranking.score import kept_more_than_chance
from ..side_by_side import at_once
from .as_step import step_with
from .constant import with_its_constant
from .drive import edges_of, other_drive, smooth_instead
from .fewer_modes import without_a_mode, without_its_mode
from .further_mode import with_its_mode
from .once_more import another_minimum, begun_with, drive_beside, lower_start, with_other_starts
from .other_form import in_another_form, steps_in_another_form
from .own_zeros import with_own_zeros
from .rivals import beside_the_tried, rivals_of
from .steps import Ended, Step, Walked
from .together import both, hidden_by_each_other

Keep = Callable[[Walked], None]
"""Called with the walk so far after each of its steps, so that one that is stopped has left them."""

_MOST_TERMS = 6  # that a walk adds
_DRIVES = 3  # that a walk goes on to, one of them before any effect, after the one that the start model chose
_SHORTLIST = 3  # refits to excerpts, of which those on all samples decide


def walk_on(
    walked: Walked,
    library: Registry,
    report: Report = lambda _: None,
    keep: Keep = lambda _: None,
    look: Look | None = None,
) -> Ended:
    """The loop from a fit, or from where it was stopped; `look`: at the first fit, if somebody had one already.

    A drive that is held comes half a sample late. Where no jump of it, but only what was missing, has told that it is,
    a lag may stand in its place, or what was missing may have had one: the loop is gone with a smooth drive, too.
    """
    ended = _walk(walked, library, report, keep, look)
    smooth = smooth_instead(ended.walked.start.campaign)
    if smooth is None or ended.anew or not ended.walked.steps:
        return ended
    report("a drive that is smooth between its samples: once more, to compare")
    try:
        other = _walk(Walked(begun_with(ended.walked.start, smooth)), library, report, revised=0)
    except Diverged:  # with such a drive the motion has no bound
        return ended
    return other if clearly_better(_left(other), _left(ended)) else ended


def _left(ended: Ended) -> Left:
    """What a walk leaves, with all numbers that were fitted, the edges of the drive among them."""
    last = ended.look.regression
    return Left(last.residual, last.numbers + edges_of(ended.walked.start.campaign).numbers)


class _Again(NamedTuple):
    """The first model with which a walk begins again, and how often it may still do so with another drive."""

    start: Fit
    revised: int


def _walk(
    walked: Walked,
    library: Registry,
    report: Report,
    keep: Keep = lambda _: None,
    look: Look | None = None,
    revised: int = _DRIVES,
) -> Ended:
    """The loop, begun again as often as a better first model shows on the way; `revised`: how often this may be one
    with another drive between the samples."""
    gone = _gone(walked, look or first_look(walked.start, library, report), keep, revised)
    while isinstance(gone, _Again):
        gone = _gone(Walked(gone.start), first_look(gone.start, library, report), keep, gone.revised)
    return gone


def _gone(walked: Walked, look: Look, keep: Keep, revised: int) -> Ended | _Again:
    """The loop from a first model, at which the `look` is, to its end, or until a better first model shows."""
    start, report, at_best = walked.start, look.report, look.regression
    gains, ranking = dict(walked.gains), tuple(look.candidates) if look.worth_it else ()
    steps, look = _gone_before(walked, look)
    walked, questioned = Walked(start, tuple(steps), gains), None
    if revised and not steps and (other := _begun_otherwise(start, look)) is not None:
        return _Again(other, revised - 1)
    if (anew := with_own_zeros(walked.final, look)) is not None:
        return Ended(walked, look, at_best, ranking, anew)
    while _may_go_on(walked, look):
        found = _best_step(walked.final, look, {} if walked.steps else gains)
        refines = found is None or found[0][-1].role == "shape-refinement"
        if refines and (lower := _at_another_minimum(walked, report)) is not None:
            walked, look = lower, look.at(prepare(working(lower.final)))
            keep(walked)
            continue
        if found is None or _starts_say_more(walked.final, found[0], report):
            break
        (more, regression), is_first = found, not walked.steps
        walked, look = _with_added(walked, more, regression, look)
        if (again := _shown_by(more, walked, look, revised, is_first)) is not None:
            return again
        questioned = walked.final if is_first else questioned
        keep(walked)
        if (anew := with_own_zeros(walked.final, look)) is not None:
            return Ended(walked, look, at_best, ranking, anew)
    return _shown_at_the_end(walked, look, revised, questioned) or Ended(walked, look, at_best, ranking)


def _may_go_on(walked: Walked, look: Look) -> bool:
    """Whether a walk may add what its records seem to ask for."""
    wanted = look.worth_it and look.real and len(walked.steps) < _MOST_TERMS
    return bool(wanted) and not _nothing_is_worth_it(look)


def _with_added(walked: Walked, more: list[Step], regression: Regression, look: Look) -> tuple[Walked, Look]:
    """The walk with further steps, to the last of which the regression belongs, and the look there; `look`: before
    them."""
    for step in more:
        look.report(f"added {step.added}: error over noise {step.fit.fitted.error_over_noise:.3g}")
    steps, regression = _with_settled_linear_side([*walked.steps, *more], regression, walked.start, look)
    return walked._replace(steps=tuple(steps)), look.at(regression)


def _shown_by(more: list[Step], walked: Walked, look: Look, revised: int, is_first: bool) -> _Again | None:
    """A better first model that shows beside what was added: with another drive between the samples, or without a mode.

    What the first effect shows of the modes is asked before others are sought beside one that only mimics.
    """
    if revised and (other := drive_beside(more, walked.final, look)) is not None:
        return _Again(begun_with(walked.start, other), revised - 1)
    if is_first and (fewer := _of_fewer_modes(walked, look)) is not None:
        return _Again(fewer, revised)
    return None


def _shown_at_the_end(walked: Walked, look: Look, revised: int, questioned: Fit | None) -> _Again | None:
    """A better first model that shows at the end of a walk: at another minimum, or without a mode, unless its last fit
    was `questioned` so before."""
    if revised and walked.steps and (lower := lower_start(walked.start, walked.final, look.report)) is not None:
        return _Again(lower, revised - 1)
    asked = (walked.steps or not adequate(look.regression)) and walked.final is not questioned
    if asked and (fewer := _of_fewer_modes(walked, look)) is not None:
        return _Again(fewer, revised)
    return None


def _begun_otherwise(start: Fit, look: Look) -> Fit | None:
    """The first model with another drive between the samples, or one of its effects in another form, if the records ask
    for it before any effect is added."""
    if not (look.worth_it and look.real):
        return None
    other = other_drive(start, look.regression, look.report, look)
    if other is not None:
        return begun_with(start, other)
    form = in_another_form(start, look.regression, start, look.library, look.report)
    return None if form is None else form.fit


def _nothing_is_worth_it(look: Look) -> bool:
    """Whether neither one effect promises enough to be added, nor two that hide each other."""
    if not not_worth_adding(look.regression, look.promise, look.first):
        return False
    return not hidden_by_each_other(look.regression, look.candidates, None, look.first, look.library)


def _at_another_minimum(walked: Walked, report: Report) -> Walked | None:
    """A walk whose laws have come to another minimum after its last step, an effect, unless they had before; None if
    there is no better one."""
    last = walked.steps[-1] if walked.steps else None
    if last is None or last.role != "effect" or last.moved:
        return None
    lower = another_minimum(last.fit, walked.start, report)
    if lower is None:
        return None
    return walked._replace(steps=(*walked.steps[:-1], last._replace(fit=lower, moved=True)))


def _of_fewer_modes(walked: Walked, look: Look) -> Fit | None:
    """The first model of a walk without a mode that its last one does not need."""
    return without_a_mode(walked.start, walked.final, look.library, look.first, look.report)


def _with_settled_linear_side(
    steps: list[Step], regression: Regression, start: Fit, look: Look
) -> tuple[list[Step], Regression]:
    """The steps with what the linear side of the last fit needs by now, and the regression of that: a constant, a mode
    less or more, another form of a part; `look`: before the last of them."""
    library, report = look.library, look.report
    current, regression = with_its_constant(steps[-1].fit, regression, library, report)
    fewer = without_its_mode(current, start, [step.added for step in steps], look.first, report)
    current, regression = fewer or _with_its_mode(current, regression, look)
    steps = [*steps[:-1], steps[-1]._replace(fit=current)]
    return steps_in_another_form(steps, regression, start, library, report)


def _with_its_mode(current: Fit, regression: Regression, look: Look) -> tuple[Fit, Regression]:
    """With one mode more where the records ask for it, and no effect promises as much: a law's overtone is a line,
    too."""
    more, left = with_its_mode(current, regression, look.report)
    if more is current:
        return current, regression
    promise = look.at(regression).promise
    return (current, regression) if promise > regression.chi2 - left.chi2 else (more, left)


def _starts_say_more(before: Fit, more: list[Step], report: Report) -> bool:
    """Whether other starts than are claimed take more of what a model leaves than effects did: that is no physics.
    What is hinted at is tried, for a law that is missing moves the beginning of a record too."""
    after = more[-1].fit
    if not taken_by_starts(before) > before.fitted.chi2 - after.fitted.chi2:
        return False
    freed = with_other_starts(before)
    if freed is None or not freed.fitted.chi2 < after.fitted.chi2:
        return False
    names = " and ".join(step.added for step in more)
    report(f"another start says more than {names}: do the records begin as the campaign says?")
    return True


def _gone_before(walked: Walked, look: Look) -> tuple[list[Step], Look]:
    """The steps so far with the regressions that no file holds, and the look at the last of them."""
    steps = []
    for step in walked.steps:
        tied = tuple(c for c in look.real if c.name in step.tie_set)
        steps.append(step._replace(regression=look.regression, tied=tied))
        look = look.at(prepare(working(step.fit)))
    return steps, look


def _best_step(current: Fit, look: Look, gains: dict[str, float]) -> tuple[list[Step], Regression] | None:
    """Confirm the best candidates by refits and take the best one, or two that hide each other; the regression of the
    fit with them too."""
    regression, first, library, tried = look.regression, look.first, look.library, look.tried
    worth_it = not not_worth_adding(regression, best_drop(tried, regression), first)
    best = _best(tried, regression, current, first) if worth_it else None
    if best is not None and adequate(best.left) and not foretold(best.fit):
        more = beside_the_tried(best.confirmed.candidate.name, tried, look)
        other = _best(more, regression, current, first) if more else None
        tried = [*tried, *more]
        best = other if other and behind(other.confirmed, best.confirmed) < 0 else best
    kept = {found.candidate.name: found.gain for found in tried}
    gains.update(kept)
    single = best and (best.confirmed.candidate.name, best.left)
    if names := hidden_by_each_other(regression, look.candidates, single, first, library):
        look.report(f"trying {' and '.join(names)} together")
        if two := both(current, regression, names, library, best and best.left, first):
            (one, other), left = two
            return [one._replace(rivals=rivals_of(one.added, look.real, kept)), other], left
    if best is None:
        return None
    step = step_with(best.confirmed, regression, look.real, library, best.role, best.fit, tried=tried, gains=kept)
    return [step], best.left


class _Best(NamedTuple):
    """The effect to add: its refit, what it is, the fit on all records, and the regression of that."""

    confirmed: Confirmed
    role: Role
    fit: Fit
    left: Regression


def _best(tried: list[Confirmed], regression: Regression, current: Fit, first: Regression) -> _Best | None:
    """The refit that the criterion prefers, or of those between which it does not choose one that held-out data do not
    contradict."""
    first_choice: _Best | None = None
    for found, after in _accepted(tried, regression, current):
        if first_choice is not None and behind(found, first_choice.confirmed) > VERY_STRONG:
            break
        shown = working(after)
        if not np.isfinite(after.fitted.error_over_noise) or not np.isfinite(shown.fitted.error_over_noise):
            continue
        if after.fitted.error_over_noise > current.fitted.error_over_noise:
            continue  # the excerpts do not speak for the records
        try:
            role, left = role_of(found.model.effects[-1], regression, found.chi2, first), prepare(shown)
        except Diverged:
            continue
        if (role == "shape-refinement" or adequate(left)) and hurts(current, after):
            continue
        choice = _Best(found, role, after, left)
        if not hurts(current, after):
            return choice
        first_choice = first_choice or choice  # unless the held-out records choose a rival
    return first_choice


def _accepted(tried: list[Confirmed], regression: Regression, current: Fit) -> Iterator[tuple[Confirmed, Fit]]:
    """The refits that the criterion prefers to the model as it is, and whose gain chance would not produce either, with
    what they are on all samples, best first.

    Where the parameters bend far to mimic what is missing, excerpts do not tell how well a refit does on the rest.
    """
    better = [
        found
        for found in _in_order(tried, regression)
        if behind(found, regression) <= 0
        and kept_more_than_chance(found.candidate, found.chi2, regression)
        and behind_in_colour(found, regression) <= 0
    ]
    if regression.credible or not is_long(current.campaign):
        yield from ((found, accept(found, current)) for found in better)
    else:
        best = sorted(better, key=lambda found: found.chi2)[:_SHORTLIST]
        fits = at_once(lambda found: accept(found, current), best)
        yield from sorted(zip(best, fits, strict=True), key=lambda pair: pair[1].fitted.error_over_noise)


def _in_order(tried: list[Confirmed], regression: Regression) -> list[Confirmed]:
    """Those that can be, best first; of those that differ by no more than laws of one kind do the simplest first, and a
    member before its family."""
    tried = [found for found in tried if found.possible]
    weighed = dict(zip((found.candidate.name for found in tried), criteria(tried), strict=True))
    order = sorted(tried, key=lambda found: weighed[found.candidate.name])
    limit = order[0].chi2 + laws_differ_by(regression, order[0].chi2) if order else 0.0
    near = sorted((found for found in order if found.chi2 <= limit), key=lambda found: round(found.numbers))
    order = near + [found for found in order if found.chi2 > limit]
    if not order:
        return []
    first = type(order[0].model.effects[-1])
    member = lambda found: is_that_member(first, found.model.effects[-1], order[0].chi2, found.chi2, regression.excess)
    return sorted(order, key=lambda found: not member(found))
