"""From a table of an amplitude-frequency curve to a record in SI units."""

from __future__ import annotations

import math
import re
from dataclasses import replace

import numpy as np

from ...errors import UserError
from ...units import NUMBER, find_unit, hertz_of, parse_quantity
from ..channel import channel_of, own_units, plausible_noise
from ..device import Device, Oscillator
from ..record import SAME_LEVEL, Channel, NoiseFloor, Sweep, same_level
from ..spec import HARMONICS, SWEEP_NAMES, RecordSpec, signal_units
from ..tables.amplitude_unit import TO_PEAK, AmplitudeUnit, split_convention
from ..tables.columns import Role, match_columns, sweep_roles
from ..tables.table import Column, Table
from .direction import directions, turned_by_jumps
from .form import curve_form, level_in
from .noise import sweep_noise
from .overtones import overtones_of, split_harmonics, with_overtone_noise
from .rate import measured_by, on_a_platform


def load_sweep(spec: RecordSpec, table: Table, device: Device) -> tuple[Sweep, list[str]]:
    """The sweep and the notes on it.

    **Raises:** UserError where the table leaves open what was measured, or holds what cannot have been.
    """
    notes: list[str] = []
    measures = measured_by(spec, device)
    (drive_unit, drive_dimension), (response_unit, response_dimension) = signal_units(device, measures)
    given = {SWEEP_NAMES.get(role, role): column for role, column in spec.columns.items()}
    own = {HARMONICS[role]: column for role, column in given.items() if role in HARMONICS}
    rest, harmonics = split_harmonics(table, own, spec.where)
    given = {role: column for role, column in given.items() if role not in HARMONICS}
    form = curve_form(rest, given)
    notes += form.notes[len(table.notes) :]
    given = {role: name for role, name in given.items() if role not in ("real", "imaginary")}
    roles = sweep_roles(drive_dimension or NUMBER, response_dimension or NUMBER, own_units(device, measures))
    told = {SWEEP_NAMES.get(role, role): unit for role, unit in spec.units.items()}
    of_harmonics = {name for order, c in harmonics.items() for name in (f"harmonic{order}", c.header, c.stem)}
    units = {name: unit for name, unit in told.items() if name not in of_harmonics}
    if spec.direction not in ("", "up", "down"):
        given["direction"] = spec.direction
    columns = match_columns(form, roles, given, units, where=spec.where)
    name = spec.file
    if spec.level is not None and "level" in columns:
        columns, name, rows = _at_level(spec, columns, roles, drive_unit)
        harmonics = {order: column.at(rows) for order, column in harmonics.items()}
    frequency = _frequency(columns["frequency"], notes)
    if len(frequency) < 5:
        raise UserError(f"{len(frequency)} points are too few", where=spec.file, do="a sweep needs at least 5 points")
    drive_channel, level = _level(spec, columns.get("level"), roles, drive_unit, len(frequency), form, notes)
    response_channel, amplitude = _amplitude(columns["amplitude"], roles, response_unit, level, device, notes)
    if not isinstance(device, Oscillator) and measures == "displacement":
        on_a_platform(f'{spec.file}, column "{columns["amplitude"].header}"', amplitude)
    if np.ptp(frequency) == 0:
        raise UserError("all points have one frequency", where=spec.file, do="is the frequency column the right one?")
    up = directions(spec, columns.get("direction"), frequency, level, notes)
    phase = None
    if "phase" in columns:
        phase = _phase(columns["phase"], frequency, level, up, amplitude, notes)
    up = turned_by_jumps(spec.file, frequency, level, amplitude, phase, up, notes)
    sweep = Sweep(
        name, frequency, level, amplitude, phase, up, spec.quantity, drive_channel, response_channel,
        NoiseFloor(0.0), spec.holdout, spec.load,
    )  # fmt: skip
    if harmonics and len(next(iter(harmonics.values())).cells) != len(frequency):
        what = "harmonics cannot be read where several curves stand side by side"
        raise UserError(what, where=spec.file, do="write one row for each level and direction")
    sweep = replace(sweep, overtones=overtones_of(harmonics, told, sweep))
    sweep = _timed(spec, sweep, _dwell(spec, sweep, columns.get("time")))
    sweep = with_overtone_noise(_with_noise(spec, _without_copies(sweep, notes)))
    return sweep, notes


