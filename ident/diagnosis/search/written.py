"""A law that no library has: looked for beside the names of a walk or in their place, written to a file, simulated, and
kept if it says more than they do."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from typing import NamedTuple

from ...fit import Fit
from ...pulse import Report
from ..evidence.criterion import Left, clearly_better
from ..evidence.enough import LEAST, LITTLE, adequate, another_law, superfluous, worth_a_name
from ..evidence.held_out import BEYOND_FLOORS, hurts, predicts_better
from ..linearised.regression import Regression, prepare
from ..linearised.shorten import is_long, working
from ..linearised.trajectory import Diverged
from ..ranking.look import BROKEN
from ..unknown.effect_file import write_effect
from ..unknown.find import Unknown, find_unknown, followed_noise
from .beyond import Beyond, free_name, go_beyond
from .change import to_its_end, without
from .steps import Discovery, Step

AS_WELL = 1.1  # of χ² per sample: what is left counts as no more, a twentieth of an error bar


class Written(NamedTuple):
    """The walk, with what was written if that was kept; what the library lacks, if anything; and the file with it."""

    discovery: Discovery
    unknown: Unknown | None = None
    path: Path | None = None


def beyond_library(
    found: Discovery, start: Regression, path: Path | None, keeps_walk: bool, report: Report = lambda _: None
) -> Written:
    """What a walk lacks, written if `path` says where, and the walk with it.

    **Arguments:** `start`: of the fit that the walk began with; `keeps_walk`: whether what was named is kept, if it
    nearly explains the records, and what is written joins it.

    **Raises:** UserError if the file exists.
    """
    if found.verdict == "identified":
        return _with_shorter(found, start, path, report)
    if found.verdict != "not-in-library":
        unknown = lacked_by(start, report) if found.lacking else None
        if unknown is None or path is None or not (keeps_walk and _one_for_many(unknown, found, start)):
            return Written(found, unknown)
        beyond, gain = simulated(found.start, start, unknown, path, report)
        if not outdoes(found.final, beyond.fit):
            beyond.path.unlink()
            return Written(found, unknown)
        step = step_of(beyond._replace(fit=ended(beyond.fit)), gain)
        return Written(replace(found, steps=(step,), verdict="not-in-library"), beyond.unknown, beyond.path)
    if not found.steps and adequate(found.regression):
        return Written(found)  # they lack nothing: it is the held-out records that contradict, or the whole ones
    if path is None:
        return Written(found, lacked_by(start, report))
    beside = keeps_walk and nearly_explained(found)
    base, unknown = _lacked(found, start, report) if beside else (start, lacked_by(start, report))
    if unknown.written is None:
        return Written(found, unknown)
    beside = base is found.regression
    last = found.final if beside else found.start
    if beside and is_long(last.campaign):  # a refit of many terms to long records takes longer than the walk
        write_effect(unknown, path, free_name(last))
        return Written(found, unknown, path)
    beyond, gain = simulated(last, base, unknown, path, report)
    if gain < BROKEN * beyond.unknown.share and not found.steps and not _helped(found, start):
        beyond.path.unlink()  # neither an effect of the library nor this one is there, once it is simulated
        return Written(replace(found, verdict="ambiguous", lacking=0.0), followed_noise(beyond.unknown, gain))
    better = beyond.fit.fitted.error_over_noise < found.final.fitted.error_over_noise and (
        beside or not found.steps or (beyond.unknown.told and outdoes(found.final, beyond.fit))
    )
    if better and not hurts(last, beyond.fit):  # what bends to the fitted records alone is written, but not kept
        step = step_of(beyond._replace(fit=ended(beyond.fit)), gain)
        found = replace(found, steps=(*found.steps, step) if beside else (step,))
        if beside and (by_itself := _by_itself(found, start, report)) is not None:
            found = replace(found, steps=(step._replace(fit=by_itself),))
    return Written(found, beyond.unknown, beyond.path)


@contextmanager
def kept_if_it_ends(path: Path) -> Iterator[None]:
    """A file that is written on the way stays only if the way is gone to its end: a walk that is stopped and resumed
    asks again. One that was there before is somebody's."""
    before = path.exists()
    try:
        yield
    except BaseException:
        if not before:
            path.unlink(missing_ok=True)
        raise


def _with_shorter(found: Discovery, start: Regression, path: Path | None, report: Report) -> Written:
    """The walk, in doubt where one law says more than its several names with fewer numbers, once it is simulated: a
    bent spring and a stop at its end make a sine of less than a turn. The names stay, for they are tried laws."""
    kept = Written(found)
    if len(found.steps) < 2 or path is None or is_long(found.start.campaign):
        return kept
    unknown, last = lacked_by(start, report), found.regression
    formula, numbers = unknown.formula, found.final.freedom - found.start.freedom
    if formula is None or not (formula.complete and unknown.of_one_law and formula.numbers < numbers):
        return kept
    if formula.chi2_per_sample * last.n > last.fit_chi2:
        return kept
    try:
        with kept_if_it_ends(path):
            beyond, _ = simulated(found.start, start, unknown, path, report)
    except Diverged:  # with it the motion has no bound
        return kept
    if not outdoes(found.final, beyond.fit, numbers_apart=True):
        path.unlink()
        return kept
    return Written(replace(found, verdict="ambiguous", shorter=formula.text), beyond.unknown, path)


