"""A Duffing-like electronic oscillator in volts, integrated by SciPy.

z̈ + (ω0/Q) ż + ω0² z + k3 z³ = g u
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.integrate import solve_ivp

from .signals import Drive


@dataclass(frozen=True)
class Circuit:
    """Natural frequency (Hz), quality factor, gain g (1/s²) and cubic stiffness k3 (1/(V² s²))."""

    frequency: float
    quality: float
    gain: float
    cubic: float


def simulate(circuit: Circuit, drive: Drive, t: np.ndarray) -> np.ndarray:
    """Output voltage at the times `t` (s) from rest, (n,) V."""
    w0 = 2 * np.pi * circuit.frequency

    def rate(now: float, state: np.ndarray) -> tuple[float, float]:
        z, v = state
        u = float(drive.value(np.array([now]))[0])
        return v, circuit.gain * u - w0 / circuit.quality * v - w0**2 * z - circuit.cubic * z**3

    solution = solve_ivp(rate, (t[0], t[-1]), (0.0, 0.0), method="DOP853", t_eval=t, rtol=1e-9, atol=1e-12)
    return np.asarray(solution.y[0])