def _at_level(
    spec: RecordSpec, columns: dict[str, Column], roles: tuple[Role, ...], unit: str
) -> tuple[dict[str, Column], str, np.ndarray]:
    """The columns with the rows of the level that the record names, of a table of several, a name for them, and these
    rows."""
    assert spec.level is not None
    meant, level = _levels(columns["level"], roles, [])
    rows = np.flatnonzero(np.abs(np.log(level / spec.level)) < math.log(SAME_LEVEL))
    if not len(rows):
        there = ", ".join(f"{np.median(level[group]):.4g}" for group in same_level(level))
        what = f"no row of {spec.file} has the level {spec.level:.4g}; its levels are {there}"
        raise UserError(what, where=spec.where, do="name one of these, or remove level")
    found = find_unit(meant.unit) if meant.unit else None
    name = f"{spec.file}, {spec.level / (found.factor if found else 1.0):.4g} {meant.unit or unit}"
    return {role: column.at(rows) for role, column in columns.items()}, name, rows


def _frequency(column: Column, notes: list[str]) -> np.ndarray:
    channel_of(column, "Hz", notes, "frequency")  # which says so where there is none
    frequency = column.numbers() * hertz_of(column.unit)
    bad = np.flatnonzero(frequency <= 0)
    if len(bad):
        where = column.place(int(bad[0]))
        raise UserError(f"{column.stem} must be positive", where=where, do="correct or delete the row")
    return frequency


def _level(
    spec: RecordSpec, column: Column | None, roles: tuple[Role, ...], unit: str, n: int, table: Table, notes: list[str]
) -> tuple[Channel, np.ndarray]:
    """The unit of the drive level, and (n,) its peaks in V."""
    if column is None:
        value = spec.level
        if value is None and (said := level_in(spec.path.stem)) and _is_in(split_convention(said)[0], unit):
            plain, how = split_convention(said)
            value = parse_quantity(plain) * TO_PEAK[how]
            notes.append(f'{spec.file}: the drive level is read from the name of the file (level = "{said}").')
        if value is None:
            what = f"no column is recognised as the drive level; the columns are {table.found}"
            do = 'say which with columns = { level = "…" }, or give one for all rows with level = "3 V"'
            raise UserError(what, where=table.name, do=do)
        return Channel(unit, 1.0), np.full(n, value)
    meant, level = _levels(column, roles, notes)
    channel = channel_of(replace(column, unit=meant.unit or None), unit, notes, "drive level")
    bad = np.flatnonzero(level <= 0)
    if len(bad):
        do = "correct it, or delete the row: without a drive there is no curve"
        raise UserError("a drive level must be positive", where=column.place(int(bad[0])), do=do)
    return channel, level


def _is_in(quantity: str, unit: str) -> bool:
    """Whether a quantity as a name states it, "2 mN", is one of those measured in a unit."""
    told, wanted = find_unit(quantity.split()[-1]), find_unit(unit)
    return told is not None and wanted is not None and told.dimension == wanted.dimension


def _levels(column: Column, roles: tuple[Role, ...], notes: list[str]) -> tuple[AmplitudeUnit, np.ndarray]:
    """How a column of levels is meant, and (n,) its peaks in SI."""
    meant, plain = _meaning(column, next(role for role in roles if role.name == "level"), notes)
    found = find_unit(plain.unit) if plain.unit else None
    return meant, meant.amplitudes(column.numbers()) * (found.factor if found else 1.0)


def _meaning(column: Column, role: Role, notes: list[str]) -> tuple[AmplitudeUnit, Column]:
    """How the numbers of a column are meant, by its unit and its name, and the column in its plain unit."""
    meant = role.amplitude(column.unit) if column.unit is not None else AmplitudeUnit("")
    assert meant is not None  # match_columns has asked
    if not meant.convention:
        said = split_convention(column.stem)[1] or split_convention(" " + column.doubtful)[1]
        if said and not meant.per:
            meant = replace(meant, convention=said, factor=meant.factor * TO_PEAK[said])
    if meant.convention in ("rms", "peak-to-peak"):
        notes.append(
            f'{column.file}: "{column.header}" holds {meant.convention} values; the peak of a sine is '
            f"{'√2 times' if meant.convention == 'rms' else 'half'} that."
        )
    return meant, replace(column, unit=meant.unit or None)


