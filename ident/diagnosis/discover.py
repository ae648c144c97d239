"""The loop by itself: fit, look where the error is, add the effect that explains it, until the noise floor.

Greedy addition with swaps. A term is added only if chance would not produce its gain and held-out records do not
suffer;
the model is adequate when no candidate is significant and the error stands at the noise floor. Adequacy, not the
falling
error, decides whether a name is reported: with the true effect absent from the library an impostor still lowers the
error.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Literal, NamedTuple

import numpy as np

from ..campaign.campaign import Campaign
from ..effects.effect import AbstractEffect
from ..fit import Fit, fit
from ..model import Model
from .confirm import Confirmed, accept, confirm
from .score import Bench, Candidate, prepare, score, significant
from .shorten import working
from .ties import tie_set

Verdict = Literal["adequate", "identified", "ambiguous", "not-in-library"]
Library = Mapping[str, type[AbstractEffect]]
Report = Callable[[str], None]

MOST_TERMS = 6
_SHORTLIST = 3
_NEAR = 0.1  # of the excess: candidates this near the best are confirmed too
_SHAPE = 0.01  # of the first excess: less is shape refinement, not an effect
_TIED_CRITERION = 10.0  # difference of the information criterion below which data do not choose
_SAME_SHAPE = 0.003  # of the excess: within this two laws differ in shape only
_HURT = 1.02  # held-out error may grow by this factor before a term is refused


class Step(NamedTuple):
    """One addition: what, how much it was predicted and confirmed to gain, what it ties with, and the fit after it.

    `reasons`: why it ties, in words; `tied`: the candidates that do, as scored on `bench`, the fit before.
    """

    added: str
    predicted_gain: float
    confirmed_gain: float
    tie_set: tuple[str, ...]
    role: Literal["effect", "shape-refinement"]
    fit: Fit
    reasons: tuple[str, ...] = ()
    tied: tuple[Candidate, ...] = ()
    bench: Bench | None = None


@dataclass(frozen=True, eq=False)
class Discovery:
    """The whole walk.

    **Arguments:** `start`: the fit it began with; `steps`: in order; `ranking`: candidates at the start, best first,
    and `confirmed`: gain of those that were refitted; `remaining`: significant candidates at the end; `bench`: of the
    end.
    """

    verdict: Verdict
    start: Fit
    steps: tuple[Step, ...]
    ranking: tuple[Candidate, ...]
    confirmed: Mapping[str, float]
    remaining: tuple[Candidate, ...]
    bench: Bench

    @property
    def final(self) -> Fit:
        return self.steps[-1].fit if self.steps else self.start


def discover(
    model: Model, campaign: Campaign, library: Library, report: Report = lambda _: None, most: int = MOST_TERMS
) -> Discovery:
    """Walk from a model to one that the records do not contradict, as far as the library reaches."""
    report(f"fitting {', '.join(model.names) or 'the linear model'}")
    start = fit(model, campaign)
    return continue_from(start, library, report, most)


def continue_from(start: Fit, library: Library, report: Report = lambda _: None, most: int = MOST_TERMS) -> Discovery:
    """The loop from a fit."""
    current, steps, first_excess = start, [], None
    ranking: tuple[Candidate, ...] = ()
    gains: dict[str, float] = {}
    bench = prepare(working(current))
    while True:
        report(f"scoring {len(library) - len(current.model.names)} effects")
        candidates = score(bench, library)
        ranking = ranking or tuple(candidates)
        real = significant(candidates)
        first_excess = max(bench.chi2 - bench.n, 1e-9) if first_excess is None else first_excess
        if not real or len(steps) >= most:
            break
        step = _best_step(current, bench, real, library, first_excess, gains if not steps else {}, report)
        if step is None:
            break
        steps.append(step)
        current = step.fit
        bench = prepare(working(current))
        report(f"added {step.added}: error over noise {current.fitted.error_over_noise:.3g}")
    steps = _without_impostors(start, steps, library, report)
    if steps and steps[-1].fit is not current:
        current = steps[-1].fit
        bench = prepare(working(current))
        candidates = score(bench, library)
    remaining = tuple(significant(candidates))
    return Discovery(_verdict(start, steps, current, remaining), start, tuple(steps), ranking, gains, remaining, bench)


def _best_step(
    current: Fit,
    bench: Bench,
    real: list[Candidate],
    library: Library,
    first_excess: float,
    gains: dict[str, float],
    report: Report,
) -> Step | None:
    """Confirm the best candidates by refits and take the one that the criterion prefers, if held-out data agree."""
    excess = max(bench.chi2 - bench.n, 1e-9)
    best = max(c.drop for c in real)
    short = [c for c in real if c.drop > best - max(_NEAR * excess, _TIED_CRITERION)][:_SHORTLIST]
    tried: list[Confirmed] = []
    for candidate in short:
        report(f"confirming {candidate.name}")
        tried.append(confirm(bench, library[candidate.name], candidate))
        gains[candidate.name] = tried[-1].gain
    limit = bench.chi2 + len(bench.scene.static.free) * np.log(bench.n)
    for found in _in_order(tried, max(_TIED_CRITERION, _SAME_SHAPE * excess)):
        if not np.isfinite(found.criterion) or found.criterion > limit:
            return None
        after = accept(found, current)
        if _hurts(current, after):
            continue
        share = (bench.chi2 - found.chi2) / first_excess
        role = "effect" if share > _SHAPE or not _names_effects(bench) else "shape-refinement"
        name, predicted = found.candidate.name, found.candidate.predicted_gain
        ties = tie_set(bench, found.candidate, real, library, tried)
        tied = tuple(c for c in real if c.name in ties.names)
        return Step(name, predicted, found.gain, ties.names, role, after, ties.reasons, tied, bench)
    return None


def _in_order(tried: list[Confirmed], same: float) -> list[Confirmed]:
    """Best first; of those that do equally well the simplest first. No library law has exactly the shape of the
    device's, so a rival with more shapes to bend will always fit a little closer."""
    limit = min(c.criterion for c in tried) + same
    near = sorted((c for c in tried if c.criterion <= limit), key=lambda c: (len(c.values), c.criterion))
    return near + sorted((c for c in tried if not c.criterion <= limit), key=lambda c: c.criterion)


