"""What stays of a walk once its steps are questioned, and how sure the names are.

Steps that held-out records refute, or later ones make superfluous, are taken back; each that stays is asked anew what
it could be mistaken for. Not the falling error but what is left decides whether a name is sure: with the true effect
absent from the library an impostor still lowers the error.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from ...campaign.campaign import Campaign
from ...effects.registry import Registry
from ...fit import Fit
from ...fit.floors import sharpened
from ...pulse import Report
from ..evidence.enough import ANOTHER_LAW, MOST_OF_IT, adequate, role_of, speaks_for
from ..evidence.equivalences import what_separates
from ..evidence.held_out import contradicted, foretold, hurts, predicts_better
from ..linearised.regression import Regression, prepare
from ..linearised.shorten import is_long, working
from ..linearised.trajectory import Diverged
from ..ranking.confirm import accept, confirm
from ..ranking.look import Look
from ..ranking.refits import by_refits
from ..ranking.score import score, significant
from .as_step import step_with
from .change import to_its_end, try_without
from .constant import without_idle_constant
from .finer import with_finer_laws
from .lacking import lacking, leaves_no_structure, says_more_than_shapes
from .last_zeros import with_last_zeros
from .parts import Parts
from .prune import Pruned, prune
from .steps import Discovery, Ended, Step, Verdict
from .ties import weighed_ties


def concluded_or_sharper(ended: Ended) -> Discovery | Campaign:
    """What stays of a walk; or the campaign with its records read otherwise, or with the noise floors that its last
    fit, or the one that stays, tells better: a walk to be gone again need not be questioned first."""
    sharper = ended.anew or _sharper(ended.walked.final, ended.look.regression)
    if sharper is not None:
        return sharper
    found = concluded(ended)
    sharper = None if found.final is ended.walked.final else _sharper(found.final, found.regression)
    return found if sharper is None else sharper


def _sharper(final: Fit, regression: Regression) -> Campaign | None:
    """The campaign with the noise floors that a fit tells better, where they may change an answer: to a model that
    does not stand at the floors it had, they say something new if they make up most of what it leaves of a record."""
    campaign = sharpened(final)
    if campaign is None or adequate(regression):
        return campaign
    for own, old, new in zip(final.trace_scores, final.campaign.traces, campaign.traces, strict=True):
        left, raised = own.error_over_noise**2, (new.noise.sigma / old.noise.sigma) ** 2
        if raised > 1 and left / raised - 1 < MOST_OF_IT * (left - 1):
            return campaign
    return None


def concluded(ended: Ended) -> Discovery:
    """What stays of a walk: steps that held-out records refute or later ones make superfluous are taken back, and each
    is asked anew what it could be mistaken for."""
    walked, look, at_best, ranking, _ = ended
    start, first, library, report = walked.start, look.first, look.library, look.report
    regression, candidates = look.regression, look.candidates
    steps = _without_refuted(start, list(walked.steps), regression)
    alike: tuple[Parts, ...] = ()
    even: Mapping[str, str] = {}
    if steps:
        weighed = steps[-1].partner is None
        needed = prune(steps[-1].fit, [s.added for s in steps], library, first, report, weighed)
        alike, even = needed.alike, needed.even
        if needed.names != tuple(s.added for s in steps):
            steps = _replayed(start, needed, Look(at_best, at_best, library, report), walked.gains)
            if steps:  # the laws before the last one have changed
                steps = _without_refuted(start, steps, prepare(working(steps[-1].fit)))
        elif needed.fit is not steps[-1].fit:  # another law in the place of one has led to a better minimum with it
            steps[-1] = steps[-1]._replace(fit=needed.fit)
    if steps:
        named = [step.added for step in steps]
        last = without_idle_constant(steps[-1].fit, named, start, report)
        steps[-1] = steps[-1]._replace(fit=with_finer_laws(last, start, report))
    steps = _on_all_samples(start, steps, report)
    if steps:
        steps[-1] = steps[-1]._replace(fit=with_last_zeros(steps[-1].fit, library, report))
    final = steps[-1].fit if steps else start
    if final is not walked.final:
        regression = prepare(working(final))
        candidates = score(regression, library)
    blurred = [step for step in steps if step is not steps[-1] or step.partner or step.moved]
    steps = [tied_at_the_end(s, final, first.fit, library, report) if s in blurred else s for s in steps]
    steps = [_beside_its_even(_beside_parts(step, alike), even, library) for step in steps]
    remaining = tuple(significant(candidates))
    steps = _not_only_shapes(steps, regression)
    lacks = lacking(_after_effects(steps, regression), first, report) if steps else 0.0
    verdict = _verdict(steps, regression, first, lacks, final)
    return Discovery(verdict, start, tuple(steps), ranking, walked.gains, remaining, regression, lacks)


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


def _not_only_shapes(steps: list[Step], regression: Regression) -> list[Step]:
    """The steps with the terms at the end as effects, and no refinements, that reach the noise and leave no structure
    of what they met, or say more than any bending of the laws before them would."""
    named = _last_effect(steps) + 1
    refining = steps[named:]
    met = refining[0].regression if refining else None
    if met is None or not adequate(regression):
        return steps
    if not (leaves_no_structure(regression, met) or says_more_than_shapes(regression, met)):
        return steps
    return [*steps[:named], *(step._replace(role="effect") for step in refining)]


def _last_effect(steps: list[Step]) -> int:
    """The place of the last step that is an effect, as the first always is; -1 without steps."""
    return max((i for i, step in enumerate(steps) if step.role == "effect"), default=-1)


def _after_effects(steps: list[Step], regression: Regression) -> Regression:
    """The regression of the last effect, without the terms that only refine shapes: they would hide that a law
    differs."""
    last = _last_effect(steps)
    return regression if last == len(steps) - 1 else prepare(working(steps[last].fit))


def _replayed(start: Fit, needed: Pruned, look: Look, gains: Mapping[str, float]) -> list[Step]:
    """The steps as they would have been without the terms that proved superfluous; `look`: where the walk began, and
    `gains` of what was refitted there.

    Of two laws that do the same to these records the second shows only beside a third, and comes after that.
    """
    steps: list[Step] = []
    current, names, library = start, list(needed.names), look.library
    while names:
        look = look.at(prepare(working(current))) if steps else look
        regression = look.regression
        forms = score(regression, {name: library[name] for name in names if library[name].form_of}, forms=True)
        candidates = [*score(regression, library), *forms]
        chosen = min((c for c in candidates if c.name in names), key=lambda c: names.index(c.name), default=None)
        if chosen is None:  # beside the others it does nothing that they do not
            return [*steps[:-1], steps[-1]._replace(fit=needed.fit)] if steps else []
        name = chosen.name
        names.remove(name)
        found = confirm(regression, library[name], chosen)
        current = accept(found, current) if names else needed.fit
        role = role_of(found.model.effects[-1], regression, found.chi2, look.first)
        real, kept = significant(candidates), {} if steps else gains
        steps.append(step_with(found, regression, real, library, role, current, tried=[found], gains=kept))
    return steps


def tied_at_the_end(step: Step, last: Fit, start: Fit, library: Registry, report: Report) -> Step:
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
    if not np.isfinite(found.chi2):
        return step
    chosen = found.candidate  # perhaps with other words
    if not regression.credible:  # by what scores say all then tie, and short refits of the one in place say no more
        kept = max(regression.best_chi2 - found.chi2, 0.0)
        chosen = chosen._replace(drop=kept, predicted_gain=float(np.clip(found.gain, 0, 1)))
        others = [candidate for candidate in candidates if candidate.name != step.added]
        candidates = [chosen, *by_refits(regression, others, library, report)]
        found = found._replace(candidate=chosen)
    ties, tied = weighed_ties(regression, found, candidates, library, [found])
    return step._replace(tie_set=ties.names, reasons=ties.reasons, tied=tied, regression=regression)


def _beside_parts(step: Step, alike: tuple[Parts, ...]) -> Step:
    """A step with the other answer, where an effect and a few simpler ones together do as well."""
    for parts in alike:
        if step.added == (parts.names[0] if parts.better else parts.whole):
            reason = f"{parts.words}: they explain the misfit as well"
            names = tuple(dict.fromkeys([*step.tie_set, *((parts.whole,) if parts.better else parts.names)]))
            return step._replace(tie_set=names, reasons=tuple(dict.fromkeys((*step.reasons, reason))), instead=parts)
    return step


def _beside_its_even(step: Step, even: Mapping[str, str], library: Registry) -> Step:
    """A step with the rival that does as well in its place, now that all the others are in."""
    rival = even.get(step.added)
    if rival is None or rival in step.tie_set or step.role != "effect":
        return step
    separate = what_separates(library[step.added], library[rival])
    reason = f"{step.added} or {rival}: in its place it explains the misfit as well; to tell them apart: {separate}"
    return step._replace(tie_set=(*step.tie_set, rival), reasons=(*step.reasons, reason))


def _verdict(steps: list[Step], regression: Regression, first: Regression, lacks: float, final: Fit) -> Verdict:
    """A name is given as sure only if what it leaves is noise, or as little as laws of one kind differ by, and nothing
    is where held-out records say otherwise."""
    fine, against = adequate(regression), contradicted(final)
    if not speaks_for(regression, final):
        return "not-in-library"
    if not steps:
        return "adequate" if fine and not against else "not-in-library"
    if not fine and max(lacks, (regression.chi2 - regression.n) / first.above_noise) > ANOTHER_LAW:
        return "not-in-library"
    tied = any(len(s.tie_set) > 1 for s in steps if s.role == "effect")
    return "ambiguous" if lacks or tied or against else "identified"
