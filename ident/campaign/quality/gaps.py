"""Samples that are no number: the response's are not counted; a drive is drawn across them where that is harmless."""

from __future__ import annotations

import numpy as np

from ..tables.table import Column
from .clipping import across_gaps

# Of the drive's rms: what is missed in the gaps, as a force that acts all along the record. An amplifier's gain is
# known as well; the response beside is not counted.
_HARMLESS = 0.01
_PLACES = 8  # where the same gaps are made, to see what the curve drawn across them is worth


def without_gaps(
    column: Column, signal: np.ndarray, notes: list[str], drive: bool = False, at: np.ndarray | None = None
) -> np.ndarray:
    """A signal (n,) with a smooth curve in place of NaN; `at`: its times, if known. **Raises:** UserError where
    too much of it is missing, or a curve across the same gaps elsewhere misses what a `drive` does there."""
    gone = np.isnan(signal)
    count, first = np.count_nonzero(gone), int(np.argmax(gone))
    filled = _crossed(signal, gone, at) if 2 * count < len(gone) else signal
    if 2 * count >= len(gone) or (drive and not _harmless(filled, gone, at)):
        column.numbers()  # raises, with the place of the first
    role = "drive" if drive else "response"
    many = f"{count} samples of the {role} are" if count > 1 else f"one sample of the {role} is"
    then = "a smooth curve takes their place" if drive else "left out of every fit"
    notes.append(f"{column.place(first)}: {many} missing, or no number; {then}.")
    return filled


def crossed_by_drive(column: Column, there: np.ndarray, at: np.ndarray | None = None) -> bool:
    """Whether a smooth curve says what a drive did where samples are not `there` (n,), of which the column has the
    others; `at`: times of all."""
    signal = np.full(len(there), np.nan)
    signal[there] = column.numbers(missing=True)
    gone = np.isnan(signal)  # numbers that are none among them
    return bool(2 * np.count_nonzero(gone) < len(gone)) and _harmless(_crossed(signal, gone, at), gone, at)


def _crossed(signal: np.ndarray, gone: np.ndarray, at: np.ndarray | None) -> np.ndarray:
    known, at = ~gone, np.arange(len(gone)) if at is None else at
    return across_gaps(np.where(gone, np.interp(at, at[known], signal[known]), signal), gone, at)


def missed_across(signal: np.ndarray, gone: np.ndarray, at: np.ndarray | None = None) -> float:
    """Root mean square of what curves across gaps like these, made where the signal is known, miss of it."""
    missed = np.concatenate(_misses(signal, gone, at))
    return float(np.sqrt(np.mean(missed**2))) if len(missed) else 0.0


def _harmless(filled: np.ndarray, gone: np.ndarray, at: np.ndarray | None) -> bool:
    missed = missed_across(filled, gone, at) * float(np.sqrt(np.mean(gone)))
    return not np.ptp(filled) or missed < _HARMLESS * float(np.std(filled))


def _misses(filled: np.ndarray, gone: np.ndarray, at: np.ndarray | None) -> list[np.ndarray]:
    """What curves across the same gaps, moved to several other places, miss of a signal; one array a place. None is
    moved nearer to an end than they are: there a curve has less to go by."""
    n, found, places = len(gone), [np.zeros(0)], np.flatnonzero(gone)
    end = int(min(places[0], n - 1 - places[-1], n // (_PLACES + 1))) if len(places) else 0
    for place in range(1, _PLACES + 1):
        made = np.roll(gone, place * n // (_PLACES + 1)) & ~gone
        made[:end] = made[n - end :] = False
        if np.any(made):
            found.append((_crossed(np.where(made, np.nan, filled), made, at) - filled)[made])
    return found
