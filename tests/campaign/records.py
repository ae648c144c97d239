"""Truths for the tests of this folder: a nonlinear oscillator drives, and noise of known colour."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from scipy.signal import lfilter

Drive = Callable[[np.ndarray | float], np.ndarray | float]
RESONANCE = 500.0


def respond(
    drive: Drive,
    n: int,
    rate: float,
    quality: float = 40.0,
    cubic: float = 0.01,
    quadratic: float = 0.02,
    lead: float = 0.0,
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """(time, drive, response), each (n,), of z̈ + ω ż/Q + ω² (z + q z² + c z³) = ω² g u; rms of the linear response 1.

    `lead`: seconds that are simulated before the record begins (0: from rest). Runge-Kutta of fourth order with at
    least 150 steps per period of the resonance: the error is far below any noise of the tests.
    """
    omega, inner = 2 * np.pi * RESONANCE, int(np.ceil(150 * RESONANCE / rate))
    before = int(lead * rate)
    step = 1.0 / (rate * inner)
    points = (np.arange(2 * (n - 1 + before) * inner + 1) / (2 * inner) - before) / rate
    push = np.broadcast_to(np.asarray(drive(points), dtype=float), points.shape)

    def solve(gain: float, q: float, c: float) -> np.ndarray:
        u = (gain * push).tolist()
        stiff, damp, half = omega**2, omega / quality, 0.5 * step
        z = v = 0.0
        found = [0.0]
        for k in range(0, len(u) - 1, 2):
            a1 = stiff * (u[k] - z - q * z * z - c * z * z * z) - damp * v
            z2, v2 = z + half * v, v + half * a1
            a2 = stiff * (u[k + 1] - z2 - q * z2 * z2 - c * z2 * z2 * z2) - damp * v2
            z3, v3 = z + half * v2, v + half * a2
            a3 = stiff * (u[k + 1] - z3 - q * z3 * z3 - c * z3 * z3 * z3) - damp * v3
            z4, v4 = z + step * v3, v + step * a3
            a4 = stiff * (u[k + 2] - z4 - q * z4 * z4 - c * z4 * z4 * z4) - damp * v4
            z += step / 6 * (v + 2 * v2 + 2 * v3 + v4)
            v += step / 6 * (a1 + 2 * a2 + 2 * a3 + a4)
            found.append(z)
        return np.array(found[::inner])[before:]

    gain = 1.0 / float(np.std(solve(1.0, 0.0, 0.0)))
    time = np.arange(n) / rate
    return time, np.asarray(drive(time), dtype=float), solve(gain, quadratic, cubic)


def coloured(rng: np.random.Generator, n: int, ar: tuple[float, ...], sigma: float) -> np.ndarray:
    """(n,) autoregressive noise of standard deviation `sigma`."""
    polynomial = np.append(1.0, -np.array(ar))
    impulse = lfilter([1.0], polynomial, np.append(1.0, np.zeros(5000)))
    return sigma / float(np.sqrt(np.sum(impulse**2))) * lfilter([1.0], polynomial, rng.standard_normal(n + 2000))[2000:]


def sine(frequency: float, phase: float = 0.0) -> Drive:
    return lambda t: np.sin(2 * np.pi * frequency * np.asarray(t) + phase)


def multisine(period: float, orders: range, rng: np.random.Generator) -> Drive:
    phases = rng.uniform(0, 2 * np.pi, len(orders))
    return lambda t: sum(
        np.cos(2 * np.pi * k * np.asarray(t) / period + p) for k, p in zip(orders, phases, strict=True)
    )
