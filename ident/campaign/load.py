"""From a table and what the campaign says about it to a record in SI units."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

import numpy as np

from ident.errors import UserError
from ident.units import NUMBER, VOLTAGE, base_unit, find_unit

from .added_drive import with_drive
from .channel import channel_of, own_units, plausible_noise
from .device import NOMINAL_RESONANCE, Device
from .drive import find_period
from .guess import guess_kind, match_any
from .lost_samples import times_of
from .noise.floor import noise_floor
from .outages import of_use, stretches
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
from .record import LEAST, MEASURES, Channel, NoiseFloor, Record, Trace
from .scale import Scale
from .segments import segment_of
from .spec import RecordSpec, signal_units
from .sweeps.load import load_sweep
from .tables.amplitude_unit import is_amplitude_unit
from .tables.binary import READERS
from .tables.columns import Role, match_columns, trace_roles, without_reference
from .tables.instruments import INSTRUMENT_READERS
from .tables.table import Column, Table
from .tables.text import read_text_table

_PLATFORM_OMEGA = 2 * math.pi * NOMINAL_RESONANCE  # rad/s: what a velocity means as a displacement


def read_table(path: Path, name: str, own_units: tuple[str, ...] = ()) -> Table:
    """The table in a data file of any known kind."""
    suffix = path.suffix.lower()
    reader = READERS.get(suffix) or INSTRUMENT_READERS.get(suffix)
    if reader is not None:
        return reader(path, name)
    own = next((unit for unit in own_units if find_unit(unit) is None), "")
    return read_text_table(path, name, own)


def load_record(spec: RecordSpec, table: Table, device: Device) -> tuple[list[tuple[RecordSpec, Record]], list[str]]:
    """The record, or the stretches of one with outages, each with what is said of it, and the notes on them."""
    (unit, dimension), _ = signal_units(device)
    table = with_drive(spec, table, read_table, unit, dimension)
    kind = spec.kind or guess_kind(table)
    notes = list(table.notes)
    if kind == "sweep":
        if not spec.kind:
            notes.append(f'{spec.file}: taken as a sweep (kind = "sweep"), because it has a frequency and no time.')
        sweep, found = load_sweep(spec, table, device)
        return [(spec, sweep)], notes + found
    told = _columns(spec, segment_of(spec, table), device, notes)
    parts, found = of_use(spec, stretches(told))
    notes += found
    traces = [(own, _trace(own, columns, device, notes)) for own, columns in parts]
    begun = traces[0][1].time[0]
    return [(own, replace(trace, into=float(trace.time[0] - begun))) for own, trace in traces], notes


def _no_peak_unit(column: Column) -> None:
    if column.unit is not None and find_unit(column.unit) is None and is_amplitude_unit(column.unit):
        what = f'"{column.unit}" is a unit of amplitudes, but a trace needs the instantaneous value'
        raise UserError(what, where=f'{column.file}, column "{column.header}"', do="name the column of the waveform")


def _signal(column: Column, base: str, scale: Scale | None, notes: list[str], role: str) -> tuple[Channel, np.ndarray]:
    """The numbers of a column in SI, NaN where one is missing, and the unit in which they are shown."""
    values = column.numbers(missing=True)
    if scale is None:
        channel = channel_of(column, base, notes, role)
        return channel, values * channel.factor
    read = channel_of(column, base_unit(scale.dimension), notes, role)
    return Channel(scale.unit, scale.size), values * read.factor * scale.factor


def _columns(spec: RecordSpec, table: Table, device: Device, notes: list[str]) -> dict[str, Column]:
    """The columns of a trace by their roles."""
    if spec.relative_noise:
        what = f"{spec.file} is a trace: its noise is no share of an amplitude"
        raise UserError(what, where=spec.where, do='write for example noise = "12 nm"')
    (_, drive_dimension), (_, response_dimension) = signal_units(device, spec.measures)
    roles = trace_roles(drive_dimension or NUMBER, response_dimension or NUMBER, own_units(device, spec.measures))
    roles = tuple(replace(r, dimension=spec.scale[r.name].dimension, own_unit="") if r.name in spec.scale else r
                  for r in roles)  # fmt: skip
    given = dict(spec.columns)
    if "reference" in given:
        table = without_reference(table, given.pop("reference"), spec.where)
        notes.append(
            f"{spec.file}: a loop is closed around the device; the drive that was measured is what counts, but noise "
            "that the loop feeds back may bias a fit."
        )
    if spec.rate is not None:
        roles = roles[1:]
        if "time" in given:
            raise UserError("both rate and a time column are given", where=spec.where, do="remove one of them")
    try:
        columns = _matched(spec, table, roles, given, notes)
    except UserError:
        if spec.measures == "displacement" or "response" in spec.scale or signal_units(device)[1][1] != VOLTAGE:
            raise
        # A sensor's output is in V whatever it reads.
        roles = tuple(replace(r, dimension=VOLTAGE) if r.name == "response" else r for r in roles)
        columns = _matched(spec, table, roles, given, notes)
        rate = signal_units(device, spec.measures)[1][0]
        notes.append(f"{spec.file}: a sensor in V reads a {spec.measures}: its V are taken for {rate}.")
    for column in columns.values():
        _no_peak_unit(column)
    return columns


def _matched(
    spec: RecordSpec, table: Table, roles: tuple[Role, ...], given: Mapping[str, str | int], notes: list[str]
) -> dict[str, Column]:
    """The columns that play these roles; none a drive's, where nothing drives."""
    without = tuple(role for role in roles if role.name != "drive")
    fewer = "drive" not in given and len(table.columns) < len(roles)
    undriven = spec.undriven or (fewer and bool(match_any(table, without)))
    if undriven and not spec.undriven:
        notes.append(f"{spec.file}: there is no drive column; the record is taken as a free decay.")
    return match_columns(table, without if undriven else roles, given, spec.units, where=spec.where)


