"""Records that disagree with the others in a way that no device explains, found before any physics is named.

That one record is faulty (`faults`) competes with every effect of the library in one evidence: a record is suspect if
reading it as it should have been, with or without an effect, leaves clearly less than any effect does without that,
and takes away most of what physics leaves. A missing effect spoils the agreement of all records instead, and no number
of one record takes it away. Held-out records are judged by what the fitted ones then tell.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import lru_cache
from typing import NamedTuple

import numpy as np

from ...campaign.drive_sine import drive_sine
from ...campaign.quality.suspect import ALL, Suspect, set_aside, suspects_by_data
from ...campaign.record import Trace
from ...fit import Fit, fit
from ...fit.reading import read
from ...model import QUALITY, Model
from ...pulse import Report
from ..evidence.criterion import VERY_STRONG, Left, behind, criteria
from ..evidence.enough import ANOTHER_LAW, AT_FLOOR, MOST_OF_IT, speaks_for
from ..linearised.regression import Regression, prepare
from ..linearised.shorten import is_long, one_stretch_each
from ..linearised.trajectory import Diverged
from ..ranking.look import Look, first_look
from .astray import as_others_choose, of_these
from .faults import (
    OF_FREQUENCY,
    Fault,
    beside,
    common_delay,
    explanations,
    faults_of,
    likeliest,
    own_device,
    reach,
    told_by_others,
)
from .nuisance import OWN_CLOCK, Nuisance, rms
from .words import words_of

BY_OTHERS = ("delay", "gain", "sign", "time-scale", "wrong-record")
"""Kinds of suspects that only other records tell. An effect may be mistaken for them: beside one no name is sure."""

_FLOOR = 1.3  # error over noise up to which records agree; floors are known to some ten per cent
_FAR = 3.0  # times worse than the others agree, from which on a record disagrees
_BACK = 1.5  # times as bad as the others agree, up to which a corrected held-out record is one of them
_MOST = 8  # records that may be faulty, the worst first
_SURE, LIKELY = 0.95, 0.9
"""Of suspects that settle everything down to the noise, and of the others; see experiments/faulty_records."""


def find_suspects(
    fitted: Fit,
    look: Callable[[Fit], Look],
    report: Report = lambda _: None,
    two_do: Callable[[], bool] = lambda: False,
) -> tuple[Suspect, ...]:
    """The suspect records of a fit's campaign: what the data alone tell, and what the records tell of one another, long
    ones by a stretch of each; `look`: what the library says of a fit, if it is asked; `two_do`: whether two effects
    bring all records to their noise."""
    alone = told_by_data(fitted)
    if not _disagree(fitted):
        return alone
    report("do the records agree with one another?")
    try:
        seen = one_stretch_each(fitted)
        told = look(seen)
        if seen is not fitted and not speaks_for(told.regression.instead_of or told.regression, fitted):
            return alone  # what changes in the course of a record is not seen in a stretch of it
        others = _by_others(seen, told, two_do)
    except Diverged:  # a stretch of its motion has no bound
        return alone
    if seen is not fitted:
        others = [replace(one, says=f"{one.says}, in a stretch of each record") for one in others]
    said = {(one.file, one.kind) for one in others}
    return (*(one for one in alone if (one.file, one.kind) not in said), *others)


def told_by_data(fitted: Fit) -> tuple[Suspect, ...]:
    """What the data of each record alone tell, but for a drift that the model follows to the noise: that is the
    device's own, as one without a spring wanders, or has a name."""
    return tuple(one for one in suspects_by_data(fitted.campaign) if _stays(one, fitted))


def _stays(suspect: Suspect, fitted: Fit) -> bool:
    errors = {score.name: score.error_over_noise for score in fitted.trace_scores}
    return suspect.kind != "drift" or errors.get(suspect.file, np.inf) > _FLOOR


@lru_cache(maxsize=8)  # the terminal and the page ask
def alone_off(fitted: Fit) -> tuple[Suspect, ...]:
    """The record that alone keeps a model from the noise, if reading it otherwise brings all of them there: what a fit
    can say without asking what effects would do."""
    if not _disagree(fitted) or len(fitted.campaign.fitted) < 3 or is_long(fitted.campaign):
        return ()
    traces = fitted.campaign.traces
    errors = [score.error_over_noise for score in fitted.trace_scores]
    off = [i for i, trace in enumerate(traces) if not trace.holdout and errors[i] > _FAR * _FLOOR]
    if not off:
        return ()
    off = sorted(off, key=lambda i: -errors[i])[:_MOST]
    worst = off[0]
    if reach(fitted, traces[worst], own_device(fitted, worst)) > _FLOOR:
        off = [worst]  # without another record it would stay where it is
    rests = {i: told_by_others(fitted, i) for i in off}
    found = [
        fault for i, rest in rests.items() if rest and rest.worst <= _FLOOR
        for fault in faults_of(fitted, i, rest, _FLOOR)
    ]  # fmt: skip
    settled = [one for one in found if one.worst <= _FLOOR and _beyond_an_effect(one, fitted)]
    if not settled:
        return ()
    # Another device can be one whose only difference is a gain, and leaves a little less for its numbers.
    left = _left(fitted)
    weights = criteria([_beside(left, one.whole, one.numbers) for one in settled])
    best = settled[int(np.argmin(weights))]
    assert best.record is not None
    words = f"{words_of(best.told, traces)}; so read, all records stand at their noise. `ident diagnose` weighs that "
    words += "against effects"
    told = best.told
    return (Suspect(traces[best.record].name, told.kind, told.size, told.unit, LIKELY, words),)


