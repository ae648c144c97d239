"""From the columns of a table to a trace: samples in SI units on an even grid, what of them counts, and their noise."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from ..errors import UserError
from ..units import base_unit
from .channel import channel_of, plausible_noise
from .device import NOMINAL_RESONANCE, Device
from .lost_samples import times_of
from .noise.floor import noise_floor
from .period import find_period
from .quality.checks import (
    check_drive,
    check_length,
    check_plausible,
    check_response,
    check_sampling,
    on_grid,
    uniform_time,
)
from .quality.clipping import across_gaps, clipped_mask
from .quality.gaps import without_gaps
from .quality.outliers import find_outliers, without_outliers
from .quality.rest_level import rest_level
from .quality.slips import find_slips
from .quality.thinning import thinned, thinned_mask, thinning
from .record import LEAST, MEASURES, Channel, NoiseFloor, Trace
from .scale import Scale
from .spec import RecordSpec, signal_units
from .tables.table import Column

_PLATFORM_OMEGA = 2 * math.pi * NOMINAL_RESONANCE  # rad/s: what a velocity means as a displacement
_SHOWN = 5  # times of outliers that are told


class _Samples(NamedTuple):
    """The samples of a trace, (n,) each, SI: `time`, `drive`, `response`, and which are `masked`, if any are."""

    time: np.ndarray
    drive: np.ndarray
    response: np.ndarray
    masked: np.ndarray | None = None

    def masking(self, more: np.ndarray | None) -> _Samples:
        """The same with more samples masked."""
        if more is None:
            return self
        return self._replace(masked=more if self.masked is None else more | self.masked)

    @property
    def crossed(self) -> np.ndarray:
        """The response with smooth curves in place of what is masked."""
        return self.response if self.masked is None else across_gaps(self.response, self.masked)


def trace_of(spec: RecordSpec, columns: Mapping[str, Column], device: Device, notes: list[str]) -> Trace:
    """The trace in columns, by their roles, of which the campaign says a `spec`.

    **Raises:** UserError if they are too few, too uneven or not plausible.
    """
    drive_channel, response_channel, read = _read(spec, columns, device, notes)
    moved = read.response / _PLATFORM_OMEGA ** MEASURES.index(spec.measures)
    check_plausible(read.time, read.drive, moved, columns, device, notes)
    check_response(columns["response"], read.response, notes)
    clipped = clipped_mask(read.response)
    stuck = 0.0 if clipped is None else float(np.mean(clipped))
    outliers = find_outliers(read.response)
    whole = _without_slips(spec, _without_outliers(spec, read.masking(clipped), outliers, notes), notes)
    every = thinning(whole.drive, whole.response)
    kept = _thinned(spec, whole, every, notes)
    start = spec.start or "unknown"
    check_drive(spec.file, kept.drive, kept.response, start, notes, "drive" not in columns)
    level = (rest_level(kept.crossed) if np.ptp(kept.drive) == 0 else None) or 0.0
    period = find_period(kept.drive)
    check_sampling(spec.file, kept.drive, period, notes)
    skip = _skip_samples(spec, kept.time, every)
    above = kept._replace(response=kept.response - level)
    if spec.noise is None:
        noise = noise_floor(*above[:3], period, above.masked, lost=stuck == 0)
    else:
        noise = NoiseFloor(plausible_noise(spec, float(np.std(kept.response))), method="given in the campaign")
        noise = noise if every == 1 else _filtered(noise, whole, above, period)
    if not spec.start:
        notes.append(f"{spec.file}: start is not given; the initial state is fitted.")
    return Trace(
        name=spec.name,
        time=kept.time,
        drive=kept.drive,
        response=kept.response,
        drive_channel=drive_channel,
        response_channel=response_channel,
        noise=noise,
        start=start,  # type: ignore[arg-type]
        holdout=spec.holdout,
        load=spec.load,
        skip=skip,
        period=period,
        outliers=tuple(int(k) // every for k in outliers),
        measures=spec.measures,
        masked=kept.masked,
        stuck=stuck,
        between=spec.between,
        edge=0.0 if spec.between == "hold" else None,
    )


def _read(
    spec: RecordSpec, columns: Mapping[str, Column], device: Device, notes: list[str]
) -> tuple[Channel, Channel, _Samples]:
    """The units in which drive and response are shown, and the samples on an even grid; those are masked that are
    missing."""
    (drive_unit, _), (response_unit, _) = signal_units(device, spec.measures)
    at = times_of(columns)
    response_channel, response, gone = _signal(spec, columns, "response", response_unit, at, notes)
    drive_channel, drive = Channel(drive_unit, 1.0), np.zeros(len(response))
    if "drive" in columns:
        drive_channel, drive, lost = _signal(spec, columns, "drive", drive_unit, at, notes)
        gone = gone | lost
    check_length(len(drive), spec.file)
    if spec.rate is not None:
        time = np.arange(len(drive)) / spec.rate
    else:
        channel = channel_of(columns["time"], "s", notes, "time")
        time = uniform_time(columns["time"], channel.factor, notes)
        gone, drive, response = on_grid(columns["time"], channel.factor, time, gone, drive, response)
    return drive_channel, response_channel, _Samples(time, drive, response, gone if np.any(gone) else None)


def _signal(
    spec: RecordSpec, columns: Mapping[str, Column], role: str, unit: str, at: np.ndarray | None, notes: list[str]
) -> tuple[Channel, np.ndarray, np.ndarray]:
    """The unit in which a signal is shown, its numbers in SI with smooth curves in place of those that are missing, and
    which these are; `at`: their times, if these are known."""
    channel, signal = _in_si(columns[role], unit, spec.scale.get(role), notes, role)
    gone = np.isnan(signal)
    if np.any(gone):
        signal = without_gaps(columns[role], signal, notes, drive=role == "drive", at=at)
    return channel, signal, gone


def _in_si(column: Column, base: str, scale: Scale | None, notes: list[str], role: str) -> tuple[Channel, np.ndarray]:
    """The unit in which the numbers of a column are shown, and these in SI, NaN where one is missing."""
    values = column.numbers(missing=True)
    if scale is None:
        channel = channel_of(column, base, notes, role)
        return channel, values * channel.factor
    read = channel_of(column, base_unit(scale.dimension), notes, role)
    return Channel(scale.unit, scale.size), values * read.factor * scale.factor


def _without_outliers(spec: RecordSpec, read: _Samples, outliers: np.ndarray, notes: list[str]) -> _Samples:
    """The samples with what their neighbours say in place of outliers."""
    if not len(outliers):
        return read
    shown = ", ".join(f"{read.time[k]:.6g} s" for k in outliers[:_SHOWN]) + (" …" if len(outliers) > _SHOWN else "")
    many = f"{len(outliers)} samples leave" if len(outliers) > 1 else "one sample leaves"
    what = f"{many} the curve of the response (at {shown})"
    notes.append(f"{spec.file}: {what}; what the neighbours say takes their place.")
    return read._replace(response=without_outliers(read.response, outliers))


def _without_slips(spec: RecordSpec, read: _Samples, notes: list[str]) -> _Samples:
    """The samples, those masked at which a sensor of displacement slips."""
    slipped = find_slips(read.response, read.drive) if spec.measures == "displacement" else None
    if slipped is None:
        return read
    count, first = np.count_nonzero(slipped), read.time[np.argmax(slipped)]
    what = f"the sensor slips: {count} samples (first at {first:.6g} s) lie off the curve, on which it is soon again"
    notes.append(f"{spec.file}: {what}; they are left out of every fit.")
    return read.masking(slipped)


def _thinned(spec: RecordSpec, whole: _Samples, every: int, notes: list[str]) -> _Samples:
    """Every so many of the samples, filtered against aliases."""
    if every == 1:
        return whole
    what = f"{len(whole.time)} samples are many more than the motion needs"
    notes.append(f"{spec.file}: {what}; filtered against aliases, and every {every}th of them kept.")
    masked = None if whole.masked is None else thinned_mask(whole.masked, every)
    return _Samples(whole.time[::every], thinned(whole.drive, every), thinned(whole.crossed, every), masked)


def _skip_samples(spec: RecordSpec, time: np.ndarray, every: int) -> int:
    """How many samples of those kept, every so many of the file's, are not counted."""
    step = (time[-1] - time[0]) / (len(time) - 1)
    # Whole numbers stay whole: a file may give one that no float holds.
    skip = -(-spec.skip // every) if isinstance(spec.skip, int) else math.ceil(spec.skip / step - 1e-6)
    if skip > len(time) - LEAST:
        what = f"skip = {spec.skip} leaves fewer than {LEAST} of {len(time)} samples to count"
        raise UserError(what, where=spec.where or spec.file, do="skip less")
    return skip


def _filtered(noise: NoiseFloor, whole: _Samples, kept: _Samples, period: float | None) -> NoiseFloor:
    """A noise that was given, of the `whole` samples, in those `kept`: filtering takes away the part that is faster."""
    before = noise_floor(*whole[:3], find_period(whole.drive), whole.masked).sigma
    ratio = noise_floor(*kept[:3], period, kept.masked).sigma / before
    return replace(noise, sigma=noise.sigma * ratio, method=f"{noise.method}, less what the filter takes away")