def _amplitude(
    column: Column, roles: tuple[Role, ...], unit: str, level: np.ndarray, device: Device, notes: list[str]
) -> tuple[Channel, np.ndarray]:
    """The unit of the response, and (n,) its peaks in SI, of an absolute amplitude or a ratio, in decibels or not."""
    role = next(role for role in roles if role.name == "amplitude")
    numbers = column.numbers()
    meant, plain = _meaning(column, role, notes)
    if not meant.decibel:
        _not_negative(column, numbers)
    elif np.ptp(numbers) < 0.01:
        what = f'"{column.header}" is in dB, but changes by {np.ptp(numbers):.2g} dB only: plain numbers?'
        raise UserError(what, where=column.file, do=f'write units = {{ amplitude = "{unit}" }} in the [[record]]')
    elif np.max(np.abs(numbers)) > 400:
        what = f'"{column.header}" is in dB, but reaches {numbers[np.argmax(np.abs(numbers))]:.4g}'
        raise UserError(what, where=column.file, do='state its unit with units = { amplitude = "…" }')
    channel = Channel(unit, 1.0) if meant.decibel and not meant.unit else channel_of(plain, unit, notes, "amplitude")
    amplitude = meant.amplitudes(numbers) * channel.factor
    if meant.decibel and not meant.unit:
        per = next(role for role in roles if role.name == "level").own_unit or signal_units(device)[0][0]
        notes.append(
            f'{column.file}: "{column.header}" is in dB of nothing stated; 0 dB is taken as 1 {unit} per '
            f'{per}, peak per peak (units = {{ amplitude = "dB {unit}" }} says it is no ratio).'
        )
        amplitude = amplitude * level
    elif meant.per:
        found = find_unit(meant.per)
        notes.append(f'{column.file}: "{column.header}" is a response per drive; it is multiplied by the drive level.')
        amplitude = amplitude * level / (found.factor if found else 1.0)
    if not np.max(amplitude) > 0:
        do = "is the amplitude column the right one?"
        raise UserError("all amplitudes are zero", where=f'{column.file}, column "{column.header}"', do=do)
    return channel, amplitude


def _not_negative(column: Column, numbers: np.ndarray) -> None:
    bad = np.flatnonzero(numbers < 0)
    if len(bad):
        do = "correct or delete the row"
        if len(bad) > 0.1 * len(numbers):
            do = (
                'decibels? write units = { amplitude = "dB …" }; parts? write columns = { real = "…", imaginary = "…" }'
            )
        raise UserError(f"{column.stem} cannot be negative", where=column.place(int(bad[0])), do=do)


def _phase(
    column: Column, frequency: np.ndarray, level: np.ndarray, up: np.ndarray, amplitude: np.ndarray, notes: list[str]
) -> np.ndarray:
    """(n,) rad by which the response leads the drive, unwrapped along each run."""
    values = column.numbers()
    if column.unit is not None:
        phase = values * channel_of(column, "rad", notes, "phase").factor
    else:
        degrees = bool(np.max(np.abs(values)) > 2 * math.pi + 0.1)
        notes.append(f"{column.file}: the phase states no unit; {'degrees are' if degrees else 'rad is'} assumed.")
        phase = values * (math.pi / 180 if degrees else 1.0)
    lag = bool(re.search(r"(?i)lag|delay", column.stem))
    phase = _unwrapped(-phase if lag else phase, frequency, level, up)
    if not lag and _turn(phase, frequency, level, up, amplitude) > math.pi / 4:
        notes.append(
            f'{column.file}: "{column.header}" rises through the resonance, so that it is a lag, and is read as one.'
        )
        return _unwrapped(-phase, frequency, level, up)
    return phase


def _runs(frequency: np.ndarray, level: np.ndarray, up: np.ndarray) -> list[np.ndarray]:
    """The rows of each run, in the order of rising frequency."""
    found = [rows[up[rows] == way] for rows in same_level(level) for way in (True, False)]
    return [rows[np.argsort(frequency[rows], kind="stable")] for rows in found if len(rows)]


def _unwrapped(phase: np.ndarray, frequency: np.ndarray, level: np.ndarray, up: np.ndarray) -> np.ndarray:
    found = phase.copy()
    for rows in _runs(frequency, level, up):
        run = np.unwrap(phase[rows])
        found[rows] = run - 2 * math.pi * np.round((run[0]) / (2 * math.pi))
    return found


def _turn(phase: np.ndarray, frequency: np.ndarray, level: np.ndarray, up: np.ndarray, amplitude: np.ndarray) -> float:
    """By how much the phase changes from below to above the largest amplitude, rad, median of the runs.

    A response that follows its cause lags the more, the higher the frequency, by π through a resonance.
    """
    turns = []
    for rows in _runs(frequency, level, up):
        large = rows[amplitude[rows] > 0.2 * np.max(amplitude[rows])]
        if len(large) > 2:
            turns.append(phase[large[-1]] - phase[large[0]])
    return float(np.median(turns)) if turns else 0.0