def _disagree(fitted: Fit) -> bool:
    errors = [score.error_over_noise for score in fitted.trace_scores]
    return len(errors) > 1 and max(errors) > _FAR * _FLOOR


def judged_again(suspects: tuple[Suspect, ...], final: Fit, report: Report) -> tuple[Suspect, ...]:
    """The suspects beside the model that a walk has ended with: what looked so may have been the shape of what had
    been missing, and what that hid may show now. What the data of a record alone tell stays."""
    alone = tuple(one for one in suspects if one.kind not in BY_OTHERS and _stays(one, final))
    names = {one.file for one in alone}
    again = find_suspects(final, lambda one: first_look(one, {}, lambda _: None), report)
    return alone + tuple(one for one in again if one.file not in names and _stays(one, final))


class _Explained(NamedTuple):
    """What a model, with one effect more if that helps, says of records; `left` (n,) in white noise floors, `worst` the
    error over noise of the worst record; `traces`: as the held-out ones among them are to be read."""

    model: Model
    values: np.ndarray
    left: np.ndarray
    numbers: float
    worst: float
    traces: Sequence[Trace] = ()

    @property
    def excess(self) -> float:
        """χ² per sample above that of noise."""
        return max(float(np.mean(self.left**2)) - 1.0, 1e-9)


def _by_others(fitted: Fit, look: Look, two_do: Callable[[], bool]) -> list[Suspect]:
    scores = sorted(fitted.trace_scores, key=lambda score: -score.error_over_noise)
    outside = [score.name for score in scores if score.holdout][:_MOST]
    worst = next(score.error_over_noise for score in scores if not score.holdout)
    traces, most = fitted.campaign.traces, (len(fitted.campaign.fitted) - 1) // 2  # those that are off are the fewer
    known = _Explained(fitted.model, fitted.values, _left(fitted), fitted.freedom, worst, traces)
    found: list[Suspect] = []
    while known.excess > _FLOOR**2 - 1:
        one = _most_likely(fitted, _worst_first(fitted), look, lambda: not found and two_do())
        if not (found or (one and one[0].settles)) and (other := _as_others_choose(fitted, look, two_do)) is not None:
            one, fitted, look = other
            traces = fitted.campaign.traces
        if one is None or (found and one[0].file == ALL):
            break
        suspect, known = one
        if found:
            gone = " and ".join(other.file for other in found)
            suspect = replace(suspect, says=f"{suspect.says}, {gone} left out")
        found.append(suspect)
        traces = known.traces if suspect.file == ALL else traces
        if suspect.settles or suspect.file == ALL or len(found) >= most:
            break
        try:  # one fault may hide another: what do the others say of one another?
            fitted = of_these(fitted, set_aside(fitted.campaign, [suspect]))
            look = first_look(fitted, look.library, look.report)
        except Diverged:  # without it their motion has no bound
            break
    at = {trace.name: i for i, trace in enumerate(traces)}
    agree = rms(known.left, 1.0)
    told = [told_outside(known.model, known.values, agree, traces, at[name]) for name in outside]
    return found + [suspect for suspect in told if suspect is not None]


def _as_others_choose(
    fitted: Fit, look: Look, two_do: Callable[[], bool]
) -> tuple[tuple[Suspect, _Explained], Fit, Look] | None:
    """The faulty record that had led the choice of the first model astray, if it settles all beside what the others
    choose, and says clearly more than physics does beside the first; with the fit and the look that say so."""
    sound = _with_physics(fitted, look)
    if sound.worst <= _FLOOR or two_do():
        return None
    try:
        other = as_others_choose(fitted, _worst_first(fitted))
        there = other and first_look(other, look.library, look.report)
        one = _most_likely(other, _worst_first(other), there) if other and there else None
    except Diverged:  # its motion has no bound
        return None
    if other is None or there is None or one is None:
        return None
    suspect, faulty = one
    sure = suspect.settles and suspect.file != ALL and _better(faulty, sound, 0.0)
    told = replace(suspect, says=f"{suspect.says}, beside the linear model that the others choose")
    return ((told, faulty), other, there) if sure else None