def _trace(spec: RecordSpec, columns: Mapping[str, Column], device: Device, notes: list[str]) -> Trace:
    (drive_unit, _), (response_unit, _) = signal_units(device, spec.measures)
    undriven = "drive" not in columns
    at = times_of(columns)
    response_channel, response = _signal(
        columns["response"], response_unit, spec.scale.get("response"), notes, "response"
    )
    gone = np.isnan(response)
    if np.any(gone):
        response = without_gaps(columns["response"], response, notes, at=at)
    drive_channel, drive = Channel(drive_unit, 1.0), np.zeros(len(response))
    if not undriven:
        drive_channel, drive = _signal(columns["drive"], drive_unit, spec.scale.get("drive"), notes, "drive")
        if np.any(np.isnan(drive)):
            gone = gone | np.isnan(drive)
            drive = without_gaps(columns["drive"], drive, notes, drive=True, at=at)
    check_length(len(drive), spec.file)
    if spec.rate is not None:
        time = np.arange(len(drive)) / spec.rate
    else:
        channel = channel_of(columns["time"], "s", notes, "time")
        time = uniform_time(columns["time"], channel.factor, notes)
        gone, drive, response = on_grid(columns["time"], channel.factor, time, gone, drive, response)
    moved = response / _PLATFORM_OMEGA ** MEASURES.index(spec.measures)
    check_plausible(time, drive, moved, columns, device, notes)
    check_response(columns["response"], response, notes)
    masked = clipped_mask(response)
    stuck = 0.0 if masked is None else float(np.mean(masked))
    if np.any(gone):
        masked = gone if masked is None else masked | gone
    outliers = find_outliers(response)
    if len(outliers):
        shown = ", ".join(f"{time[k]:.6g} s" for k in outliers[:5]) + (" …" if len(outliers) > 5 else "")
        many = f"{len(outliers)} samples leave" if len(outliers) > 1 else "one sample leaves"
        what = f"{many} the curve of the response (at {shown})"
        notes.append(f"{spec.file}: {what}; what the neighbours say takes their place.")
        response = without_outliers(response, outliers)
    slipped = find_slips(response, drive) if spec.measures == "displacement" else None
    if slipped is not None:
        count, first = np.count_nonzero(slipped), time[np.argmax(slipped)]
        what = (
            f"the sensor slips: {count} samples (first at {first:.6g} s) lie off the curve, on which it is soon again"
        )
        notes.append(f"{spec.file}: {what}; they are left out of every fit.")
        masked = slipped if masked is None else masked | slipped
    every = thinning(drive, response)
    whole = time, drive, response, masked
    if every > 1:
        smooth = response if masked is None else across_gaps(response, masked)
        time, drive, response = time[::every], thinned(drive, every), thinned(smooth, every)
        masked = None if masked is None else thinned_mask(masked, every)
        what = f"{len(whole[0])} samples are many more than the motion needs"
        notes.append(f"{spec.file}: {what}; filtered against aliases, and every {every}th of them kept.")
    start = spec.start or "unknown"
    check_drive(spec.file, drive, response, start, notes, undriven)
    level = rest_level(response if masked is None else across_gaps(response, masked)) if np.ptp(drive) == 0 else None
    level = level or 0.0
    period = find_period(drive)
    check_sampling(spec.file, drive, period, notes)
    skip = _skip_samples(spec, time, every)
    if spec.noise is not None:
        noise = NoiseFloor(plausible_noise(spec, float(np.std(response))), method="given in the campaign")
        if every > 1:  # filtering takes away the part of the noise that is faster
            before = noise_floor(*whole[:3], find_period(whole[1]), whole[3]).sigma
            ratio = noise_floor(time, drive, response - level, period, masked).sigma / before
            noise = replace(noise, sigma=noise.sigma * ratio, method=f"{noise.method}, less what the filter takes away")
    else:
        noise = noise_floor(time, drive, response - level, period, masked, lost=stuck == 0)
    if not spec.start:
        notes.append(f"{spec.file}: start is not given; the initial state is fitted.")
    return Trace(
        name=spec.name,
        time=time,
        drive=drive,
        response=response,
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
        masked=masked,
        stuck=stuck,
        between=spec.between,
        edge=0.0 if spec.between == "hold" else None,
    )


def _skip_samples(spec: RecordSpec, time: np.ndarray, every: int) -> int:
    """How many samples of those kept, every so many of the file's, are not counted."""
    step = (time[-1] - time[0]) / (len(time) - 1)
    # Whole numbers stay whole: a file may give one that no float holds.
    skip = -(-spec.skip // every) if isinstance(spec.skip, int) else math.ceil(spec.skip / step - 1e-6)
    if skip > len(time) - LEAST:
        what = f"skip = {spec.skip} leaves fewer than {LEAST} of {len(time)} samples to count"
        raise UserError(what, where=spec.where or spec.file, do="skip less")
    return skip
