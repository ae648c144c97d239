"""Records that disagree with the others in a way that no device explains, found before any physics is named.

Each record in turn is left out of the fit, and predicted by what the others tell. A suspect is a record that is
predicted far worse than the others agree among themselves, and that one number of its own (a delay, a gain, a sign, a
time scale, a drift), or a device of its own, brings back among them. A missing effect spoils the agreement of all
records instead, and no such number takes it away.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from ..campaign.campaign import Campaign
from ..campaign.record import Trace
from ..campaign.suspect import Suspect, suspects_by_data
from ..fit import Fit
from ..fit.fit import minimise
from ..fit.guess import GRID_STEP, coarse_frequency
from ..fit.reading import read
from .nuisance import Nuisance, nuisances, rms
from .shorten import is_long

Report = Callable[[str], None]

BY_OTHERS = ("delay", "gain", "sign", "time-scale", "wrong-record")
"""Kinds of suspects that only other records tell. An effect may be mistaken for them: beside one no name is sure."""

_FLOOR = 1.3  # error over noise up to which records agree; floors are known to some ten per cent
_FAR = 3.0  # times worse than the others agree, from which on a record disagrees
_BACK = 1.5  # times as bad as the others agree, up to which a corrected record is one of them
_MOST = 8  # records that are left out in turn, the worst first: a refit each
_STEPS = 40
_OF_FREQUENCY = "% of frequency"
_SURE, _LIKELY = 0.95, 0.9
"""Of suspects that settle everything down to the noise, and of the others. In experiments/faulty_records 21 of 21 and
17 of 18 were right; by the rule of succession that is 0.96 and 0.9, of campaigns half of which have a fault."""
_SCALES = (0.5, 2.0, 0.1, 10.0, 0.9, 1.1, 0.95, 1.05, 0.98, 1.02, 0.99, 1.01)


def find_suspects(fitted: Fit, report: Report = lambda _: None) -> tuple[Suspect, ...]:
    """The suspect records of a fit's campaign: what the data alone tell, and what the records tell of one another."""
    found = list(suspects_by_data(fitted.campaign))
    if is_long(fitted.campaign) or not _disagree(fitted):
        return tuple(found)
    report("do the records agree with one another?")
    return tuple(found + _by_others(fitted))


def _disagree(fitted: Fit) -> bool:
    errors = [score.error_over_noise for score in fitted.trace_scores]
    return len(errors) > 1 and max(errors) > _FAR * _FLOOR


def cleared(suspects: tuple[Suspect, ...], final: Fit) -> tuple[Suspect, ...]:
    """The suspects that stay when physics has been named.

    If all records, held-out ones too, stand at their noise with one model, none disagrees with the others: what looked
    so was the shape of what had been missing. What the data of a record alone tell stays.
    """
    agree = all(score.error_over_noise <= _FLOOR for score in final.scores)
    return tuple(one for one in suspects if not agree or one.kind not in BY_OTHERS)


def _by_others(fitted: Fit) -> list[Suspect]:
    traces = fitted.campaign.traces
    worst = sorted(range(len(traces)), key=lambda i: -fitted.trace_scores[i].error_over_noise)
    inside = [i for i in worst if not traces[i].holdout][:_MOST]
    outside = [i for i in worst if traces[i].holdout][:_MOST]
    best: tuple[float, Suspect] | None = None
    values = fitted.values
    if len(inside) > 2:
        for i in inside:
            told = _values_without(fitted, i)
            one = None if told is None else _judged(fitted, told, i)
            if told is not None and one is not None and (best is None or one[0] > best[0]):
                best, values = one, told
    found = [] if best is None else [best[1]]
    gone = {s.file for s in found}
    for i in outside:
        one = _judged(fitted, values, i, gone)
        if one is not None:
            found.append(one[1])
    return found


def _values_without(fitted: Fit, i: int) -> np.ndarray | None:
    """Parameter values that the other records tell.

    The fit starts where that of all ended, unless the others point to another resonance: one record may have led it
    astray.
    """
    traces = fitted.campaign.traces
    kept = tuple(r for j, r in enumerate(traces) if not r.holdout and j != i)
    initial = fitted.values
    if fitted.model.form in ("oscillator", "overdamped"):
        frequency = coarse_frequency(kept, fitted.campaign.fitted)
        initial = fitted.values if abs(math.log(frequency / fitted.values[0])) < 1.5 * GRID_STEP else None
    try:
        return minimise(fitted.model, replace(fitted.campaign, records=kept), initial=initial, most=_STEPS).values
    except (FloatingPointError, np.linalg.LinAlgError):
        return None


def _judged(
    fitted: Fit, values: np.ndarray, i: int, gone: set[str] | frozenset[str] = frozenset()
) -> tuple[float, Suspect] | None:
    """How far a record is off by values that the others tell, and the suspect that it is, if it is one."""
    traces = fitted.campaign.traces
    readings = read(fitted.model, values, traces)
    errors = [rms((t.response - r)[t.skip :], t.noise.sigma) for t, r in zip(traces, readings, strict=True)]
    others = [errors[j] for j in range(len(traces)) if j != i and not traces[j].holdout and traces[j].name not in gone]
    if not others or not np.all(np.isfinite(readings[i])):
        return None
    agree = max(1.0, float(np.sqrt(np.mean(np.square(others)))))
    if not errors[i] > _FAR * agree:
        return None
    told = _explained(fitted, values, i, readings, _BACK * agree)
    if told is None:
        return None
    settles = agree <= _FLOOR and told.error <= _BACK * _FLOOR and not _may_be_an_effect(told, values)
    words = f"{_words(told, traces)}; so read, it agrees with the others (error over noise {errors[i]:.3g} → "
    words += f"{told.error:.3g}, theirs {agree:.3g})"
    probability = _SURE if settles else _LIKELY
    return errors[i] / agree, Suspect(traces[i].name, told.kind, told.size, told.unit, probability, words, settles)