def _worst_first(fitted: Fit) -> list[int]:
    """The fitted records that may be faulty; none of two, for if these contradict one another they do not tell which of
    them is wrong."""
    asked = {i: score.error_over_noise for i, score in enumerate(fitted.trace_scores) if not score.holdout}
    off = sorted((i for i, error in asked.items() if error > _FLOOR), key=lambda i: -asked[i])
    return off[:_MOST] if len(asked) > 2 else []


def _left(fitted: Fit) -> np.ndarray:
    """What a fit leaves of its fitted records, in noise floors."""
    residuals, tape = fitted.solved.found.residuals, fitted.solved.data.tape
    parts = [residuals[own][r.counted] for r, own in zip(fitted.campaign.fitted, tape.slices, strict=True)]
    return np.concatenate([*parts, residuals[tape.samples :]])


def _most_likely(
    fitted: Fit, inside: Sequence[int], look: Look, two_do: Callable[[], bool] = lambda: False
) -> tuple[Suspect, _Explained] | None:
    """The fault that explains the records better than physics does, if one does; one that leaves something is not
    asked for beside an effect where `two_do` as well."""
    left, sound = _left(fitted), _with_physics(fitted, look)
    agree = sound.worst <= _FLOOR
    if agree and not _could_be_shorter(sound, fitted):
        return None  # so told all records agree
    faults = likeliest(fitted, inside, lambda fault: _beyond_an_effect(fault, fitted))
    if all(fault.worst > _FLOOR for fault in faults):
        common = common_delay(fitted)
        faults += [] if common is None else [common]
    weights = criteria([Left(left, fitted.freedom), *(_beside(left, fault.whole, fault.numbers) for fault in faults)])
    if not weights[0] - min(weights) > VERY_STRONG:
        return None
    best = faults[int(np.argmin(weights)) - 1]
    scores = [s for s in fitted.trace_scores if not s.holdout]
    own = fitted.trace_scores[best.record] if best.record is not None else fitted.fitted
    shapes = ANOTHER_LAW * own.n / sum(s.n for s in scores) * max(own.error_over_noise**2 - 1.0, 1e-9)
    if best.worst <= _FLOOR:
        shapes = 0.0  # what brings all records to their noise is no law of another shape
    elif agree:
        return None
    if not sound.excess > shapes or (best.worst > _FLOOR and two_do()):
        return None  # nothing is left to explain
    read_so = fit(fitted.model, best.campaign, initial=best.values)
    try:
        faulty = _with_physics(read_so, first_look(read_so, look.library, look.report))
    except Diverged:  # nor does it explain the motion
        return None
    if faulty.model.names != fitted.model.names:
        best = beside(best, faulty.model, fitted.campaign, faulty.values)
        if np.mean(best.left**2) < np.mean(faulty.left**2):
            faulty = faulty._replace(values=best.values, left=best.left, worst=best.worst)
    faulty = faulty._replace(left=np.concatenate([faulty.left, best.apart]), numbers=faulty.numbers + 1)
    if not _better(faulty, sound, shapes):
        return None
    if faulty.model.names != fitted.model.names:
        instead = _instead(fitted, faulty, look)
        sound = sound if instead is None or behind(sound, instead) < 0 else instead
        if not _better(faulty, sound, shapes):
            return None
    campaign = best.campaign if best.record is None else fitted.campaign
    return _suspect(fitted, best, sound, faulty), faulty._replace(traces=campaign.traces)


def _better(faulty: _Explained, sound: _Explained, shapes: float) -> bool:
    """Whether a fault is clearly the better answer, and takes away most of what physics leaves and more than `shapes`;
    or says the same with fewer numbers, where both bring all records to their noise."""
    weights = criteria([sound, _beside(sound.left, faulty.left, faulty.numbers)])
    most = faulty.excess < MOST_OF_IT * sound.excess and sound.excess - faulty.excess > shapes
    shorter = max(sound.worst, faulty.worst) <= _FLOOR and faulty.excess <= sound.excess
    return (most or shorter) and weights[0] - weights[1] > VERY_STRONG


def _could_be_shorter(sound: _Explained, fitted: Fit) -> bool:
    """Whether a fault, which is one number, could be clearly better than physics that brings all records to their
    noise: by the numbers of a law that bends to anything, or by more than what models at their floor leave in each."""
    floor = AT_FLOOR if sound.worst <= AT_FLOOR else 1.0
    noise = sound.left / max(rms(sound.left, 1.0) / floor, 1.0)
    return behind(sound, Left(noise, fitted.freedom + 1)) > VERY_STRONG


