"""Accelerations and velocities through sensors that do something to what they read."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from scipy.integrate import solve_ivp
from scipy.interpolate import CubicSpline

from .lab import Lab, device, multisine, oscillator, solve


def _motions(
    lab: Lab, rng: np.random.Generator, law: Callable, sizes: tuple[float, ...], quality: float
) -> list[tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]]:
    """Time, drive, velocity and acceleration of an oscillator of 1.6 kg at some 30 Hz."""
    f = 30 * rng.uniform(0.9, 1.1)
    t, found = np.arange(4000) / (36 * f), []
    for size in sizes:
        u = multisine(rng, size, 0.2 * f, 2.5 * f, 0.05 * f)
        rates = oscillator(f, quality, 1 / 1.6, u, lambda z, v, u, t: law(2 * np.pi * f, z, v))
        states = solve(rates, t, [0, 0], 0.5)
        found.append((t, u(t), states[1], np.array([rates(a, b)[1] for a, b in zip(t, states.T, strict=True)])))
    return found


def _filtered(t: np.ndarray, x: np.ndarray, rate: Callable) -> np.ndarray:
    """The state of a filter of the first order, q̇ = rate(x, q), from zero."""
    curve = CubicSpline(t, x)
    return solve_ivp(lambda t, q: rate(curve(t), q), (t[0], t[-1]), [0.0], "DOP853", t, rtol=1e-9, atol=1e-12).y[0]


@device("cubic-stiffness", "ac-coupling")
def charge_amplifier(lab: Lab, rng: np.random.Generator) -> None:
    """A spring that hardens, N and m/s², read through a charge amplifier that passes nothing below 0.9 Hz."""
    corner = 2 * np.pi * 0.9
    motions = _motions(lab, rng, lambda w, z, v: -w * w * z * (z / 12e-3) ** 2, (8, 16, 26, 20), 25)
    for i, (t, u, _, a) in enumerate(motions):
        read = a - corner * _filtered(t, a, lambda x, q: x - corner * q)
        lab.write(f"run{i}", "time (s),force (N),acceleration (m/s^2)", t, u, read, noise=0.004, held=i == 3)


@device("sensor-nonlinearity")
def shock_sensor(lab: Lab, rng: np.random.Generator) -> None:
    """A linear device, N and g, and an accelerometer that saturates."""
    for i, (t, u, _, a) in enumerate(_motions(lab, rng, lambda w, z, v: 0.0, (8, 16, 26, 20), 12)):
        read = 14 * np.tanh(a / 9.80665 / 14)
        lab.write(f"run{i}", "time (s),force (N),acceleration (g)", t, u, read, noise=0.003, held=i == 3)


@device("quadratic-damping|power-law-damping", "sensor-lag|drive-lag")
def late_vibrometer(lab: Lab, rng: np.random.Generator) -> None:
    """Drag, N and mm/s, read through a tracking filter of 1.5 ms."""
    for i, (t, u, v, _) in enumerate(_motions(lab, rng, lambda w, z, v: -9 * abs(v) * v, (8, 16, 26, 20), 30)):
        read = 1e3 * _filtered(t, v, lambda x, q: (x - q) / 1.5e-3)
        lab.write(f"run{i}", "time (s),force (N),velocity (mm/s)", t, u, read, noise=0.004, held=i == 3)
