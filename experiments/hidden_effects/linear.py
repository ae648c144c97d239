"""The best linear oscillator for a set of records: what an effect must defeat to be seen at all."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numba import njit
from scipy.optimize import least_squares


@dataclass(frozen=True, eq=False)
class Sampled:
    """One record for the linear fit, dimensionless.

    `e`: (2·(n−1)·substeps + 1,) drive at half steps; `y`: (n,) response; `h`: step, `substeps` of which make a
    sample; `rest`: starts from rest.
    """

    e: np.ndarray
    y: np.ndarray
    h: float
    substeps: int
    rest: bool


@njit
def linear_march(e, h, substeps, stiffness, damping):
    """Response of z̈ + damping ż + stiffness z = e from rest, at every sample."""
    n = (e.size - 1) // (2 * substeps) + 1
    out = np.zeros(n)
    z = v = 0.0
    i = 0
    for k in range(1, n):
        for _ in range(substeps):
            a1 = e[i] - damping * v - stiffness * z
            v2 = v + 0.5 * h * a1
            a2 = e[i + 1] - damping * v2 - stiffness * (z + 0.5 * h * v)
            v3 = v + 0.5 * h * a2
            a3 = e[i + 1] - damping * v3 - stiffness * (z + 0.5 * h * v2)
            v4 = v + h * a3
            a4 = e[i + 2] - damping * v4 - stiffness * (z + h * v3)
            z += h / 6.0 * (v + 2.0 * v2 + 2.0 * v3 + v4)
            v += h / 6.0 * (a1 + 2.0 * a2 + 2.0 * a3 + a4)
            i += 2
        out[k] = z
    return out


def misfit(records: list[Sampled]) -> tuple[float, np.ndarray]:
    """Root mean square over the records of (rms misfit of the best linear oscillator / rms of the response).

    Natural frequency and quality are searched; gain and unknown initial states enter linearly and are eliminated.
    Returns the misfit and (ω0, Q) in the units of the records.
    """
    if not all(np.all(np.isfinite(r.y)) for r in records):
        return np.inf, np.array([1.0, 30.0])
    scales = [float(np.std(r.y)) * np.sqrt(len(r.y)) for r in records]

    def residuals(x: np.ndarray) -> np.ndarray:
        w, q = np.exp(x)
        stiffness, damping = w * w, w / q
        parts, targets = [], []
        for r, scale in zip(records, scales, strict=True):
            forced = linear_march(r.e, r.h, r.substeps, stiffness, damping) / scale
            target = r.y / scale
            if not r.rest:  # a free decay of either phase may ride on it
                t = np.arange(len(r.y)) * r.h * r.substeps
                decay, turn = np.exp(-damping * t / 2), np.sqrt(max(stiffness - damping**2 / 4, 1e-6)) * t
                basis, _ = np.linalg.qr(np.stack([decay * np.cos(turn), decay * np.sin(turn)], axis=1))
                forced, target = forced - basis @ (basis.T @ forced), target - basis @ (basis.T @ target)
            parts.append(forced)
            targets.append(target)
        column, target = np.concatenate(parts), np.concatenate(targets)
        return target - column * (column @ target) / (column @ column)

    found = least_squares(residuals, np.log([1.0, 35.0]), method="lm", xtol=1e-6, ftol=1e-6, max_nfev=60)
    return float(np.sqrt(2 * found.cost / len(records))), np.exp(found.x)