def _dwell(spec: RecordSpec, sweep: Sweep, column: Column | None) -> np.ndarray | None:
    """(n,) s between the previous point of the run and each point, where the table or the campaign tells."""
    if spec.dwell is not None:
        return np.full(len(sweep.frequency), spec.dwell)
    if spec.sweep_rate is None and column is None:
        return None
    time = sweep.frequency / spec.sweep_rate if spec.sweep_rate is not None else None
    if time is None:
        assert column is not None
        found = find_unit(column.unit) if column.unit else None
        time = column.numbers() * (found.factor if found else 1.0)
    dwell = np.zeros(len(time))
    for run in sweep.runs:
        step = np.abs(np.diff(time[run.rows]))
        if not len(step) or not np.all(step[1:] >= 0) or not np.any(step > 0):
            return None
        dwell[run.rows] = np.append(step[:1], step)
    return dwell


def _timed(spec: RecordSpec, sweep: Sweep, dwell: np.ndarray | None) -> Sweep:
    """The sweep with its times: between points, and over which the instrument averaged."""
    swept, averaging = spec.sweep_rate is not None, spec.averaging or 0.0
    if averaging and dwell is None:
        what = "averaging says over which part of its time a point was read, but nothing says how long that was"
        raise UserError(what, where=spec.where, do='add dwell = "0.2 s" or sweep_rate = "0.5 Hz/s", or remove it')
    if dwell is not None and not swept and averaging > float(np.min(dwell)):
        what = f"a point is averaged over {averaging:.3g} s, but a frequency was held for {np.min(dwell):.3g} s"
        raise UserError(what, where=spec.where, do="give an averaging that is no longer than that")
    return replace(sweep, dwell=dwell, swept=swept, averaging=averaging)


def _without_copies(sweep: Sweep, notes: list[str]) -> Sweep:
    """The sweep without rows that repeat another one in every number, and a note on frequencies measured twice."""
    phase = np.zeros(len(sweep.frequency)) if sweep.phase is None else sweep.phase
    table = np.column_stack([sweep.frequency, sweep.level, sweep.amplitude, phase, sweep.up])
    first = np.sort(np.unique(table, axis=0, return_index=True)[1])
    copies = len(table) - len(first)
    if copies:
        rows = "rows repeat" if copies > 1 else "row repeats"
        notes.append(f"{sweep.name}: {copies} {rows} another one in every number; each counts once.")
        arrays = {name: getattr(sweep, name)[first] for name in ("frequency", "level", "amplitude", "up")}
        extra = {name: None if getattr(sweep, name) is None else getattr(sweep, name)[first]
                 for name in ("phase", "dwell")}  # fmt: skip
        overtones = tuple(one.only(first) for one in sweep.overtones)
        sweep = replace(sweep, **arrays, **extra, overtones=overtones)
    twice = sum(len(run.rows) - len(np.unique(sweep.frequency[run.rows])) for run in sweep.runs)
    if twice:
        points = "points stand" if twice > 1 else "point stands"
        apart = f"which differ by up to {100 * max(_repeats_apart(sweep)):.2g} % of the peak of the run"
        notes.append(
            f"{sweep.name}: {twice} {points} at a frequency that its run has already; they count as repeats, {apart}."
        )
    return sweep


def _repeats_apart(sweep: Sweep) -> list[float]:
    """By how much amplitudes of a run at one frequency differ at most, of its peak; of each run."""
    found = []
    for run in sweep.runs:
        amplitude, group = sweep.amplitude[run.rows], np.unique(sweep.frequency[run.rows], return_inverse=True)[1]
        low, high = np.full(group.max() + 1, np.inf), np.full(group.max() + 1, -np.inf)
        np.minimum.at(low, group, amplitude)
        np.maximum.at(high, group, amplitude)
        found.append(float(np.max(high - low) / max(float(np.max(amplitude)), 1e-300)))
    return found


def _with_noise(spec: RecordSpec, sweep: Sweep) -> Sweep:
    if spec.noise is None:
        return sweep_noise(sweep)
    estimated = sweep_noise(sweep) if sweep.phase is not None else sweep
    resolution = 1e-6 * float(np.max(sweep.amplitude))  # "0.5 %" alone leaves no floor under a zero
    sigma = plausible_noise(spec, float(np.max(sweep.amplitude))) if spec.noise else resolution
    floor = NoiseFloor(sigma, method="given in the campaign")
    return replace(estimated, noise=floor, relative_noise=spec.relative_noise)
