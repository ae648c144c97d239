"""One record is faulty, or all are in one way: what all records then say together.

A fault is a hypothesis like an effect: the campaign with one record read as it should have been, or without it, and
the model fitted to all of it. What it leaves is weighed by the same evidence as what an effect leaves.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np
from scipy.optimize import minimize_scalar

from ...campaign.campaign import Campaign
from ...campaign.late import in_time
from ...campaign.record import Sweep, Trace
from ...fit import Fit
from ...fit.finish import Minimum
from ...fit.linear.guess import GRID_STEP, DataScales, coarse_frequency
from ...fit.minimise import refit
from ...fit.reading import read
from ...model import FREQUENCY, Model, as_weighed_by
from ..side_by_side import at_once
from .nuisance import OWN_CLOCK, Nuisance, best_scale, nuisances, rms, stretched

_SCALES = (0.5, 2.0, 0.1, 10.0, 0.9, 1.1, 0.95, 1.05, 0.98, 1.02, 0.99, 1.01)  # of time, tried first
_DELAYS = (-10, -6, -4, -2.5, -1.5, -0.7, 0, 0.7, 1.5, 2.5, 4, 6, 10)  # samples that all records may be late
_OF_A_SAMPLE = 2e-4  # to which a delay of all records is found: a motion of 50 samples a period moves 3e-5 of itself
_TRIED = 3  # explanations of a record that are fitted together with the others, the best first
_ROUNDS = 3  # of the fault's number and the device's in turn
_ROUNDS_BESIDE = 20  # the same beside an effect: a gain that was a quarter off took twelve
_BETTER = 0.99  # of the error: less is not worth another round
_LITTLE = 2.0  # times the error that is left
_STEPS = 40  # of least squares, at most, for each number of a fault
_FEW = 4  # from a neighbouring delay: enough to tell which one is near
OF_FREQUENCY = "% of frequency"


class Fault(NamedTuple):
    """A hypothesis: `record`, its place among the traces, is faulty as `told` says; all are if that is None.

    **Arguments:** `campaign`: the records as they should have been read; `values` (m,) SI of the model fitted to them;
    `left` (n,), what it leaves of them in noise floors, and `apart`, what a device of its own leaves of a record that
    is left out; `numbers` that were fitted in all; `worst`: error over noise of the worst record.
    """

    record: int | None
    told: Nuisance
    campaign: Campaign
    values: np.ndarray
    left: np.ndarray
    numbers: int
    worst: float
    apart: np.ndarray = np.zeros(0)

    @property
    def whole(self) -> np.ndarray:
        """What is left of all records."""
        return np.concatenate([self.left, self.apart])


class Rest(NamedTuple):
    """What the other records tell: `campaign` of them, `values` (m,) SI of the model fitted to them, how many `numbers`
    were fitted, what it leaves, `left` (n,) in noise floors, and the error over noise of the `worst` of them."""

    campaign: Campaign
    values: np.ndarray
    numbers: int
    left: np.ndarray
    worst: float


@lru_cache(maxsize=16)  # asked for again where no fault of them is found
def told_by_others(fitted: Fit, i: int) -> Rest | None:
    """What the records but one tell.

    The fit starts where that of all ended, unless the others point to another resonance: one record may have led it
    astray.
    """
    others = without(fitted.campaign, i)
    initial: np.ndarray | None = fitted.values
    if fitted.model.form in ("oscillator", "overdamped"):
        frequency = coarse_frequency(others.fitted, fitted.campaign.fitted, fitted.model.linear.mass)
        far = abs(math.log(frequency / fitted.values[FREQUENCY])) >= 1.5 * GRID_STEP
        initial = None if far else initial
    model = as_weighed_by(others, fitted.model, fitted.values)
    found = _minimum(model, others, initial, scales=fitted.scales)
    return found and Rest(others, found.values, len(found.static.free), *residual_of(found, others))


def likeliest(fitted: Fit, records: Sequence[int], allowed: Callable[[Fault], bool]) -> list[Fault]:
    """The allowed faults of some records, without those that cannot be the best one.

    However a record is read, the others are left no less than they are without it: records are asked in that order,
    until one would have to leave less than nothing of its own.
    """
    samples = sum(np.count_nonzero(r.counted) for r in fitted.campaign.fitted)
    rests = dict(zip(records, at_once(lambda i: told_by_others(fitted, i), records), strict=True))
    told = [(float(rest.left @ rest.left) / samples, i, rest) for i, rest in rests.items() if rest is not None]
    found: list[Fault] = []
    for least, i, rest in sorted(told, key=lambda one: one[0]):
        if least >= min((float(np.mean(fault.whole**2)) for fault in found), default=np.inf):
            break
        found += filter(allowed, faults_of(fitted, i, rest))
    return found


@lru_cache(maxsize=8)  # first whether the record can be described at all, then what is wrong with it
def own_device(fitted: Fit, i: int) -> Minimum | None:
    """A device of its own for one record: another load, or another device."""
    only = _only(fitted.campaign, fitted.campaign.traces[i])
    return _minimum(as_weighed_by(only, fitted.model, fitted.values), only, None, scales=fitted.scales)


def reach(fitted: Fit, record: Trace, *known: Minimum | None) -> float:
    """Error over noise below which no device that all records share brings a record, read so: that of a device of its
    own. `known`: such ones; another is looked for from where the fit is."""
    only = _only(fitted.campaign, record)
    model = as_weighed_by(only, fitted.model, fitted.values)
    found = (*known, _minimum(model, only, fitted.values, scales=fitted.scales))
    return min((residual_of(one, only)[1] for one in found if one is not None), default=np.inf)


def faults_of(fitted: Fit, i: int, rest: Rest, floor: float = np.inf) -> list[Fault]:
    """Ways in which one record may be faulty, each fitted together with the other records; those only that may bring it
    to an error over noise of `floor`."""
    model, campaign, record = fitted.model, fitted.campaign, fitted.campaign.traces[i]
    own = own_device(fitted, i)
    ratio = 1.0 if own is None else float(own.values[FREQUENCY]) / float(rest.values[FREQUENCY])
    tried = explanations(model, rest.values, campaign.traces, i, (*_SCALES, ratio))[:_TRIED]
    if floor < np.inf:  # its number is found anew beside the device, and may then say a little more
        tried = [told for told in tried if told.corrected and reach(fitted, told.corrected) <= _LITTLE * floor]
    found = [fault for told in tried if (fault := _together(model, campaign, i, told, rest.values)) is not None]
    if own is not None:
        apart, at_own = residual_of(own, _only(campaign, record))
        told = Nuisance("wrong-record", 100 * (ratio - 1), OF_FREQUENCY, at_own)
        numbers = rest.numbers + len(own.static.free)
        worst = max(rest.worst, at_own)
        found.append(Fault(i, told, rest.campaign, rest.values, rest.left, numbers, worst, apart))
    return [fault for fault in found if not rings_by_itself(model, fault)]


def rings_by_itself(model: Model, fault: Fault) -> bool:
    """Whether the device with which a fault goes would follow the records as well if nothing drove it.

    Read so, all records may have one frequency; a resonance there that hardly dies away follows any of them from the
    start that suits it, whatever its drive: that they agree is then no evidence.
    """
    records = fault.campaign.fitted
    if any(record.start != "unknown" for record in records) or not any(record.driven for record in records):
        return False
    still = {id(record): replace(record, drive=np.zeros_like(record.drive)) for record in records}
    silent = replace(fault.campaign, records=tuple(still.get(id(r), r) for r in fault.campaign.records))
    found = _minimum(model, silent, fault.values, _FEW)
    return found is not None and rms(residual_of(found, silent)[0], 1.0) < _LITTLE * rms(fault.left, 1.0)


def common_delay(fitted: Fit) -> Fault | None:
    """All responses come late, or early, alike: a lag that no record can place. A filter's is the same time in every
    record, a converter's the same number of samples. Decays alone have no drive to come late to."""
    if not any(record.driven for record in fitted.campaign.fitted):
        return None
    steps = [record.step for record in fitted.campaign.fitted]
    alike = [_common_delay(fitted, None)]
    if max(abs(late) for late in _DELAYS) * (max(steps) / min(steps) - 1) > _OF_A_SAMPLE:  # times are written rounded
        alike.append(_common_delay(fitted, min(steps)))
    return min(filter(None, alike), key=lambda fault: rms(fault.left, 1.0), default=None)


