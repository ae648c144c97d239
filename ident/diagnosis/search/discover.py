"""The loop by itself: fit, look where the error is, add the effect that explains it, until the noise floor.

Greedy addition with swaps. A term is added only if chance would not produce its gain; held-out records judge it once
the fitted ones have nothing more to say, because until then what is still missing spoils both. They also decide between
laws that the fitted ones do not tell apart: the error held out is then the best of a few, not of one. The model is
adequate when the error stands at the noise floor. Not the falling error but what is left decides whether a name is
sure: with the true effect absent from the library an impostor still lowers the error.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Literal, NamedTuple

import numpy as np

from ...campaign.campaign import Campaign
from ...effects.registry import Registry
from ...fit import Fit, fit
from ...fit.start_score import taken_by_starts
from ...model import Model
from ...pulse import Report
from ..evidence.coloured_noise import behind_in_colour
from ..evidence.criterion import VERY_STRONG, behind, criteria
from ..evidence.enough import (
    ANOTHER_LAW,
    adequate,
    laws_differ_by,
    not_worth_adding,
    worth_a_name,
)
from ..evidence.family import is_that_member
from ..evidence.held_out import contradicted, foretold, hurts, predicts_better
from ..linearised.regression import Regression, prepare
from ..linearised.shorten import is_long, working
from ..linearised.trajectory import Diverged
from ..ranking.confirm import Confirmed, accept, confirm
from ..ranking.look import Look, best_drop, first_look, possible
from ..ranking.score import Candidate, kept_more_than_chance, score, significant
from ..side_by_side import at_once
from .change import to_its_end, try_without
from .constant import with_its_constant
from .drive import other_drive
from .fewer_modes import without_a_mode
from .further_mode import with_its_mode
from .lacking import lacking
from .once_more import begun_with, drive_beside, lower_start, with_other_starts
from .parts import Parts
from .prune import Pruned, prune
from .steps import Discovery, Step, Verdict, Walked
from .ties import TieSet, tie_set
from .together import both, hidden_by_each_other

Keep = Callable[[Walked], None]
"""Called with the walk so far after each of its steps, so that one that is stopped has left them."""

MOST_TERMS = 6  # that a walk adds
_DRIVES = 3  # that a walk goes on to, one of them before any effect, after the one that the start model chose
_SHORTLIST = 3  # refits to excerpts, of which those on all samples decide
_REFITTED_TIES = 12  # of the names that tie by their scores; a record that says little leaves more than that


def discover(
    model: Model, campaign: Campaign, library: Registry, report: Report = lambda _: None, most: int = MOST_TERMS
) -> Discovery:
    """Walk from a model to one that the records do not contradict, as far as the library reaches."""
    report(f"fitting {', '.join(model.names) or 'the linear model'}")
    start = fit(model, campaign)
    return concluded(walk_on(Walked(start), library, report, most))


class Ended(NamedTuple):
    """A walk that adds nothing more, unquestioned.

    **Arguments:** `look`: at its last fit; `at_best`: where it began, with the `ranking` there.
    """

    walked: Walked
    look: Look
    at_best: Regression
    ranking: tuple[Candidate, ...]


def walk_on(
    walked: Walked,
    library: Registry,
    report: Report = lambda _: None,
    most: int = MOST_TERMS,
    keep: Keep = lambda _: None,
    look: Look | None = None,
    revised: int = _DRIVES,
) -> Ended:
    """The loop from a fit, or from where it was stopped; `look`: at the first fit, if somebody had one already;
    `revised`: how often it may still begin again with another drive between the samples."""
    start = walked.start
    look = look or first_look(start, library, report)
    first, at_best, gains = look.first, look.regression, dict(walked.gains)
    ranking = tuple(look.candidates) if look.worth_it else ()
    steps, look = _gone_before(walked, look)

    def once_more(start: Fit) -> Ended:
        return walk_on(Walked(start), library, report, most, keep, revised=revised - 1)

    asked = revised and not steps and look.worth_it and look.real
    if asked and (other := other_drive(start, look.regression, report, look.promise)) is not None:
        return once_more(begun_with(start, other))
    current = walked.final
    while look.worth_it and look.real and len(steps) < most:
        alone = not_worth_adding(look.regression, look.promise, first)
        if alone and not hidden_by_each_other(look.regression, look.candidates, None, first, library):
            break
        found = _best_step(current, look, gains if not steps else {})
        if found is None:
            break
        more, regression = found
        if _starts_say_more(current, more[-1].fit):
            names = " and ".join(step.added for step in more)
            report(f"another start says more than {names}: do the records begin as the campaign says?")
            break
        for step in more:
            steps.append(step)
            report(f"added {step.added}: error over noise {step.fit.fitted.error_over_noise:.3g}")
        current, regression = with_its_constant(steps[-1].fit, regression, library, report)
        current, regression = with_its_mode(current, regression, report)
        steps[-1] = steps[-1]._replace(fit=current)
        if revised and (other := drive_beside(more, current, regression, report)) is not None:
            return once_more(begun_with(start, other))
        look = Look(regression, first, library, report)
        keep(Walked(start, tuple(steps), gains))
    if revised and steps and (lower := lower_start(start, current, report)) is not None:
        return once_more(lower)
    asked = steps or not adequate(look.regression)
    if asked and (fewer := without_a_mode(start, current, library, first, report)) is not None:
        return walk_on(Walked(fewer), library, report, most, keep, revised=revised)
    return Ended(Walked(start, tuple(steps), gains), look, at_best, ranking)


def concluded(ended: Ended) -> Discovery:
    """What stays of a walk: steps that held-out records refute or later ones make superfluous are taken back, and each
    is asked anew what it could be mistaken for."""
    walked, look, at_best, ranking = ended
    start, first, library, report = walked.start, look.first, look.library, look.report
    regression, candidates = look.regression, look.candidates
    steps = _without_refuted(start, list(walked.steps), regression)
    alike: tuple[Parts, ...] = ()
    if steps:
        needed = prune(steps[-1].fit, [s.added for s in steps], library, first, report)
        alike = needed.alike
        if needed.names != tuple(s.added for s in steps):
            steps = _replayed(start, needed, library, at_best)
            steps = _without_refuted(start, steps, prepare(working(steps[-1].fit)))  # the laws before it have changed
    steps = _on_all_samples(start, steps, report)
    final = steps[-1].fit if steps else start
    if final is not walked.final:
        regression = prepare(working(final))
        candidates = score(regression, library)
    blurred = [step for step in steps if step is not steps[-1] or step.partner]
    steps = [_tied_at_the_end(s, final, start, library, report) if s in blurred else s for s in steps]
    steps = [_beside_parts(step, alike) for step in steps]
    remaining = tuple(significant(candidates))
    lacks = lacking(_after_effects(steps, regression), first, report) if steps else 0.0
    verdict = _verdict(steps, regression, first, lacks, contradicted(final))
    return Discovery(verdict, start, tuple(steps), ranking, walked.gains, remaining, regression, lacks)


def _starts_say_more(before: Fit, after: Fit) -> bool:
    """Whether other starts than are claimed take more of what a model leaves than effects did: that is no physics.
    What is hinted at is tried, for a law that is missing moves the beginning of a record too."""
    if not taken_by_starts(before) > before.fitted.chi2 - after.fitted.chi2:
        return False
    freed = with_other_starts(before)
    return freed is not None and freed.fitted.chi2 < after.fitted.chi2


def _gone_before(walked: Walked, look: Look) -> tuple[list[Step], Look]:
    """The steps so far with the regressions that no file holds, and the look at the last of them."""
    steps = []
    for step in walked.steps:
        tied = tuple(c for c in look.real if c.name in step.tie_set)
        steps.append(step._replace(regression=look.regression, tied=tied))
        look = Look(prepare(working(step.fit)), look.first, look.library, look.report)
    return steps, look


def _without_refuted(start: Fit, steps: list[Step], regression: Regression) -> list[Step]:
    """The steps without those at the end that held-out records refute; `regression`: after the last.

    Where the noise floor is not reached, or on the fitted records alone, the model still lacks something, and one more
    law may bend to mimic a part of that: after the first, a name then counts if it predicts other records better than
    every model before it, that without effects included.
    """
    kept, left = list(steps), regression
    while kept:
        before, after = kept[-2].fit if len(kept) > 1 else start, kept[-1].fit
        unsure = not (adequate(left) and foretold(after))
        earlier = [start, *(step.fit for step in kept[:-1])] if len(kept) > 1 else []
        mimics = unsure and not all(predicts_better(fit, after) for fit in earlier)
        if not (mimics or hurts(before, after)):
            break
        left = kept.pop().regression or left
    return kept


def _on_all_samples(start: Fit, steps: list[Step], report: Report) -> list[Step]:
    """The steps with the last fit taken to its end on all samples, and without those that held-out records refute only
    there: a search that crawls has not yet bent as far as its model can."""
    kept = list(steps)
    while kept and (is_long(start.campaign) or not kept[-1].fit.converged):
        report("fitting all samples")
        kept[-1] = kept[-1]._replace(fit=to_its_end(kept[-1].fit, report))
        left = _without_refuted(start, kept, prepare(working(kept[-1].fit)))
        if len(left) == len(kept):
            break
        kept = left
    return kept


def _after_effects(steps: list[Step], regression: Regression) -> Regression:
    """The regression of the last effect, without the terms that only refine shapes: they would hide that a law
    differs."""
    last = max(i for i, step in enumerate(steps) if step.role == "effect")
    return regression if last == len(steps) - 1 else prepare(working(steps[last].fit))


def _replayed(start: Fit, needed: Pruned, library: Registry, at_best: Regression) -> list[Step]:
    """The steps as they would have been without the terms that proved superfluous; `at_best`: where the walk began."""
    steps: list[Step] = []
    current = start
    for name in needed.names:
        regression = prepare(working(current)) if steps else at_best
        candidates = score(regression, library)
        chosen = next(c for c in candidates if c.name == name)
        found = confirm(regression, library[name], chosen)
        current = needed.fit if name == needed.names[-1] else accept(found, current)
        ties, tied = _weighed_ties(regression, found, significant(candidates), library, [found])
        role = _role(regression, found, at_best)
        steps.append(
            Step(name, chosen.predicted_gain, found.gain, ties.names, role, current, ties.reasons, tied, regression)
        )
    return steps


def _tied_at_the_end(step: Step, last: Fit, start: Fit, library: Registry, report: Report) -> Step:
    """A step with the ties that are left once the later terms are in: what they explain had blurred the comparison."""
    if len(step.tie_set) < 2 or step.role != "effect" or last.model.carries(step.added):
        return step
    report(f"what {step.added} could be mistaken for")
    try:
        regression = prepare(try_without(working(last), step.added, start))
    except Diverged:  # without it the motion has no bound
        return step
    candidates = significant(score(regression, library))
    chosen = next((c for c in candidates if c.name == step.added), None)
    if chosen is None:
        return step
    found = confirm(regression, library[step.added], chosen)
    ties, tied = _weighed_ties(regression, found, candidates, library, [found])
    return step._replace(tie_set=ties.names, reasons=ties.reasons, tied=tied, regression=regression)


def _beside_parts(step: Step, alike: tuple[Parts, ...]) -> Step:
    """A step with the other answer, where an effect and a few simpler ones together do as well."""
    for parts in alike:
        if step.added == (parts.names[0] if parts.better else parts.whole):
            reason = f"{parts.words}: they explain the misfit as well"
            names = tuple(dict.fromkeys([*step.tie_set, *((parts.whole,) if parts.better else parts.names)]))
            return step._replace(tie_set=names, reasons=tuple(dict.fromkeys((*step.reasons, reason))), instead=parts)
    return step


def _role(regression: Regression, found: Confirmed, first: Regression) -> Literal["effect", "shape-refinement"]:
    """An effect removes a share of the first excess that is worth a name; the first one always is."""
    return (
        "effect"
        if regression is first or worth_a_name(regression.best_chi2 - found.chi2, first)
        else "shape-refinement"
    )


def _best_step(current: Fit, look: Look, gains: dict[str, float]) -> tuple[list[Step], Regression] | None:
    """Confirm the best candidates by refits and take the best one, or two that hide each other; the regression of the
    fit with them too."""
    regression, first, library, tried = look.regression, look.first, look.library, look.tried
    gains.update({found.candidate.name: found.gain for found in tried})
    best = (
        None
        if not_worth_adding(regression, best_drop(tried, regression), first)
        else _best(tried, regression, current, first)
    )
    single = best and (best.confirmed.candidate.name, best.left)
    if names := hidden_by_each_other(regression, look.candidates, single, first, library):
        look.report(f"trying {' and '.join(names)} together")
        if two := both(current, regression, names, library, best and best.left, first):
            return two
    if best is None:
        return None
    found = best.confirmed
    name, predicted = found.candidate.name, found.candidate.predicted_gain
    ties, tied = _weighed_ties(regression, found, look.real, library, tried)
    return [
        Step(name, predicted, found.gain, ties.names, best.role, best.fit, ties.reasons, tied, regression)
    ], best.left


class _Best(NamedTuple):
    """The effect to add: its refit, what it is, the fit on all records, and the regression of that."""

    confirmed: Confirmed
    role: Literal["effect", "shape-refinement"]
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
            role, left = _role(regression, found, first), prepare(shown)
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


def _weighed_ties(
    regression: Regression, found: Confirmed, real: list[Candidate], library: Registry, tried: list[Confirmed]
) -> tuple[TieSet, tuple[Candidate, ...]]:
    """What an effect ties with, the nearest of those that had only been scored refitted; and the candidates that do."""
    rivals = possible(real, tried)
    ties = tie_set(regression, found.candidate, rivals, library, tried)
    known = {one.candidate.name for one in tried}
    scored = [tie.name for tie in ties.ties if tie.name not in known][:_REFITTED_TIES]
    if scored:
        more = at_once(lambda c: confirm(regression, library[c.name], c), [c for c in rivals if c.name in scored])
        tried = [*tried, *more]
        rivals = possible(real, tried)
        ties = tie_set(regression, found.candidate, rivals, library, tried)
    return ties, tuple(c for c in real if c.name in ties.names)


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


def _verdict(steps: list[Step], regression: Regression, first: Regression, lacks: float, contradicted: bool) -> Verdict:
    """A name is given as sure only if what it leaves is noise, or as little as laws of one kind differ by, and nothing
    is where held-out records say otherwise."""
    fine = adequate(regression)
    if not steps:
        return "adequate" if fine and not contradicted else "not-in-library"
    if not fine and max(lacks, (regression.chi2 - regression.n) / (first.chi2 - first.n)) > ANOTHER_LAW:
        return "not-in-library"
    tied = any(len(s.tie_set) > 1 for s in steps if s.role == "effect")
    return "ambiguous" if lacks or tied or contradicted else "identified"
