"""Samples that stick to the limit of a range: they say that the response was beyond it, and not where."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

CLIPPED = 1e-3
"""Share of clipped samples from which on a record is suspect; fewer may be a coarse converter's."""

_BESIDE = 6  # samples at least, on each side of a gap, that say how the curve crosses it
_DEGREE = 4  # of that curve
_MOST = 20  # runs that are looked at


def clipped_samples(signal: np.ndarray) -> np.ndarray:
    """(n,) whether a sample sticks to the largest or smallest value, as a saturated amplifier or converter leaves it.

    A limit counts if it is far more crowded than the values next to it (the top of a coarsely quantised sine is a few
    samples wide, but so are its neighbours), and if beyond one of its runs of three or more equal samples the curve
    through what lies beside that run goes: once is enough, as a transient overshoots, and a plateau is no limit.
    """
    stuck = np.zeros(len(signal), dtype=bool)
    levels, counts = np.unique(signal, return_counts=True)
    if len(levels) < 8:
        return stuck
    quantum = float(np.median(np.diff(levels)))
    for limit, own, near in ((levels[-1], counts[-1], counts[-6:-1]), (levels[0], counts[0], counts[1:6])):
        if own <= 4 * np.max(near):
            continue
        at_limit = signal == limit
        runs = [(a, b) for a, b in _runs(at_limit) if b - a >= 3 and a > 0 and b < len(signal)]
        if any(_beyond(signal, at_limit, *run) > 2 * quantum for run in runs[:_MOST]):
            stuck |= at_limit
    return stuck


def _beyond(signal: np.ndarray, masked: np.ndarray, first: int, stop: int) -> float:
    """How far the curve through what lies beside a run of equal samples leaves the range of all samples, less three
    times what it misses there. Rounding hides at most one step of a converter."""
    beside = max(_BESIDE, stop - first)
    near = np.arange(max(first - beside, 0), min(stop + beside, len(signal)))
    known = near[~masked[near]]
    if len(known) <= 2 * _DEGREE or not known[0] < first <= stop <= known[-1]:
        return 0.0
    curve = np.polynomial.Polynomial.fit(known, signal[known], _DEGREE)
    missed, across = float(np.std(signal[known] - curve(known))), curve(np.arange(first, stop))
    return float(max(np.max(across) - np.max(signal), np.min(signal) - np.min(across))) - 3 * missed


def _runs(chosen: np.ndarray) -> Iterator[tuple[int, int]]:
    """First and stop of each run of chosen samples."""
    edges = np.flatnonzero(np.diff(np.concatenate([[0], chosen.astype(int), [0]])))
    return zip(edges[::2], edges[1::2], strict=True)


def clipped_mask(signal: np.ndarray) -> np.ndarray | None:
    """The clipped samples, if there are more than a few: they say that the response was beyond the limit, not where."""
    stuck = clipped_samples(signal)
    return stuck if np.mean(stuck) > CLIPPED else None


def clipped_fraction(signal: np.ndarray) -> float:
    """Share of samples that are clipped; see `clipped_samples`."""
    return float(np.mean(clipped_samples(signal)))


def across_gaps(signal: np.ndarray, masked: np.ndarray, at: np.ndarray | None = None) -> np.ndarray:
    """The signal (n,) with each run of masked samples replaced by the polynomial through what lies on both sides; `at`:
    where its samples lie, if that is not one after the other."""
    filled, n = np.array(signal, dtype=float), len(signal)
    at = np.arange(n) if at is None else at
    for first, stop in _runs(masked):
        beside = max(_BESIDE, stop - first)
        near = np.arange(max(first - beside, 0), min(stop + beside, n))
        known = near[~masked[near]]
        if len(known) > 2 * _DEGREE and known[0] < first and known[-1] >= stop:
            line = np.polynomial.Polynomial.fit(at[known], signal[known], _DEGREE)
            filled[first:stop] = line(at[first:stop])
    return filled
