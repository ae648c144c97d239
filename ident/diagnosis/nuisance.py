"""What may be wrong with a record as a whole, each told by one number: delay, gain, sign, drift.

A record (n,) is compared with what the model predicts for it, (n,), once the number that suits it best is in.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from scipy.interpolate import CubicSpline
from scipy.optimize import minimize_scalar

from ..campaign.suspect import Kind


class Nuisance(NamedTuple):
    """An explanation: its kind, its number and unit, and the rms of what it leaves, in noise floors."""

    kind: Kind
    size: float
    unit: str
    error: float


def rms(misfit: np.ndarray, sigma: float) -> float:
    """Root mean square of a misfit, in noise floors."""
    return float(np.sqrt(np.mean(misfit**2)) / sigma)


def nuisances(measured: np.ndarray, predicted: np.ndarray, sigma: float, skip: int = 0) -> list[Nuisance]:
    """Every explanation of a record by one number, best first."""
    y, p = measured[skip:], predicted[skip:]
    delay = _delay(measured, predicted, sigma, skip, 0, len(measured))
    found = [_gain(y, p, sigma), delay, _drift(y, p, sigma), _dropped(measured, predicted, sigma, skip)]
    if found[0].size < 0:
        found[0] = found[0]._replace(kind="sign")
    return sorted(found, key=lambda one: one.error)


def _gain(y: np.ndarray, p: np.ndarray, sigma: float) -> Nuisance:
    """The response is g times what it should be; of a sign that is wrong g is near −1."""
    gain = float(p @ y) / max(float(p @ p), 1e-300)
    return Nuisance("gain", gain, "1", rms(y - gain * p, sigma))


def _delay(measured: np.ndarray, predicted: np.ndarray, sigma: float, skip: int, first: int, last: int) -> Nuisance:
    """The samples from `first` to `last` come d samples late (negative: early), d up to a tenth of the record."""
    n = len(measured)
    most = max(2, n // 10)
    index = np.arange(n, dtype=float)
    curve = CubicSpline(index, predicted, bc_type="natural")
    counted = slice(max(skip, most, first), min(n - most, last))

    def mismatch(delay: int) -> float:
        return float(np.sum((measured[counted] - np.roll(predicted, delay)[counted]) ** 2))

    def error(delay: float) -> float:
        return rms(measured[counted] - curve(index[counted] - delay), sigma)

    whole = np.array([mismatch(delay) for delay in range(-most, most + 1)])
    dips = [k for k in range(1, len(whole) - 1) if whole[k] <= min(whole[k - 1], whole[k + 1])] or [int(whole.argmin())]
    found = []
    for k in sorted(dips, key=lambda k: whole[k])[:4]:  # of a sine they lie a period apart, and only the rest differs
        best: Any = minimize_scalar(error, bounds=(k - most - 1, k - most + 1), method="bounded")
        found.append(Nuisance("delay", float(best.x), "samples", float(best.fun)))
    return min(found, key=lambda one: one.error)


def _dropped(measured: np.ndarray, predicted: np.ndarray, sigma: float, skip: int) -> Nuisance:
    """Samples are missing on the way: the first third is in time, the last third is not."""
    n = len(measured)
    early = rms((measured - predicted)[skip : max(n // 3, skip + 10)], sigma)
    late = _delay(measured, predicted, sigma, skip, 2 * n // 3, n)
    return Nuisance("delay", late.size, "samples from some sample on", max(early, late.error))


def _drift(y: np.ndarray, p: np.ndarray, sigma: float) -> Nuisance:
    """The response moves away along a parabola of time; its size is the change in noise floors.

    A parabola that is more of a level than of a change is no drift: an offset is something that a device may have.
    """
    t = np.linspace(-1.0, 1.0, len(y))
    basis = np.column_stack([np.ones_like(t), t, t**2])
    curve = basis @ np.linalg.lstsq(basis, y - p, rcond=None)[0]
    moves = np.ptp(curve) > abs(np.mean(curve))
    return Nuisance(
        "drift", float(np.ptp(curve)) / sigma, "noise floors", rms(y - p - curve, sigma) if moves else np.inf
    )
