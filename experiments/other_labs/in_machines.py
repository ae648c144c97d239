"""A sled's brake and a motor's valve: what moves without a spring, and a law that needs two coordinates at once."""

from __future__ import annotations

import numpy as np

from .lab import Lab, Signal, device, multisine, oscillator, solve, steps


@device("eddy-current-brake")
def sled(lab: Lab, rng: np.random.Generator) -> None:
    """A sled on air with magnets above a rail, pushed by a linear motor; its speed is read, and no spring holds it."""
    t, critical = np.arange(2500) / 100, rng.uniform(3.5, 5.0)  # s, m/s
    drives: list[Signal] = [
        steps(np.array([0.8, 1.6, 2.4, 3.0, 1.2, 0.0, -1.4, -2.6]), 25, 0.05),
        multisine(rng, 0.9, 0.1, 2.0, 0.1),
        steps(np.array([3.2, 0.0, 2.0, 0.0, 0.0]), 25, 0.05),
        multisine(rng, 1.1, 0.05, 1.0, 0.05),
    ]
    for i, u in enumerate(drives):

        def rates(t: float, y: np.ndarray, u=u) -> list[float]:
            return [2.5 * float(u(t)) - 0.29 * y[0] - 2.46 * y[0] / (1 + (y[0] / critical) ** 2)]

        speed = solve(rates, t, [0.0], most=0.05)[0]
        lab.write(f"run{i}", "time (s),current (A),speed (m/s)", t, u(t), speed, noise=0.006, held=i == 3)


@device(beyond=True, floor=False)
def valve(lab: Lab, rng: np.random.Generator) -> None:
    """An orifice feeds a motor: u √(1 − p sign u), with a pressure p that the speed takes."""
    f, t = rng.uniform(9, 12), np.arange(3000) / 300
    takes = 0.1 / (2 * np.pi * f)

    def flow(z: float, v: float, u: float, t: float) -> float:
        return 0.6 * (2 * np.pi * f) ** 2 * u * (np.sqrt(max(1 - np.sign(u) * takes * v, 0.05)) - 1)

    for i, size in enumerate([0.6, 1.8, 1.2, 1.4]):
        u = multisine(rng, size, 0.1 * f, 2 * f, 0.1)
        z = solve(oscillator(f, 3.2, 0.6 * (2 * np.pi * f) ** 2, u, flow), t, [0, 0])[0]
        lab.write(f"run{i}", "time (s),drive (V),sensor (V)", t, u(t), z, noise=0.004, held=i == 3)
