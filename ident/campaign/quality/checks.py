"""Checks of the data alone. What makes a record unusable is a `UserError`; the rest is a sentence in the notes."""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np

from ...errors import UserError
from ...units import format_quantity
from ..device import NOMINAL_RESONANCE, Device, Oscillator
from ..drive import drive_rate
from ..record import LEAST
from ..tables.table import Column
from .clipping import CLIPPED, clipped_fraction

_LASTS = 0.97  # of a free motion's first quarter in its last: its quality would be 77 times its periods
MOST_JITTER = 0.2  # of an interval: what is sampled less evenly has no grid
_LONGEST_STEP = 1.6  # of the usual interval: what is longer is a gap
_UNEVEN = 0.3  # of the usual interval, by which the others may be off it
_BESIDE_GONE = 0.25  # of an interval, by which a sample of the grid may lie towards a row that says nothing
_BETWEEN = 0.01  # of a signal's rms, missed between uneven samples
_STILL_UNIFORM = 0.01  # of an interval: a sine of 20 samples a period is then read 0.3 % wrong at most


def check_length(n: int, file: str) -> None:
    """A `UserError` for a trace of fewer samples than any question needs."""
    if n < LEAST:
        raise UserError(f"{n} samples are too few", where=file, do=f"a record needs at least {LEAST} samples")


def uniform_time(column: Column, factor: float, notes: list[str]) -> np.ndarray:
    """(n,) the uniform grid that the time column means, s; a `UserError` where it means none.

    Printed times are rounded: deviations from a uniform grid that the printed digits explain are accepted.
    """
    printed = column.numbers()
    n = len(printed)
    check_length(n, column.file)
    steps = np.diff(printed)
    step = float(np.median(steps))
    resolution = _resolution(column)
    if not step > 0:
        step = float((printed[-1] - printed[0]) / (n - 1))
    slope, grid = _line_through(printed, step)
    off = np.abs(printed - grid)
    worst = float(np.max(off))
    if slope > 0 and worst <= 0.75 * resolution:  # rounding in print, and nothing else
        if worst > 0.05 * slope:
            what = f"printed times are rounded by up to {worst / slope:.0%} of the sampling interval"
            notes.append(f"{column.file}: {what}; a uniform grid is assumed.")
        return factor * grid
    _check_forwards(column, steps)
    _check_gaps(column, factor, steps, step, resolution)
    jitter = worst / slope  # of times that go forwards the line does, too
    even = float(np.max(steps)) < _LONGEST_STEP * step  # a clock that waits: off any grid, and no gap
    if jitter > MOST_JITTER and not even:
        do = "resample the record on uniform times (for example with scipy.interpolate.CubicSpline)"
        what = f"sampling is not uniform: a sample is {jitter:.0%} of an interval off the uniform grid"
        raise UserError(what, where=column.place(int(np.argmax(off))), do=do)
    if jitter > _STILL_UNIFORM:
        told = f"jitter by up to {jitter:.1%} of an interval"
        if jitter > MOST_JITTER:
            told = f"are {np.min(steps) / step:.0%} to {np.max(steps) / step:.0%} of the usual interval apart"
        notes.append(
            f"{column.file}: the sampling times {told}; the signals are "
            "interpolated on a uniform grid by a cubic spline through the samples."
        )
    if jitter > MOST_JITTER:  # the line through times that wander does not begin and end where they do
        return factor * np.linspace(printed[0], printed[-1], n)
    return factor * grid


def _line_through(printed: np.ndarray, step: float) -> tuple[float, np.ndarray]:
    """The slope of the line through printed times, and the line; by their first one where no `step` goes forwards."""
    index = np.arange(len(printed))
    if not step > 0:
        return step, printed[0] + step * index
    slope, origin = np.polyfit(index, printed - printed[0], 1)
    return slope, origin + printed[0] + slope * index


def _check_forwards(column: Column, steps: np.ndarray) -> None:
    """A `UserError` where time repeats or runs backwards."""
    back = np.flatnonzero(steps <= 0)
    if not len(back):
        return
    more = f" (and {len(back) - 1} more times)" if len(back) > 1 else ""
    word, do = "runs backwards", "sort the rows, or split the file where it starts again"
    if steps[back[0]] == 0:
        word, do = "repeats", "delete the repeated rows"
    raise UserError(f"time {word}{more}", where=column.place(int(back[0]) + 1), do=do)


