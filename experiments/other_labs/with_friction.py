"""Guides and bearings, whose friction falls once they slide."""

from __future__ import annotations

import numpy as np

from .lab import Lab, device, multisine, oscillator, solve


@device("stribeck-friction")
def slide(lab: Lab, rng: np.random.Generator) -> None:
    """A table on a greased guide, on springs, N and mm."""
    f = 14 * rng.uniform(0.9, 1.1)
    mass, t = 2.2, np.arange(4000) / (60 * f)
    loose, kept, slow = 0.35, rng.uniform(0.4, 0.6), 2.5e-3  # N, share, m/s
    for i, size in enumerate([1.2, 2.0, 4.0, 3.0]):
        u = multisine(rng, size, 0.4 * f, 1.8 * f, 0.1 * f)

        def friction(z: float, v: float, u: float, t: float) -> float:
            return -loose / mass * (kept + (1 - kept) * np.exp(-((v / slow) ** 2))) * np.tanh(v / 2e-4)

        z = solve(oscillator(f, 18, 1 / mass, u, friction), t, [0, 0])[0]
        lab.write(f"run{i}", "time (s),force (N),displacement (mm)", t, u(t), 1e3 * z, noise=0.004, held=i == 1)


@device("stribeck-friction", floor=False)
def carriage(lab: Lab, rng: np.random.Generator) -> None:
    """A carriage without a spring, moved by a motor, A and mm. Its friction falls otherwise than the library's, and
    what is left of a force adds up twice."""
    t = np.arange(5000) / 500
    grip = 3.0 * rng.uniform(0.8, 1.2)  # m/s² of the motor
    for i, size in enumerate([1.0, 2.0, 3.0, 2.5]):
        u = multisine(rng, size, 0.3, 6, 0.1)

        def rates(t: float, y: np.ndarray, u=u) -> list[float]:
            slides = 0.6 + 0.4 / (1 + (y[1] / 0.12) ** 2)
            return [y[1], 20 * float(u(t)) - 4 * y[1] - grip * slides * np.tanh(y[1] / 0.02)]

        z = solve(rates, t, [0, 0])[0]
        lab.write(f"run{i}", "time (s),current (A),position (mm)", t, u(t), 1e3 * z, noise=0.003, held=i == 1)
