"""The level on which a free decay comes to rest: from there its displacements are counted, if no driven record shows
the same level."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from ..record import Record, Trace

_LITTLE = 0.1  # of what a drive varies by: as a mean it moves a device that far off its zero
_BEGUN, _BEFORE = 1e-4, 10  # of its largest: a drive has begun; samples before it that tell whether anything moves
_STILL = 8.0  # noise floors from the lowest to the highest of these: of a thousand samples of noise they are 6.5 apart
_CYCLES = 8  # in the record, of its strongest line: fewer do not average out under the window
_BLOCK, _FEWEST = 16, 8  # cycles in each of so many parts of a record, in which a mean that falls with the motion shows
_CLEAR = 4.0  # errors of a mean's fall with the motion: of eight parts chance makes so many in one record of 150
_DIED = 0.2  # of the square of the motion: where more is left at the end, the way to where it is zero is too far


def rest_level(response: np.ndarray) -> float | None:
    """The equilibrium of a ring-down, in the unit of the response (n,); None if the record shows too few cycles of it.

    The mean of the second half under a Hann window, which lets less than 1e-3 of an oscillation of four cycles pass. A
    force or a sensor without symmetry shifts the mean of a large motion, hence the later half; and where means of
    shorter parts clearly fall with the square of the motion, they are followed to where that is zero.

    Source: F. J. Harris, "On the use of windows for harmonic analysis", Proc. IEEE 66 (1978) 51, §V.
    """
    power = np.abs(np.fft.rfft(response - np.mean(response))) ** 2
    cycles = 1 + int(np.argmax(power[1:]))
    if cycles < _CYCLES:
        return None
    parts = np.array_split(response, cycles // _BLOCK) if cycles >= _FEWEST * _BLOCK else []
    followed = _without_motion(parts) if parts else None
    return _mean(response[len(response) // 2 :]) if followed is None else followed


def _mean(part: np.ndarray) -> float:
    return float(np.average(part, weights=np.hanning(len(part) + 2)[1:-1]))


def _without_motion(parts: Sequence[np.ndarray]) -> float | None:
    """The mean of parts of a decay where its motion would be zero; None if that is far from there, or the mean does not
    clearly change with it."""
    means = np.array([_mean(part) for part in parts])
    squares = np.array([_mean((part - mean) ** 2) for part, mean in zip(parts, means, strict=True)])
    rows = np.stack([np.ones(len(parts)), squares / np.max(squares)], axis=1)
    if np.min(squares) > _DIED * np.max(squares):
        return None
    found, *_ = np.linalg.lstsq(rows, means, rcond=None)
    scatter = np.sum((means - rows @ found) ** 2) / (len(parts) - 2)
    error = np.sqrt(scatter * np.linalg.pinv(rows.T @ rows)[1, 1])
    return float(found[0]) if abs(found[1]) > _CLEAR * error else None


def zero_of(record: Trace) -> float | None:
    """Where a driven record shows the zero of its sensor: where it starts, from rest, or about what it moves, if its
    drive has no mean that would move it there; None if nothing tells."""
    if record.start == "rest" and record.order < 2:  # an acceleration follows the drive at once
        return None if record.masked is not None and record.masked[0] else float(record.response[0])
    if abs(np.mean(record.drive)) > _LITTLE * np.std(record.drive):
        return None
    return float(np.mean(record.across(record.response)))


def level_before(record: Trace) -> float | None:
    """Where a response lies before the drive begins, if that is a while and nothing moves in it: the sensor's zero,
    whatever is said of the start; None if nothing tells."""
    drive, response = record.drive, record.response
    begins = int(np.argmax(np.abs(drive) > _BEGUN * np.max(np.abs(drive))))
    unknown = record.masked is not None and bool(np.any(record.masked[:begins]))
    if begins < _BEFORE or unknown or record.order > 1 or record.start == "steady":
        return None
    before = response[:begins]
    return float(np.mean(before)) if float(np.ptp(before)) < _STILL * record.noise.sigma else None


def counted_from_rest(records: Sequence[Record], notes: list[str]) -> list[Record]:
    """The records with the displacements of free decays counted from where they come to rest, which `notes` then say.

    Driven records beside them know the zero of their common sensor too: where theirs is nearer to the decay's level
    than zero is, it is one offset of all, which a model finds.
    """
    zeros = (zero_of(record) for record in records if isinstance(record, Trace) and record.driven)
    common = [zero for zero in zeros if zero is not None]
    found: list[Record] = []
    for record in records:
        level = rest_level(record.across(record.response)) if isinstance(record, Trace) and not record.driven else None
        if not isinstance(record, Trace) or level is None or (common and abs(level - np.median(common)) < abs(level)):
            found.append(record)
            continue
        shown = f"{level / record.response_channel.factor:.6g} {record.response_channel.unit}"
        told = f"displacements are counted from {shown}, the level on which the decay comes to rest."
        notes.append(f"{record.name}: {told}")
        found.append(replace(record, response=record.response - level))
    return found