def _check_gaps(column: Column, factor: float, steps: np.ndarray, step: float, resolution: float) -> None:
    """A `UserError` where some of the steps are gaps."""
    gaps = gaps_in(steps, step, 2 * resolution)
    if not len(gaps):
        return
    size = format_quantity(float(steps[gaps[0]]) * factor, "s")
    more = f" (and {len(gaps) - 1} more)" if len(gaps) > 1 else ""
    what = f"a gap of {size} in a record sampled every {step * factor:.6g} s{more}"
    do = "give the parts before and after as two records, or resample"
    raise UserError(what, where=column.place(int(gaps[0]) + 1), do=do)


def gaps_in(steps: np.ndarray, step: float, print_off: float = 0.0) -> np.ndarray:
    """Which of the (n − 1,) steps in time are gaps of a record that is sampled every `step` but for a few."""
    gaps = np.flatnonzero(steps > _LONGEST_STEP * step)
    others = np.delete(steps, gaps)
    few = len(gaps) < 0.05 * len(steps) + 2 and len(others) > 0
    return gaps if few and np.max(np.abs(others - step)) < _UNEVEN * step + print_off else gaps[:0]


def on_grid(
    column: Column, factor: float, time: np.ndarray, gone: np.ndarray, *signals: np.ndarray
) -> tuple[np.ndarray, ...]:
    """Which samples say nothing, and signals, all (n,), that were sampled at the printed times, on the uniform grid
    `time` (n,) s that they mean.

    Where print rounds the times more than the clock jitters, the samples are on the grid already. Times off any grid
    are read if a spline says what is between them: one through every other sample, whose intervals are twice as long,
    misses 16 times as much of the others. **Raises:** UserError where it does not.
    """
    printed = factor * column.numbers()
    worst, still = float(np.max(np.abs(printed - time))), _STILL_UNIFORM * (time[1] - time[0])
    if worst <= still or worst <= 0.75 * factor * _resolution(column):
        return gone, *signals
    from scipy.interpolate import CubicSpline  # here, because its import costs more than reading a campaign

    inside = np.clip(time, printed[0], printed[-1])
    if worst > MOST_JITTER * (time[1] - time[0]):
        for signal in signals:
            missed = (CubicSpline(printed[::2], signal[::2])(printed) - signal)[1:-1:2]
            if float(np.std(missed)) / 16 > _BETWEEN * float(np.std(signal)):
                do = "sample faster, or with a clock that keeps its interval"
                what = "the samples are uneven, and too few to say what is between them"
                raise UserError(what, where=column.file, do=do)
    beside_gone = np.interp(time, printed, gone.astype(float)) > _BESIDE_GONE
    return beside_gone, *(CubicSpline(printed, signal)(inside) for signal in signals)


