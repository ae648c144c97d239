"""The fundamental of a periodic drive, on which a response can be folded."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from .record import Trace

_FOLDS = 0.8  # share of the drive's variance in its fundamental above which it rules (a square wave has 0.81)


class DriveSine(NamedTuple):
    """The fundamental of a periodic drive: V = `mean` + `amplitude` sin(2π t/T + `phase`) at sample k, t = k steps.

    `period` in samples; `share` of the drive's variance that it explains.
    """

    period: float
    amplitude: float
    phase: float
    mean: float
    share: float

    def angle(self, samples: np.ndarray) -> np.ndarray:
        """Drive phase at sample numbers, rad."""
        return 2 * np.pi / self.period * samples + self.phase


def drive_sine(record: Trace) -> DriveSine | None:
    """The fundamental of the drive, or None if the drive is not periodic or not ruled by it."""
    if record.period is None or len(record.drive) < 2 * record.period:
        return None
    period = float(record.period)
    whole = int(int(len(record.drive) / period) * period)
    drive = record.drive[:whole]
    angle = 2 * np.pi / period * np.arange(whole)
    basis = np.column_stack([np.ones(whole), np.sin(angle), np.cos(angle)])
    mean, a, b = np.linalg.solve(basis.T @ basis, basis.T @ drive)
    amplitude, variance = float(np.hypot(a, b)), float(np.var(drive))
    if variance == 0.0:
        return None
    share = amplitude**2 / 2 / variance
    return DriveSine(period, amplitude, float(np.arctan2(b, a)), float(mean), share) if share > _FOLDS else None