def _common_delay(fitted: Fit, step: float | None) -> Fault | None:
    """All responses come late by the same number of samples, of `step` s if that is not each record's own."""
    model, campaign = fitted.model, fitted.campaign

    def earlier(record: Trace | Sweep, late: float) -> Trace | Sweep:
        own = late * step / record.step if step and isinstance(record, Trace) else late
        return in_time(record, own) if isinstance(record, Trace) else record

    def read_so(late: float) -> Campaign:
        return replace(campaign, records=tuple(earlier(record, late) for record in campaign.records))

    known = {0.0: fitted.values}

    def error(late: float, most: int = _STEPS) -> float:
        nearest = known[min(known, key=lambda other: abs(other - late))]  # from there it takes a step or two
        found = _minimum(model, read_so(late), nearest, most)
        if found is None:
            return np.inf
        known[late] = found.values
        return rms(residual_of(found, read_so(late))[0], 1.0)

    coarse = min(sorted(_DELAYS, key=abs), key=lambda late: error(late, _FEW))
    reach = max(0.75, abs(coarse) / 2)
    bounds, options = (coarse - reach, coarse + reach), {"xatol": _OF_A_SAMPLE}
    best: Any = minimize_scalar(error, bounds=bounds, method="bounded", options=options)
    late = float(best.x)
    found = _minimum(model, read_so(late), known.get(late, fitted.values))
    if found is None:
        return None
    left, worst = residual_of(found, read_so(late))
    told = Nuisance("delay", late, "samples", rms(left, 1.0))
    return Fault(None, told, read_so(late), found.values, left, len(found.static.free) + 1, worst)