def _explained(
    fitted: Fit, values: np.ndarray, i: int, readings: Sequence[np.ndarray], limit: float
) -> Nuisance | None:
    """The simplest explanation that brings a record back among the others."""
    record = fitted.campaign.traces[i]
    y, sigma = record.response, record.noise.sigma
    for one in nuisances(y, readings[i], sigma, record.skip):
        if one.error <= limit:
            return one
    scale = _time_scale(fitted, values, record, limit)
    if scale is not None:
        return scale
    for j, (other, reading) in enumerate(zip(fitted.campaign.traces, readings, strict=True)):
        if j != i and len(reading) == len(y) and rms((y - reading)[record.skip :], sigma) <= limit:
            return Nuisance("wrong-record", float(j), other.name, rms((y - reading)[record.skip :], sigma))
    return _own_device(fitted, values, record, limit)


def _time_scale(fitted: Fit, values: np.ndarray, record: Trace, limit: float) -> Nuisance | None:
    """The record's time runs s times as fast as it says."""

    def error(scale: float) -> float:
        stretched = replace(record, time=record.time * scale)
        reading = read(fitted.model, values, [stretched])[0]
        misfit = (record.response - reading)[record.skip :]
        return rms(misfit, record.noise.sigma) if np.all(np.isfinite(misfit)) else np.inf

    tried = {scale: error(scale) for scale in _SCALES}
    best = min(tried, key=lambda scale: tried[scale])
    width = 0.01
    while tried[best] > limit and width > 1e-4:
        for scale in (best * (1 - width), best * (1 + width)):
            tried[scale] = error(scale)
        nearer = min(tried, key=lambda scale: tried[scale])
        best, width = nearer, width if nearer != best else width / 2
    told = _beyond_an_effect(best - 1, values, limit)
    return Nuisance("time-scale", best, "1", tried[best]) if told and tried[best] <= limit else None


def _beyond_an_effect(shift: float, values: np.ndarray, limit: float) -> bool:
    """Whether a resonance that is off by a relative `shift` in one record says that it is another device's.

    A missing effect moves the resonance a little in some records, and free numbers take that up: it counts if the
    others stand at their noise, or if the resonance lies beside theirs by more than half its width.
    """
    return limit <= _BACK * _FLOOR or abs(shift) > _half_width(values)


def _may_be_an_effect(told: Nuisance, values: np.ndarray) -> bool:
    """Whether a record differs by no more than what a missing effect makes of it.

    To a sine every nonlinear device is a linear one, of another frequency and quality at each level (N. Minorsky,
    Nonlinear Oscillations, 1962, ch. 14): friction that shows in the weakest record alone makes another device of it.
    """
    if told.kind == "time-scale":
        return abs(told.size - 1) <= _half_width(values)
    return told.kind == "wrong-record" and told.unit == _OF_FREQUENCY and abs(told.size) <= 100 * _half_width(values)


def _half_width(values: np.ndarray) -> float:
    """Half the width of the resonance, as a part of its frequency."""
    return 0.5 / max(float(values[1]), 1.0)


def _own_device(fitted: Fit, values: np.ndarray, record: Trace, limit: float) -> Nuisance | None:
    """A device of its own, with another frequency, quality and gain: another load, or another device."""
    alone = Campaign("", (replace(record, holdout=False),), fitted.campaign.device)
    try:
        own = minimise(fitted.model, alone, most=_STEPS).values
    except (FloatingPointError, np.linalg.LinAlgError):
        return None
    error = rms((record.response - read(fitted.model, own, [record])[0])[record.skip :], record.noise.sigma)
    shift = float(own[0]) / float(values[0]) - 1
    told = _beyond_an_effect(shift, values, limit)
    return Nuisance("wrong-record", 100 * shift, _OF_FREQUENCY, error) if told and error <= limit else None


def _words(one: Nuisance, traces: Sequence[Trace]) -> str:
    size = f"{one.size:.3g}"
    if one.unit == "samples from some sample on":
        return f"samples are missing: towards its end the response comes {abs(one.size):.3g} samples too early"
    if one.kind == "wrong-record":
        known = any(trace.name == one.unit for trace in traces)
        return (
            f"the response is that of {one.unit}" if known
            else f"it belongs to another device or load, with a resonance {one.size:+.2g} % off"
        )  # fmt: skip
    return {
        "delay": f"the response comes {abs(one.size):.3g} samples {'late' if one.size > 0 else 'early'}",
        "gain": f"the response is {size} times what the others tell",
        "sign": f"the response is inverted ({size} times what the others tell)",
        "time-scale": f"its time runs {size} times as fast as it says, or its device is another or otherwise loaded",
        "drift": f"the response drifts by {size} noise floors",
    }[one.kind]
