"""The error of a model on records, in the records' unit and in units of their noise floors."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from ..campaign.record import Trace

GOOD = 1.1
"""Error over noise up to which the noise floor is reached, and error bars mean something: a floor is itself known to
some ten per cent."""


class RecordScore(NamedTuple):
    """Error on one record: `rmse` and `noise_rmse` in SI, `error_over_noise` = rms of (measured − model)/σ; `signal`,
    the standard deviation of what was measured, SI."""

    name: str
    holdout: bool
    n: int
    rmse: float
    noise_rmse: float
    error_over_noise: float
    signal: float

    @property
    def error_over_signal(self) -> float:
        """The rms error as a fraction of the signal: 1 is as good as predicting a constant."""
        return self.rmse / self.signal


class Score(NamedTuple):
    """Error on several records together; the fields of `RecordScore`, samples of all records counted alike."""

    n: int
    rmse: float
    noise_rmse: float
    error_over_noise: float
    signal: float

    @property
    def error_over_signal(self) -> float:
        """The rms error as a fraction of the signal: 1 is as good as predicting a constant in each record."""
        return self.rmse / self.signal

    @property
    def chi2(self) -> float:
        """Σ ((measured − model)/σ)²."""
        return self.n * self.error_over_noise**2


def score_record(record: Trace, reading: np.ndarray) -> RecordScore:
    """Judge a model's `reading` (n,) of a record over its counted samples."""
    difference = (record.response - reading)[record.counted]
    with np.errstate(over="ignore", invalid="ignore"):  # a motion without bound is no number, and said to be none
        rmse = float(np.sqrt(np.mean(difference**2)))
    sigma = record.noise.sigma
    return RecordScore(record.name, record.holdout, len(difference), rmse, sigma, rmse / sigma, _signal(record))


def _signal(record: Trace) -> float:
    """Standard deviation of the counted samples of a record, SI."""
    return max(float(np.std(record.response[record.counted])), 1e-300)


def combine(scores: Sequence[RecordScore]) -> Score | None:
    """Pool records; None if there are none."""
    if not scores:
        return None
    n = np.array([s.n for s in scores], float)
    pool = lambda name: float(np.sqrt(np.sum(n * np.array([getattr(s, name) for s in scores]) ** 2) / np.sum(n)))
    return Score(int(np.sum(n)), pool("rmse"), pool("noise_rmse"), pool("error_over_noise"), pool("signal"))
