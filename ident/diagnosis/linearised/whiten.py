"""Residuals and columns in units of white noise, record by record, with what is known to be a nuisance projected
out."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from scipy.linalg import solve_toeplitz

from ...campaign.apart import zero_curves
from ...campaign.noise.autoregression import predictors, variance_of
from ...campaign.noise.hum import FEWEST, mains_of, told_apart
from ...campaign.noise.recursive import convolved
from ...campaign.record import Trace

_ORDER = 12  # of an autoregression that whitens rows
_ROUNDING = 1e-12  # of a row
_DIED_OUT = 1e-12  # of an initial state's influence, before the first sample that counts


class Whitening(NamedTuple):
    """How one record is whitened: samples counted, prediction-error filter, scale, and local nuisance directions.

    **Arguments:** `counted`: slice of the record; `filter`: (p + 1,) FIR coefficients; `begin`: (p, p) what they are
    for the first samples, which have less before them to be predicted from; `scale`: of the white noise, m; `basis`:
    (n, q) orthonormal, already whitened: initial states, mains hum, a zero of its own; `masked`: (n,), if there are
    such, the samples that say nothing: their rows are zero.
    """

    counted: slice
    filter: np.ndarray
    begin: np.ndarray
    scale: float
    basis: np.ndarray
    masked: np.ndarray | None = None


def whitening_of(record: Trace, by_start: np.ndarray | None) -> Whitening:
    """Whitening of one record by its noise floor; `by_start` (2, n) if its initial state is fitted."""
    ar = np.asarray(record.noise.ar, float)
    taps, begin = np.concatenate([[1.0], -ar]), np.eye(len(ar))
    for row, (weights, variance) in zip(begin, predictors(ar), strict=False):
        row[: len(weights)] = -weights[::-1]
        row /= np.sqrt(variance)
    scale = record.noise.sigma / np.sqrt(variance_of(ar, 1.0))
    whitening = Whitening(slice(record.skip, len(record.time)), taps, begin, scale, np.zeros((0, 0)))
    if record.masked is not None:
        whitening = whitening._replace(masked=record.masked[whitening.counted])
    n, k = len(record.time), np.arange(len(record.time))
    rate = 2 * np.pi / record.period if record.period is not None and 3 * record.period < n else None  # else no gaps
    lines = 2 * np.pi * record.step * np.array(mains_of(record.noise))
    lines = lines[told_apart(lines, rate, n - record.skip, FEWEST)]
    local = [f(line * k) for line in lines for f in (np.cos, np.sin)]
    if by_start is not None:
        seen = [(row, float(np.max(np.abs(row[whitening.counted])))) for row in by_start]
        local += [row / size for row, size in seen if size > _DIED_OUT * float(np.max(np.abs(by_start)))]
    local += list(zero_curves(record))
    whitened = _filter(whitening, np.reshape(local, (-1, n)))
    u, s, _ = np.linalg.svd(whitened.T, full_matrices=False)
    return whitening._replace(basis=u[:, s > 1e-6 * np.max(s, initial=0.0)])


def whiten(whitening: Whitening, rows: np.ndarray) -> np.ndarray:
    """Rows (k, samples) of the whole record in units of white noise, local nuisance removed; (k, counted). What is
    nothing but nuisance leaves nothing, and no rounding."""
    white = _filter(whitening, rows)
    left = white - (white @ whitening.basis) @ whitening.basis.T
    largest = lambda some: np.max(np.abs(some), axis=1, initial=0.0)  # of motion without bound no square is a number
    left[largest(left) < _ROUNDING * largest(white)] = 0.0
    return left


def _filter(whitening: Whitening, rows: np.ndarray) -> np.ndarray:
    rows = rows[:, whitening.counted]
    white = rows
    if order := len(whitening.begin):
        white = convolved(whitening.filter, rows.T).T
        white[:, :order] = rows[:, :order] @ whitening.begin.T
    white = white / whitening.scale
    return white if whitening.masked is None else np.where(whitening.masked, 0.0, white)


def prediction_filter(rows: np.ndarray) -> np.ndarray:
    """Filter that whitens what it is given (Yule–Walker); rows (records, n) share one colour.

    Source: P. J. Brockwell, R. A. Davis, Time Series: Theory and Methods, 1991, §8.1.
    """
    n = rows.shape[1]
    lags = np.array([np.sum(rows[:, : n - k] * rows[:, k:]) for k in range(_ORDER + 1)])
    lags = lags / lags[0] if lags[0] > 0 else np.eye(1, _ORDER + 1)[0]
    lags[0] *= 1.0 + 1e-9
    return np.concatenate([[1.0], -solve_toeplitz(lags[:-1], lags[1:])])