def _beside(left: np.ndarray, other: np.ndarray, numbers: float) -> Left:
    """What another hypothesis leaves, as of as many samples: where a fault is read, a few may not count."""
    return Left(other * np.sqrt(len(left) / len(other)), numbers)


def _with_physics(fitted: Fit, look: Look) -> _Explained:
    """What the fit leaves, or the fit with the one effect that explains most of it."""
    regression = look.regression.instead_of or look.regression
    told = [(fitted.model, fitted.values, regression.left, fitted.freedom)]
    if regression.chi2 > _FLOOR**2 * regression.n:
        told += [(one.model, one.values, one.left, one.numbers) for one in look.tried if one.possible]
    tried = [_explained(fitted, regression, *one) for one in told]
    return tried[int(np.argmin(criteria(tried)))]


def _instead(fitted: Fit, faulty: _Explained, look: Look) -> _Explained | None:
    """An effect in the place of the fault, beside the effect that the fault was found with: of two that are missing
    it may mimic one."""
    look.report(f"an effect beside {faulty.model.names[-1]} in the place of a faulty record")
    try:
        one = fit(faulty.model, fitted.campaign, initial=faulty.values)
        return _with_physics(one, Look(prepare(one), look.first, look.library, look.report, answered=True))
    except Diverged:
        return None


def _explained(
    fitted: Fit, regression: Regression, model: Model, values: np.ndarray, left: np.ndarray, n: float
) -> _Explained:
    """A model by what it leaves of the samples that count."""
    parts = [left[own] for own in regression.places]
    counts = [r.counted[r.skip :] for r in fitted.campaign.fitted]
    parts[: len(counts)] = [part[own] for part, own in zip(parts, counts, strict=False)]
    return _Explained(model, values, np.concatenate(parts), n, max(rms(part, 1.0) for part in parts if len(part)))


def _suspect(fitted: Fit, best: Fault, sound: _Explained, faulty: _Explained) -> Suspect:
    told, traces = best.told, fitted.campaign.traces
    name = ALL if best.record is None else traces[best.record].name
    words = f"{words_of(told, traces)}; so read, error over noise falls from "
    words += f"{rms(_left(fitted), 1.0):.3g} to {rms(faulty.left, 1.0):.3g}"
    if sound.model.names != fitted.model.names:
        words += f", with {sound.model.names[-1]} instead to {rms(sound.left, 1.0):.3g}"
    if faulty.model.names != fitted.model.names:
        words += f", with {faulty.model.names[-1]} in the model"
    sure = _SURE if best.worst <= _FLOOR else LIKELY
    settles = faulty.worst <= _FLOOR
    left = 0.0 if settles else rms(faulty.left, 1.0) ** 2
    return Suspect(name, told.kind, told.size, told.unit, sure, words, first=True, settles=settles, left=left)


def _beyond_an_effect(fault: Fault, fitted: Fit) -> bool:
    """Whether a record differs by more than what a missing effect makes of it, the library's or not.

    To a sine every nonlinear device is a linear one, of another frequency and quality at each level (N. Minorsky,
    Nonlinear Oscillations, 1962, ch. 14): friction that shows in the weakest record alone makes another device of it.
    A resonance that lies beside that of the others by more than half its width is beyond that, and so is one by which
    a record under many frequencies, and all the others, stand at their noise.
    """
    record = None if fault.record is None else fitted.campaign.traces[fault.record]
    many = record is not None and record.driven and drive_sine(record) is None
    return (many and fault.worst <= _FLOOR) or _beyond_its_width(fault.told, fitted.values)


def _beyond_its_width(told: Nuisance, values: np.ndarray) -> bool:
    half_width = 0.5 / max(float(values[QUALITY]), 1.0)
    if told.kind == "time-scale" and told.unit != OWN_CLOCK:
        return abs(told.size - 1) > half_width
    return told.unit != OF_FREQUENCY or abs(told.size) > 100 * half_width


def told_outside(model: Model, values: np.ndarray, error: float, traces: Sequence[Trace], i: int) -> Suspect | None:
    """What is wrong with a record outside a fit that is predicted far worse than the fitted ones agree, to an `error`
    over noise, if one number tells it."""
    agree, record = max(1.0, error), traces[i]
    reading = read(model, values, [record])[0]
    if not np.all(np.isfinite(reading)):
        return None
    before = rms((record.response - reading)[record.counted], record.noise.sigma)
    if not before > _FAR * agree:
        return None
    told = next(iter(explanations(model, values, traces, i)), None)
    if told is None or told.error > _BACK * agree or not _beyond_its_width(told, values):
        return None
    words = f"{words_of(told, traces)}; so read, it agrees with the others (error over noise {before:.3g} → "
    words += f"{told.error:.3g}, theirs {agree:.3g})"
    return Suspect(record.name, told.kind, told.size, told.unit, _SURE if agree <= _FLOOR else LIKELY, words)
