"""Further linear modes: how many the records show, and where.

Modes of a linear structure superpose: reading = Σ x_k, each with ẍ_k + (ω_k/Q_k) ẋ_k + ω_k² x_k = g_k u. Gains, level
and free motions enter linearly and are eliminated (variable projection); frequencies and qualities are searched, one
mode after the other, each from the best point of a grid beside those that are there already.

A nonlinear device may be mimicked by modes of which each serves one record. So modes are judged on records, or halves
of a record, that were left out: only what they predict there counts, and they are taken for linear physics only if they
predict the greater part of what one mode leaves. How a record began is no prediction: one mode is given the free
motions of the others too, and all a constant, or a slow mode would stand for a zero that is off. Of decays, which are
how they began and nothing else, frequencies and qualities are judged alone. What explains less is
weighed later, against the effects. Of 26 oscillators with one of 13 effects none was predicted better by more than a
tenth; of two with a second mode the rest fell below a tenth (`experiments/many_modes.py`).

Source: D. J. Ewins, Modal Testing, 2000, ch. 2 and 4; G. H. Golub, V. Pereyra, SIAM J. Numer. Anal. 10 (1973) 413.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from scipy import optimize

from ...campaign.campaign import MOST_MODES
from .free_modes import amplitudes, next_line
from .guess import GRID_STEP, LEAST_QUALITY
from .stretches import Stretch, answered, free_motion, oscillator_filter

_SAMPLES = 24_000  # that compare modes
_QUALITIES = (8.0, 40.0)  # of a further mode, at each frequency of the grid
_FOLDS = 4  # groups of records, each predicted by the others
_SLOPE = 1e-4  # step of ln f and ln Q by which slopes are taken
_CLOSER = 1e-3  # of the misfit: a search goes on while its steps gain as much
_MOST_QUALITY = 1e4


class Mode(NamedTuple):
    """`frequency` (Hz), `quality`, and `gain` ((m/s²)/V) of one mode."""

    frequency: float
    quality: float
    gain: float


class Modes(NamedTuple):
    """The modes, that which moves most first, for effects act in that; `constant` (SI), 0 without one; `left`: rms of
    what they leave over that of the signal; `predicted`, the same on samples that were left out of the search, a
    constant allowed, and `alone`, the free motions of the further modes without their gains."""

    modes: tuple[Mode, ...]
    constant: float
    left: float
    predicted: float
    alone: float


def find_modes(
    stretches: Sequence[Stretch],
    first: tuple[float, float],
    level: bool,
    told: int | None = None,
    most: int = MOST_MODES,
) -> list[Modes]:
    """The best model of one mode, of two, … as long as records that were left out are predicted better.

    **Arguments:** `first`: frequency (Hz) and quality of the one mode; `level`: whether the model has a constant (the
    search always has); `told`: how many modes there are, whatever they predict; `most`: how many may be looked for.
    """
    stretches = _some(stretches)
    folds = _folds(stretches)
    points = np.log([first])
    driven = any(stretch.driven for stretch in stretches)
    found = [_described(stretches, points, level, folds)]
    while len(points) < (told or most):
        more = _next(stretches, points) if driven else next_line(stretches, points)
        if more is None:
            break
        points = _searched(stretches, np.vstack([points, more]))
        one = _described(stretches, points, level, folds)
        if told is None and (_overlap(one.modes) or not one.predicted < found[-1].predicted):
            break
        found.append(one)
    return found


def _overlap(modes: Sequence[Mode]) -> bool:
    """Whether two modes are nearer to each other than half the sum of their half-power bandwidths: such a pair is how a
    single resonance looks that moves."""
    return any(
        abs(a.frequency - b.frequency) < (a.frequency / a.quality + b.frequency / b.quality) / 2
        for a, b in itertools.combinations(modes, 2)
    )


def _some(stretches: Sequence[Stretch]) -> list[Stretch]:
    every = max(math.ceil(sum(len(p.response) for p in stretches) / _SAMPLES), 1)
    return list(stretches[::every])


def _folds(stretches: Sequence[Stretch]) -> list[list[np.ndarray]]:
    """Samples that are left out together, per stretch (n,) of bool: records in turn, or halves of a single one."""
    if len(stretches) == 1:
        n = len(stretches[0].response)
        return [[np.arange(n) < n // 2], [np.arange(n) >= n // 2]]
    count = min(len(stretches), _FOLDS)
    return [[np.full(len(p.response), i % count == k) for i, p in enumerate(stretches)] for k in range(count)]


def _columns(stretch: Stretch, points: np.ndarray, level: bool) -> tuple[np.ndarray, np.ndarray]:
    """What gains and constant do to a reading, (n, modes (+ 1)), and a basis of its free motions, (n, m)."""
    values = np.exp(points)
    filters = [lambda step, f=f, q=q: oscillator_filter(f, q, step, stretch.order, stretch.edge) for f, q in values]
    columns = [answered(stretch, one, stretch.push) / stretch.size for one in filters]
    columns += [np.ones_like(stretch.response) / stretch.size] if level else []
    if stretch.rest:
        return np.stack(columns, axis=1), np.empty((len(stretch.response), 0))
    free = np.hstack([free_motion(stretch, f, q) for f, q in values])
    return np.stack(columns, axis=1), np.linalg.qr(free)[0]


def _rows(
    stretches: Sequence[Stretch], points: np.ndarray, level: bool, used: Sequence[np.ndarray] | None = None
) -> tuple[np.ndarray, np.ndarray]:
    """What gains and constant do to the readings that are `used`, (n, modes (+ 1)), and the readings, (n,), both beside
    the free motions."""
    rows = []
    for i, stretch in enumerate(stretches):
        columns, basis = _columns(stretch, points, level)
        both = np.column_stack([columns, stretch.response])
        if used is not None:
            both, basis = both[used[i]], basis[used[i]]
            basis = np.linalg.qr(basis)[0] if len(basis) else basis
        rows.append(both - basis @ (basis.T @ both))
    stacked = np.concatenate(rows)
    return stacked[:, :-1], stacked[:, -1]


def solved(rows: np.ndarray, target: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Gains (and constant) by linear least squares, and what they leave."""
    lengths = np.maximum(np.linalg.norm(rows, axis=0), 1e-300)
    found = np.linalg.lstsq(rows / lengths, target, rcond=1e-9)[0] / lengths
    return found, target - rows @ found