def _helped(found: Discovery, start: Regression) -> bool:
    """Whether an effect of the library has explained a part of what is missing, once simulated: of an error that a
    wrong noise floor may make as much as a step must, for noise gives something to everyone."""
    vague = found.start.fitted.error_over_noise < BEYOND_FLOORS
    kept = max(found.confirmed.values(), default=0.0)
    return kept > LEAST if vague else worth_a_name(kept * start.excess, start)


def lacked_by(regression: Regression, report: Report) -> Unknown:
    """What a fit lacks, as a function of its coordinates."""
    report("estimating what the library lacks, as a function of its coordinates")
    return find_unknown(regression)


def _lacked(found: Discovery, start: Regression, report: Report) -> tuple[Regression, Unknown]:
    """Where what the library lacks is looked for: beside the effects that were named; or in their place, where that
    leaves less, for a wrong law may have taken the motion to where it forgets how it began."""
    beside, instead = (lacked_by(regression, report) for regression in (found.regression, start))
    said = beside.written is not None
    if said and beside.chi2_after < AS_WELL:
        # One law of fewer coordinates that says everything is a shorter answer than names and another law.
        shorter = instead.written is not None and instead.chi2_after < AS_WELL and instead.dimension < beside.dimension
        return (start, instead) if shorter else (found.regression, beside)
    as_well = said and beside.chi2_after < AS_WELL * instead.chi2_after
    return (found.regression, beside) if as_well else (start, instead)


def as_good_as_named(left: float, start: Regression) -> bool:
    """Whether effects of the library that leave so much χ² say it: nothing is left, or no more than a finer shape
    of the device's own law. A law written for these records has more shapes to bend."""
    return left < AS_WELL * start.n or not another_law(left - start.n, start)


def _one_for_many(unknown: Unknown, found: Discovery, start: Regression) -> bool:
    """Whether one law says everything that several names only come near to, and no effect of the library that was tried
    by itself says as much."""
    formula = unknown.formula
    says_it = formula is not None and formula.complete and unknown.of_one_law and unknown.chi2_after < AS_WELL
    left = start.n + (1 - max(found.confirmed.values(), default=0.0)) * start.excess
    return says_it and not as_good_as_named(left, start) and len(found.steps) > 1 and not is_long(found.start.campaign)


def simulated(last: Fit, base: Regression, unknown: Unknown, path: Path, report: Report) -> tuple[Beyond, float]:
    """The fit with what was written, and the share of the excess over noise that it removes."""
    beyond = go_beyond(last, base, unknown, path, report)
    before, after = (one.fitted.error_over_noise for one in (last, beyond.fit))
    return beyond, 1 - (after**2 - 1) / max(before**2 - 1, 1e-9)


def ended(found: Fit) -> Fit:
    """A fit that was only compared so far, taken to its end if it is to be kept."""
    return found if found.converged else to_its_end(found)


def step_of(beyond: Beyond, gain: float) -> Step:
    """What was written, as the step of a walk that removes a share `gain` of the excess over noise."""
    name = beyond.fit.model.names[-1]
    share = beyond.unknown.share
    return Step(added=name, predicted_gain=share, confirmed_gain=gain, tie_set=(name,), role="effect", fit=beyond.fit)


def nearly_explained(found: Discovery) -> bool:
    """Whether named effects leave so little that the rest is looked for beside them, and not in their place."""
    return little_of(*(fit.fitted.error_over_noise**2 for fit in (found.final, found.start)))


def little_of(after: float, before: float) -> bool:
    """Whether little of a misfit is left, both as χ² per sample."""
    return after - 1.0 < LITTLE * (before - 1.0)


def _by_itself(found: Discovery, first: Regression, report: Report) -> Fit | None:
    """The fit with the last step alone, where the named effects before it do no more beside it."""
    names = [step.added for step in found.steps[:-1]]
    if not names:
        return None
    report(f"does the model still need {' and '.join(names)}?")
    by_itself = without(found.final, names)  # what was written from their misfit may say what they did
    try:
        fine = superfluous(prepare(working(by_itself)), prepare(working(found.final)), first)
    except Diverged:  # without them the motion has no bound
        return None
    return by_itself if fine else None


def outdoes(named: Fit, written: Fit, numbers_apart: bool = False) -> bool:
    """Whether what was written in the place of named effects is better than they are by the criterion, which counts its
    numbers, and on records held out; `numbers_apart`: that it has fewer is no reason."""
    try:
        ones = [prepare(working(one)) for one in (written, named)]
        better = clearly_better(*(Left(one.residual, 0.0 if numbers_apart else one.numbers) for one in ones))
        return better and predicts_better(named, written)
    except Diverged:  # a motion without bound says nothing
        return False
