"""Measurement noise: white, autoregressive, mains hum."""

from __future__ import annotations

import numpy as np
from scipy.signal import lfilter


def white(rng: np.random.Generator, n: int, deviation: float) -> np.ndarray:
    """White Gaussian noise of standard deviation `deviation`, (n,)."""
    return deviation * rng.standard_normal(n)


def autoregressive(rng: np.random.Generator, n: int, deviation: float, memory: float) -> np.ndarray:
    """First-order autoregressive noise e[k] = memory·e[k−1] + white, of total standard deviation `deviation`, (n,)."""
    shocks = rng.standard_normal(n) * np.sqrt(1 - memory**2)
    shocks[0] /= np.sqrt(1 - memory**2)
    return deviation * np.asarray(lfilter([1.0], [1.0, -memory], shocks))


def hum(rng: np.random.Generator, t: np.ndarray, deviation: float, mains: float = 50.0) -> np.ndarray:
    """White noise and mains hum (mains and its third harmonic) of equal power; total deviation `deviation`, (n,)."""
    tone = np.sin(2 * np.pi * mains * t + rng.uniform(0, 2 * np.pi))
    third = 0.5 * np.sin(6 * np.pi * mains * t + rng.uniform(0, 2 * np.pi))
    lines = (tone + third) / np.sqrt(0.5 * 1.25)
    return deviation * (rng.standard_normal(len(t)) + lines) / np.sqrt(2)