def _next(stretches: Sequence[Stretch], points: np.ndarray) -> np.ndarray:
    """ln f and ln Q of the mode that explains the most beside those that are there, whose own may move a little."""
    beside = []
    for i, j in np.ndindex(points.shape):
        moved = points.copy()
        moved[i, j] += _SLOPE
        beside.append(_rows(stretches, moved, True)[0][:, i])
    rows, target = _rows(stretches, points, True)
    slopes = (np.stack(beside, axis=1) - np.repeat(rows[:, : len(points)], 2, axis=1)) / _SLOPE
    basis = np.linalg.qr(np.column_stack([rows, slopes]) / np.linalg.norm(np.column_stack([rows, slopes]), axis=0))[0]
    left = target - basis @ (basis.T @ target)
    lowest = min(2.0 / (p.step * len(p.response)) for p in stretches)
    highest = max(0.4 / p.step for p in stretches)
    best, chosen = -1.0, points[0]
    for f, q in itertools.product(np.exp(np.arange(math.log(lowest), math.log(highest), GRID_STEP)), _QUALITIES):
        column = _rows(stretches, np.log([[f, q]]), False)[0][:, 0]
        column = column - basis @ (basis.T @ column)
        worth = float(column @ left) ** 2 / max(float(column @ column), 1e-300)
        if worth > best:
            best, chosen = worth, np.log([f, q])
    return chosen


def _searched(stretches: Sequence[Stretch], points: np.ndarray, used: Sequence[np.ndarray] | None = None) -> np.ndarray:
    """The frequencies and qualities that leave the least, from a start."""
    misfit = lambda x: solved(*_rows(stretches, x.reshape(points.shape), True, used))[1]
    low = np.full(points.shape, math.log(LEAST_QUALITY))
    high = np.full(points.shape, math.log(_MOST_QUALITY))
    low[:, 0] = math.log(min(0.5 / (p.step * len(p.response)) for p in stretches))
    high[:, 0] = math.log(max(0.5 / p.step for p in stretches))
    start = np.clip(points, low + 1e-9, high - 1e-9)
    bounds = (low.ravel(), high.ravel())
    found = optimize.least_squares(
        misfit, start.ravel(), bounds=bounds, x_scale=0.1, diff_step=_SLOPE, ftol=_CLOSER, max_nfev=30
    )
    return found.x.reshape(points.shape)


def _predicted(
    stretches: Sequence[Stretch], points: np.ndarray, folds: Sequence[Sequence[np.ndarray]]
) -> tuple[float, float]:
    """rms of what modes found without some samples leave of these, over that of the signal; and the same if the further
    modes have no gain."""
    left, power = np.zeros(2), sum(stretch.power for stretch in stretches)
    for out in folds:
        kept = [~mask for mask in out]
        there = _searched(stretches, points, kept)
        (rows, target), (others, judged) = _rows(stretches, there, True, kept), _rows(stretches, there, True, out)
        for i, used in enumerate((slice(None), [0, -1])):
            gains, _ = solved(rows[:, used], target)
            left[i] += np.sum((judged - others[:, used] @ gains) ** 2)
    predicted, alone = np.sqrt(left / power)
    return float(predicted), float(alone)


def _described(
    stretches: Sequence[Stretch], points: np.ndarray, level: bool, folds: Sequence[Sequence[np.ndarray]]
) -> Modes:
    rows, target = _rows(stretches, points, level)
    found, left = solved(rows, target)
    modes = [Mode(math.exp(f), math.exp(q), float(gain)) for (f, q), gain in zip(points, found, strict=False)]
    sizes = np.concatenate([np.full(len(stretch.response), stretch.size) for stretch in stretches])[:, None]
    order = np.argsort(-np.linalg.norm(sizes * rows[:, : len(points)] * found[: len(points)], axis=0))
    if not any(stretch.driven for stretch in stretches):
        begun = amplitudes(stretches, points)  # which it has in the place of a travel
        modes = [mode._replace(gain=a * (2 * math.pi * mode.frequency) ** 2 / (2 * math.pi * mode.frequency)
                               ** stretches[0].order) for mode, a in zip(modes, begun, strict=True)]  # fmt: skip
        order = np.argsort(-begun)
    constant = float(found[-1]) if level else 0.0
    left = math.sqrt(float(left @ left) / sum(stretch.power for stretch in stretches))
    return Modes(tuple(modes[i] for i in order), constant, left, *_predicted(stretches, points, folds))
