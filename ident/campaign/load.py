"""From a table and what the campaign says about it to a record in SI units."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path

import numpy as np

from ident.errors import UserError
from ident.units import NUMBER, find_unit

from .added_drive import with_drive
from .binary_table import READERS
from .checks import check_drive, check_plausible, check_response, check_sampling, on_grid, uniform_time
from .columns import match_columns, sweep_roles, trace_roles
from .device import Device, Oscillator
from .drive import find_period
from .guess import guess_kind, match_any
from .instrument_files import INSTRUMENT_READERS
from .noise import noise_floor
from .outliers import find_outliers, without_outliers
from .record import MEASURES, Channel, Measures, NoiseFloor, Record, Sweep, Trace
from .rest_level import rest_level
from .spec import SWEEP_NAMES, RecordSpec, signal_units
from .sweep_noise import sweep_noise_floor
from .table import Column, Table, peak_unit
from .text_table import read_text_table

_PLATFORM_OMEGA = 2 * math.pi * 500.0  # rad/s, where a platform vibrates: what a velocity means as a displacement


def read_table(path: Path, name: str, own_units: tuple[str, ...] = ()) -> Table:
    """The table in a data file of any known kind."""
    suffix = path.suffix.lower()
    reader = READERS.get(suffix) or INSTRUMENT_READERS.get(suffix)
    if reader is not None:
        return reader(path, name)
    own = next((unit for unit in own_units if find_unit(unit) is None), "")
    return read_text_table(path, name, own)


def load_record(spec: RecordSpec, table: Table, device: Device) -> tuple[Record, list[str]]:
    """The record and the notes on it."""
    (unit, dimension), _ = signal_units(device)
    table = with_drive(spec, table, read_table, unit, dimension)
    kind = spec.kind or guess_kind(table)
    notes = list(table.notes)
    if not spec.kind and kind == "sweep":
        notes.append(f'{spec.file}: taken as a sweep (kind = "sweep"), because it has a frequency and no time.')
    record, found = (_sweep if kind == "sweep" else _trace)(spec, table, device)
    return record, notes + found


def _own_units(device: Device, measures: Measures = "displacement") -> tuple[str, str]:
    drive, response = signal_units(device, measures)
    return (drive[0] if drive[1] is None else "", response[0] if response[1] is None else "")


def _channel(column: Column, base: str, notes: list[str], role: str) -> Channel:
    """The unit of a column; without one it is the base unit, which is said."""
    if column.unit is None:
        notes.append(f'{column.file}: the {role} "{column.header}" states no unit; {base} is assumed.')
        return Channel(base, 1.0)
    found = find_unit(column.unit)
    return Channel(column.unit, found.factor if found else 1.0)


def _no_peak_unit(column: Column) -> None:
    if column.unit is not None and peak_unit(column.unit)[0] != column.unit and find_unit(column.unit) is None:
        what = f'"{column.unit}" is a unit of amplitudes, but a trace needs the instantaneous value'
        raise UserError(what, where=f'{column.file}, column "{column.header}"', do="name the column of the waveform")


def _trace(spec: RecordSpec, table: Table, device: Device) -> tuple[Trace, list[str]]:
    notes: list[str] = []
    (drive_unit, drive_dimension), (response_unit, response_dimension) = signal_units(device, spec.measures)
    roles = trace_roles(drive_dimension or NUMBER, response_dimension or NUMBER, _own_units(device, spec.measures))
    given, units = spec.columns, spec.units
    if spec.rate is not None:
        roles = roles[1:]
        if "time" in given:
            raise UserError("both rate and a time column are given", where=spec.where, do="remove one of them")
    without = tuple(role for role in roles if role.name != "drive")
    fewer = "drive" not in given and len(table.columns) < len(roles)
    undriven = spec.undriven or (fewer and bool(match_any(table, without)))
    if undriven and not spec.undriven:
        notes.append(f"{spec.file}: there is no drive column; the record is taken as a free decay.")
    columns = match_columns(table, without if undriven else roles, given, units, where=spec.where)
    for column in columns.values():
        _no_peak_unit(column)
    response_channel = _channel(columns["response"], response_unit, notes, "response")
    response = columns["response"].numbers() * response_channel.factor
    drive_channel, drive = Channel(drive_unit, 1.0), np.zeros(len(response))
    if not undriven:
        drive_channel = _channel(columns["drive"], drive_unit, notes, "drive")
        drive = columns["drive"].numbers() * drive_channel.factor
    if len(drive) < 20:
        raise UserError(f"{len(drive)} samples are too few", where=spec.file, do="a record needs at least 20 samples")
    if spec.rate is not None:
        time = np.arange(len(drive)) / spec.rate
    else:
        channel = _channel(columns["time"], "s", notes, "time")
        time = uniform_time(columns["time"], channel.factor, notes)
        drive, response = (on_grid(columns["time"], channel.factor, time, signal) for signal in (drive, response))
    moved = response / _PLATFORM_OMEGA ** MEASURES.index(spec.measures)
    check_plausible(time, drive, moved, columns, device, notes)
    check_response(columns["response"], response, notes)
    outliers = find_outliers(response)
    if len(outliers):
        shown = ", ".join(f"{time[k]:.6g} s" for k in outliers[:5]) + (" …" if len(outliers) > 5 else "")
        many = f"{len(outliers)} samples leave" if len(outliers) > 1 else "one sample leaves"
        what = f"{many} the curve of the response (at {shown})"
        notes.append(f"{spec.file}: {what}; what the neighbours say takes their place.")
        response = without_outliers(response, outliers)
    start = spec.start or "unknown"
    check_drive(spec.file, drive, response, start, notes, undriven)
    if np.ptp(drive) == 0 and (level := rest_level(response)) is not None:
        shown = f"{level / response_channel.factor:.6g} {response_channel.unit}"
        notes.append(
            f"{spec.file}: displacements are counted from {shown}, the level on which the decay comes to rest."
        )
        response = response - level
    period = find_period(drive)
    check_sampling(spec.file, time, drive, period, notes)
    skip = _skip_samples(spec, time)
    if spec.noise is not None:
        noise = NoiseFloor(_plausible_noise(spec, float(np.std(response))), method="given in the campaign")
    else:
        noise = noise_floor(time, drive, response, period)
    if not spec.start:
        notes.append(f"{spec.file}: start is not given; the initial state is fitted.")
    trace = Trace(
        name=spec.file,
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
        outliers=tuple(int(k) for k in outliers),
        measures=spec.measures,
    )
    return trace, notes


def _plausible_noise(spec: RecordSpec, size: float) -> float:
    """The noise given, if numbers of 16 digits can be weighed with it."""
    assert spec.noise is not None
    if 1e-12 * size <= spec.noise <= 1e6 * size:
        return spec.noise
    what = f"a noise of {spec.noise:.3g} cannot be right where the response has {size:.3g} rms (SI units)"
    raise UserError(what, where=f"{spec.where}: noise of {spec.file}", do="correct it, or leave it out")


def _skip_samples(spec: RecordSpec, time: np.ndarray) -> int:
    step = (time[-1] - time[0]) / (len(time) - 1)
    skip = spec.skip if isinstance(spec.skip, int) else math.ceil(spec.skip / step - 1e-6)
    if skip > len(time) - 20:
        what = f"skip = {spec.skip} leaves fewer than 20 of {len(time)} samples to count"
        raise UserError(what, where=spec.where or spec.file, do="skip less")
    return skip


def _sweep(spec: RecordSpec, table: Table, device: Device) -> tuple[Sweep, list[str]]:
    notes: list[str] = []
    (drive_unit, drive_dimension), (response_unit, response_dimension) = signal_units(device)
    roles = sweep_roles(drive_dimension or NUMBER, response_dimension or NUMBER, _own_units(device))
    given = {SWEEP_NAMES.get(role, role): column for role, column in spec.columns.items()}
    units = {SWEEP_NAMES.get(role, role): unit for role, unit in spec.units.items()}
    if spec.direction not in ("", "up", "down"):
        given["direction"] = spec.direction
    columns = match_columns(table, roles, given, units, where=spec.where)
    peak_drive, peak = (1.0, 1.0)
    if "level" in columns:
        columns["level"], peak_drive = _amplitude_unit(columns["level"])
    columns["amplitude"], peak = _amplitude_unit(columns["amplitude"])
    response_channel = _channel(columns["amplitude"], response_unit, notes, "amplitude")
    amplitude = columns["amplitude"].numbers() * response_channel.factor * peak
    frequency = _frequency(columns["frequency"], notes)
    if "level" in columns:
        drive_channel = _channel(columns["level"], drive_unit, notes, "drive level")
        level = columns["level"].numbers() * drive_channel.factor * peak_drive
    elif spec.level is not None:
        drive_channel, level = Channel(drive_unit, 1.0), np.full(len(frequency), spec.level)
    else:
        what = f"no column is recognised as the drive level; the columns are {table.found}"
        do = 'say which with columns = { level = "…" }, or give one for all rows with level = "3 V"'
        raise UserError(what, where=table.name, do=do)
    if len(frequency) < 5:
        raise UserError(f"{len(frequency)} points are too few", where=spec.file, do="a sweep needs at least 5 points")
    for column, values, low in ((columns["frequency"], frequency, True), (columns["amplitude"], amplitude, False)):
        bad = np.flatnonzero(values <= 0 if low else values < 0)
        if len(bad):
            what = f"{column.stem} {'must be positive' if low else 'cannot be negative'}"
            raise UserError(what, where=column.place(int(bad[0])), do="correct or delete the row")
    if np.ptp(frequency) == 0:
        raise UserError("all points have one frequency", where=spec.file, do="is the frequency column the right one?")
    if not isinstance(device, Oscillator) and np.max(amplitude) > 1e-3:
        raise UserError(
            f"an amplitude of {np.max(amplitude):.3g} m cannot be right for a platform",
            where=f'{spec.file}, column "{columns["amplitude"].header}"',
            do='state its unit, in the header or with units = { amplitude = "um" }',
        )
    phase = None
    if "phase" in columns:
        phase = _phase(columns["phase"], notes)
    up = _directions(spec, columns.get("direction"), frequency, level, notes)
    given_noise = None if spec.noise is None else _plausible_noise(spec, float(np.max(amplitude)))
    noise = None if given_noise is None else NoiseFloor(given_noise, method="given in the campaign")
    noise = noise or sweep_noise_floor(frequency, level, amplitude, up)
    quantity = spec.quantity
    sweep = Sweep(
        spec.file,
        frequency,
        level,
        amplitude,
        phase,
        up,
        quantity,
        drive_channel,
        response_channel,
        noise,
        spec.holdout,
        spec.load,
    )
    return sweep, notes


def _amplitude_unit(column: Column) -> tuple[Column, float]:
    """The column in its plain unit, and the factor from peak-to-peak or rms to amplitude."""
    if column.unit is None or find_unit(column.unit, rare=False) is not None:
        return column, 1.0
    unit, factor = peak_unit(column.unit)
    return replace(column, unit=unit), factor


def _frequency(column: Column, notes: list[str]) -> np.ndarray:
    channel = _channel(column, "Hz", notes, "frequency")
    angular = column.unit is not None and column.unit.replace(" ", "").lower().startswith(("rad", "krad"))
    return column.numbers() * channel.factor / (2 * math.pi if angular else 1.0)


def _phase(column: Column, notes: list[str]) -> np.ndarray:
    values = column.numbers()
    if column.unit is not None:
        return values * _channel(column, "rad", notes, "phase").factor
    degrees = bool(np.max(np.abs(values)) > 2 * math.pi + 0.1)
    notes.append(f"{column.file}: the phase states no unit; {'degrees are' if degrees else 'rad is'} assumed.")
    return values * (math.pi / 180 if degrees else 1.0)


_UP = ("up", "u", "forward", "rising", "increasing", "1", "+1", "1.0", "true", "upward", "upwards")
_DOWN = ("down", "d", "backward", "falling", "decreasing", "-1", "0", "-1.0", "0.0", "false", "downward", "downwards")


def _directions(
    spec: RecordSpec, column: Column | None, frequency: np.ndarray, level: np.ndarray, notes: list[str]
) -> np.ndarray:
    """(n,) whether the frequency was rising at each point."""
    if spec.direction in ("up", "down"):
        return np.full(len(frequency), spec.direction == "up")
    if column is not None:
        words = [str(cell).strip().strip('"').lower() for cell in column.cells]
        for row, word in enumerate(words):
            if word not in _UP + _DOWN:
                raise UserError(
                    f'"{word}" is no direction', where=column.place(row), do='write "up" or "down", or 1 and -1'
                )
        return np.array([word in _UP for word in words])
    step = np.diff(frequency)
    same = np.diff(level) == 0
    rising = np.where(
        np.append(same, False), np.append(step, 0.0), np.append(0.0, step)
    )  # look back at a segment's end
    up = rising >= 0
    both = bool(np.any(up) and not np.all(up))
    words = "in both directions" if both else ("upwards" if np.all(up) else "downwards")
    notes.append(f"{spec.file}: direction is not given; by the order of its rows the frequency was swept {words}.")
    return up