def _names_effects(bench: Bench) -> bool:
    return bool(bench.fit.model.names)


def _hurts(before: Fit, after: Fit) -> bool:
    if before.holdout is None or after.holdout is None:
        return False
    return after.holdout.error_over_noise > _HURT * before.holdout.error_over_noise


def _without_impostors(start: Fit, steps: list[Step], library: Library, report: Report) -> list[Step]:
    """Take out every added effect that the later ones have made superfluous; swap one for a better one."""
    changed = len(steps) > 1
    while changed:
        changed = False
        for i, step in enumerate(steps[:-1]):
            last = steps[-1].fit
            report(f"does the model still need {step.added}?")
            without = fit(last.model - step.added, last.campaign, initial=_values_without(last, step.added))
            bench = prepare(working(without))
            n = float(np.log(bench.n))
            full = prepare(working(last)).chi2 + len(last.free) * n
            alone = bench.chi2 + len(without.free) * n
            if alone < full:
                steps = [*steps[:i], *steps[i + 1 : -1], steps[-1]._replace(fit=without)]
                changed = True
                break
            better = next(iter(significant(score(bench, library))), None)
            if better is None or better.name == step.added:
                continue
            trial = confirm(bench, library[better.name], better)
            if trial.criterion < full - _TIED_CRITERION:
                after = accept(trial, without)
                if not _hurts(last, after):
                    swapped = step._replace(added=better.name, tie_set=(better.name,))
                    steps = [*steps[:i], swapped, *steps[i + 1 : -1], steps[-1]._replace(fit=after)]
                    changed = True
                    break
    return steps


def _values_without(fitted: Fit, name: str) -> np.ndarray:
    return np.array([v for p, v in zip(fitted.model.parameters, fitted.values, strict=True) if p.effect != name])


def adequate(fitted: Fit, remaining: tuple[Candidate, ...]) -> bool:
    """Whether the error stands at the noise floor, within what is known of that floor."""
    doubt = float(np.mean([record.noise.relative_error for record in fitted.campaign.fitted]))
    return fitted.fitted.error_over_noise < 1.05 + 2 * min(doubt, 0.1)


def _verdict(start: Fit, steps: list[Step], final: Fit, remaining: tuple[Candidate, ...]) -> Verdict:
    if not adequate(final, remaining):
        return "not-in-library"
    if not steps:
        return "adequate"
    return "ambiguous" if any(len(s.tie_set) > 1 for s in steps if s.role == "effect") else "identified"