def _resolution(column: Column) -> float:
    """What one unit in the last printed digit of the largest time is worth, in the unit of the file.

    The longest number tells how many digits are printed; printers that drop trailing zeros hide it in the others.
    """
    cells = column.printed or column.cells
    if isinstance(cells, np.ndarray):
        return float(np.max(np.abs(cells))) * float(np.finfo(cells.dtype).eps) if cells.dtype.kind == "f" else 0.0
    texts = [cell.strip().lower().partition("e")[0] for cell in cells[:: max(1, len(cells) // 500)]]
    digits = max(len(text.strip("+-").replace(column.decimal, "").lstrip("0")) for text in texts)
    largest = max(abs(float(cell.replace(",", "."))) for cell in (cells[0], cells[-1]))
    return 10.0 ** (math.floor(math.log10(largest)) + 1 - max(digits, 1)) if largest > 0 else 0.0


PLATFORM_RATE = 2 * NOMINAL_RESONANCE  # Hz: two samples to its period; with fewer none of its motion is recorded
PLATFORM_TRAVEL = 1e-3  # m, more than any micro platform moves: beyond it a unit is wrong, or the device is another


def travel_of(response: np.ndarray) -> float:
    """How far readings go from where they mostly are, in their unit."""
    return float(np.max(np.abs(response - np.median(response))))


_NO_PLATFORM = (
    '; for a thing that is no platform write device = { kind = "oscillator", output = "m" } in a campaign.toml'
)


def check_plausible(
    time: np.ndarray,
    drive: np.ndarray,
    response: np.ndarray,
    columns: Mapping[str, Column],
    device: Device,
    notes: list[str],
) -> None:
    """Numbers that no platform can have are a slip of the unit."""
    step = float(time[1] - time[0])
    file = columns["response"].file
    if isinstance(device, Oscillator):
        return
    size = travel_of(response)

    def error(what: str, role: str, example: str, more: str = "") -> UserError:
        where = f'{file}, column "{columns[role].header}"' if role in columns else file
        do = f'correct its unit, in the header or with units = {{ {role} = "{example}" }}{more}'
        return UserError(f"{what} cannot be right for a platform", where=where, do=do)

    if size > PLATFORM_TRAVEL:
        raise error(f"a displacement of {size:.3g} m", "response", "um", _NO_PLATFORM)
    if 0 < size < 1e-12:
        raise error(f"a displacement of only {size:.3g} m", "response", "um")
    peak = float(np.max(np.abs(drive)))
    if peak > 1e3:
        raise error(f"a drive of {peak:.3g} V", "drive", "V")
    if peak > 1.05 * device.max_voltage:
        notes.append(f"{file}: the drive reaches {peak:.3g} V, more than the {device.max_voltage:g} V of the device.")
    if 0 < peak < 1e-3:
        notes.append(f"{file}: the drive is below {format_quantity(peak, 'V')}; is its unit right?")
    if not 1e-9 < step < 1.0:
        raise error(f"a sample every {step:.3g} s", "time", "ms")
    if not 1e-7 < step < 1e-3:
        rate, usual = format_quantity(1 / step, "Hz"), f"a platform that vibrates near {NOMINAL_RESONANCE:g} Hz"
        notes.append(f"{file}: a sampling rate of {rate} is unusual for {usual}; is the unit of time right?")


def check_response(column: Column, response: np.ndarray, notes: list[str]) -> None:
    """A response that never changes is unusable; one that clips is noted."""
    if np.ptp(response) == 0:
        do = "is this the right column, and was the sensor on?"
        raise UserError("the response never changes", where=f'{column.file}, column "{column.header}"', do=do)
    levels = len(np.unique(response))
    if levels < 8:
        notes.append(f"{column.file}: the response has only {levels} different values; its resolution limits the fit.")
    clipped = clipped_fraction(response)
    if clipped > 0:
        what = f"{clipped:.1%} of the response sticks to its largest or smallest value; it seems clipped"
        then = "those samples have no weight in a fit" if clipped > CLIPPED else "they are counted all the same"
        notes.append(f"{column.file}: {what}; {then}.")


def check_drive(
    file: str, drive: np.ndarray, response: np.ndarray, start: str, notes: list[str], undriven: bool
) -> None:
    """A drive that never changes can only belong to a free decay; a start at rest begins quietly.

    `undriven`: the record has no drive column, which has been said.
    """
    if np.ptp(drive) == 0:
        if start in ("rest", "steady"):
            what = f'the drive never changes, so nothing happens after start = "{start}"'
            raise UserError(
                what, where=file, do='name the right drive column, or write start = "unknown" for a free decay'
            )
        if not undriven:
            notes.append(f"{file}: the drive is constant; the record is taken as a free decay.")
        quarter = len(response) // 4
        early, late = (float(np.std(part)) for part in (response[:quarter], response[-quarter:]))
        if late > _LASTS * early:
            notes.append(f"{file}: nothing drives it, and yet its motion does not die away; was the drive recorded?")
    varying = response - np.mean(response)
    copy = (drive - np.mean(drive)) * (np.std(response) / max(float(np.std(drive)), 1e-300))
    if np.ptp(drive) > 0 and min(np.max(np.abs(varying - copy)), np.max(np.abs(varying + copy))) < 1e-6 * np.std(
        response
    ):
        notes.append(f"{file}: drive and response are the same signal; was a column exported twice?")
    if start == "rest":
        first = abs(float(response[0] - np.median(response[:3])))
        size = float(np.std(response))
        offset = abs(float(np.mean(response[:2]) - np.mean(response)))
        switched = abs(float(drive[0] - np.mean(drive))) > 0.5 * float(np.std(drive))  # a step moves the mean itself
        if offset > 1.5 * size and first < size and not switched:
            notes.append(
                f'{file}: start = "rest", but the record does not begin near its mean; is it cut from a longer one?'
            )


def check_sampling(file: str, drive: np.ndarray, period: float | None, notes: list[str]) -> None:
    """Enough samples per period of the drive."""
    if np.ptp(drive) == 0:
        return
    per_period = 2 * math.pi / drive_rate(drive, period)
    if period is not None:
        per_period = min(per_period, period)
    if per_period < 3:
        what = f"{per_period:.1f} samples per period of the drive are too few"
        raise UserError(
            what, where=file, do="record with at least 8, better 20, samples per period; or is the drive noise?"
        )
    if per_period < 8:
        notes.append(f"{file}: only {per_period:.1f} samples per period of the drive; 20 or more are better.")