def without(campaign: Campaign, i: int) -> Campaign:
    """The campaign without its i-th trace."""
    gone = campaign.traces[i]
    return replace(campaign, records=tuple(r for r in campaign.records if r is not gone))


def residual_of(found: Minimum, campaign: Campaign) -> tuple[np.ndarray, float]:
    """What a minimum leaves, (n,) in noise floors, and the error over noise of the worst trace."""
    residuals, tape = found.best.found.residuals, found.data.tape
    parts = [residuals[own][r.counted] for r, own in zip(campaign.fitted, tape.slices, strict=True)]
    worst = max((rms(part, 1.0) for part in parts if len(part)), default=0.0)
    return np.concatenate([*parts, residuals[tape.samples :]]), worst


def beside(fault: Fault, model: Model, campaign: Campaign, values: np.ndarray) -> Fault:
    """A fault of one record of a campaign, found again beside a model that says more of the device, from its values:
    what the first lacked had bent the fault's number."""
    if fault.record is None:
        return fault
    return _together(model, campaign, fault.record, fault.told, values, _ROUNDS_BESIDE) or fault


def _together(
    model: Model, campaign: Campaign, i: int, told: Nuisance, values: np.ndarray, rounds: int = _ROUNDS
) -> Fault | None:
    """A fault and the device, each found anew as the other is known better."""
    record = campaign.traces[i]
    best: Fault | None = None
    for _ in range(rounds):
        if told.corrected is None:
            break
        read_so = _instead(campaign, record, told.corrected)
        found = _minimum(model, read_so, values)
        if found is None:
            break
        left, worst = residual_of(found, read_so)
        fault = Fault(i, told, read_so, found.values, left, len(found.static.free) + 1, worst)
        if best is not None and not rms(fault.left, 1.0) < _BETTER * rms(best.left, 1.0):
            break
        best, values = fault, found.values
        told = _anew(model, values, record, told)
    return best


def explanations(
    model: Model, values: np.ndarray, traces: Sequence[Trace], i: int, scales: Sequence[float] = _SCALES
) -> list[Nuisance]:
    """What may be wrong with a record that a model with given values predicts, best first."""
    record = traces[i]
    readings = read(model, values, traces, compared=True)
    if not np.all(np.isfinite(readings[i])):
        return []
    found = [*nuisances(record, readings[i]), _time_scale(model, values, record, scales)]
    for j, (other, reading) in enumerate(zip(traces, readings, strict=True)):
        if j != i and len(reading) == len(record.response) and np.all(np.isfinite(reading)):
            misfit = rms((record.response - reading)[record.counted], record.noise.sigma)
            as_that = replace(
                record, drive=other.drive, time=other.time, start=other.start, period=other.period, into=other.into
            )
            found.append(Nuisance("wrong-record", float(j), other.name, misfit, as_that))
    return sorted((one for one in found if np.isfinite(one.error)), key=lambda one: one.error)


def _anew(model: Model, values: np.ndarray, record: Trace, told: Nuisance) -> Nuisance:
    """The same explanation of a record, its number by what the model says now."""
    if told.kind == "time-scale" and told.unit != OWN_CLOCK:
        return _time_scale(model, values, record, (told.size,))
    reading = read(model, values, [record], compared=True)[0]
    if told.kind == "wrong-record" or not np.all(np.isfinite(reading)):
        return told
    same = lambda one: (one.kind in ("gain", "sign"), one.unit) == (told.kind in ("gain", "sign"), told.unit)
    return next(filter(same, nuisances(record, reading)))


def _time_scale(model: Model, values: np.ndarray, record: Trace, scales: Sequence[float]) -> Nuisance:
    """The record's time runs s times as fast as it says."""

    def error(scale: float) -> float:
        reading = read(model, values, [stretched(record, scale)], compared=True)[0]
        misfit = (record.response - reading)[record.counted]
        return rms(misfit, record.noise.sigma) if np.all(np.isfinite(misfit)) else 1e300

    scale, least = best_scale(error, scales)
    return Nuisance("time-scale", scale, "1", least, stretched(record, scale))


def _only(campaign: Campaign, record: Trace) -> Campaign:
    return replace(campaign, records=(replace(record, holdout=False),))


def _instead(campaign: Campaign, record: Trace, other: Trace) -> Campaign:
    return replace(campaign, records=tuple(other if r is record else r for r in campaign.records))


def _minimum(
    model: Model, campaign: Campaign, initial: np.ndarray | None, most: int = _STEPS, scales: DataScales | None = None
) -> Minimum | None:
    """`scales`: of all records, where these are a part: else a shape might leave its limits for those of a few."""
    try:
        found = refit(model, campaign, initial, most, scales=scales)
    except np.linalg.LinAlgError:
        return None
    return found if np.all(np.isfinite(found.best.found.residuals)) and np.all(np.isfinite(found.values)) else None
