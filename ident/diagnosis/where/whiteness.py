"""Whether a residual is noise: its correlation with itself and with the drive."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from scipy.special import chdtrc, chndtr

from ...campaign.noise.portmanteau import LAGS, SLIGHT, portmanteau


class Correlation(NamedTuple):
    """A correlation function with its test.

    **Arguments:** `lags` (k,): samples or seconds; `values` (k,); `band`: what noise stays within in 99 of 100 lags;
    `p_value`: probability that noise alone correlates so much over all lags together.
    """

    lags: np.ndarray
    values: np.ndarray
    band: float
    p_value: float


def whiteness(white: Sequence[np.ndarray], orders: Sequence[int]) -> Correlation:
    """Autocorrelation of white residuals of several records, and the portmanteau test.

    The Q of all records (see `portmanteau`) is χ² with one degree of freedom per lag, less the `orders` of the
    autoregressions that were estimated to whiten them. A slight mean correlation is not called colour; a mean that is
    left is, for noise has none.
    """
    q, freedom, pooled, n_all = 0.0, 0, np.zeros(LAGS), 0
    for e, order in zip(white, orders, strict=True):
        rho, own = portmanteau(e)
        q += own
        freedom += max(len(rho) - order, 1)
        pooled[: len(rho)] += len(e) * rho
        n_all += len(e)
    slight = n_all * SLIGHT**2  # one lag as large as that in every record
    p = 1.0 - float(chndtr(q, freedom, slight))
    return Correlation(np.arange(1, LAGS + 1), pooled / n_all, 2.58 / np.sqrt(n_all), p)


def drive_correlation(
    white: Sequence[np.ndarray], drives: Sequence[np.ndarray], steps: Sequence[float], lags: np.ndarray
) -> Correlation | None:
    """Cross-correlation of the residuals with the drive `lags` seconds before, and its test; None if no drive changes.

    The residual is regressed on the lagged drives; the χ² they explain counts as many degrees of freedom as they have
    independent directions (two for a sine). Correlation at negative lags: the drive follows the residual.
    """
    values, chi2, freedom, n_all = np.zeros(len(lags)), 0.0, 0, 0
    for e, drive, step in zip(white, drives, steps, strict=True):
        rows = lagged(drive - np.mean(drive), np.round(lags / step).astype(int))
        n = len(e)
        lengths = np.linalg.norm(rows, axis=1)
        if not np.all(lengths > 0):
            continue
        values += n * (rows @ e) / lengths / (float(np.linalg.norm(e)) or 1.0)
        rows = rows / lengths[:, None]
        powers, turn = np.linalg.eigh(rows @ rows.T)
        kept = powers > 1e-3 * powers[-1]
        chi2 += float(np.sum((turn[:, kept].T @ (rows @ e)) ** 2 / powers[kept]))
        freedom += int(kept.sum())
        n_all += n
    if not n_all:
        return None
    return Correlation(lags, values / n_all, 2.58 / np.sqrt(n_all), float(chdtrc(freedom, chi2)))


def lagged(signal: np.ndarray, shifts: np.ndarray) -> np.ndarray:
    """Copies of a signal (n,) delayed by so many samples, zero where there was none; (k, n)."""
    n = len(signal)
    rows = np.zeros((len(shifts), n))
    for row, shift in zip(rows, shifts, strict=True):
        if 0 <= shift < n:
            row[shift:] = signal[: n - shift]
        elif -n < shift < 0:
            row[:shift] = signal[-shift:]
    return rows
