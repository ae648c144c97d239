"""Structures: a beam with a crack, a wing with a joint that has play, a loudspeaker, a harvester, wire ropes."""

from __future__ import annotations

import numpy as np

from .lab import Lab, chirp, device, multisine, oscillator, sine, solve


@device(beyond=True, floor=False)
def crack(lab: Lab, rng: np.random.Generator) -> None:
    """A beam that is softer while its crack is open, N and g: a spring with a kink where it rests."""
    f = 40 * rng.uniform(0.9, 1.1)
    w2, t = (2 * np.pi * f) ** 2, np.arange(3500) / (35 * f)
    for i, size in enumerate([1.0, 2.0, 3.0, 2.5]):
        u = multisine(rng, size, 0.3 * f, 2 * f, 1 / t[-1]) if i % 2 == 0 else chirp(size, 0.5 * f, 1.6 * f, t[-1])
        rates = oscillator(f, 25, 1.0, u, lambda z, v, u, t: 0.15 * w2 * min(z, 0.0))
        states = solve(rates, t, [0, 0])
        reading = np.array([rates(a, b)[1] for a, b in zip(t, states.T, strict=True)]) / 9.80665
        lab.write(f"run{i}", "time (s),force (N),acceleration (g)", t, u(t), reading, noise=0.006, held=i == 1)


@device(beyond=True, floor=False)
def wing(lab: Lab, rng: np.random.Generator) -> None:
    """Three masses, the third on a joint with 6 mm of play, N and m/s², read at the first."""
    mass, hertz, t = (
        np.array([8.0, 3.0, 1.5]),
        np.array([5.0, 7.3, 9.5]) * rng.uniform(0.95, 1.05),
        np.arange(4000) / 400,
    )
    coupling = np.array([[0.0, -2e3, 0.0], [-2e3, 0.0, -3e3], [0.0, -3e3, 0.0]])
    stiffness = np.diag(mass * (2 * np.pi * hertz) ** 2) + coupling
    damping = 4e-4 * stiffness + 0.2 * np.diag(mass)
    for i, size in enumerate([5.0, 15.0, 25.0, 20.0]):
        u = multisine(rng, size, 2, 15, 0.1)

        def rates(t: float, y: np.ndarray, u=u) -> np.ndarray:
            z, v = y[:3], y[3:]
            apart = z[2] - z[1]
            push = 2.5e3 * np.sign(apart) * max(abs(apart) - 6e-3, 0.0)
            return np.concatenate([v, (np.array([float(u(t)), push, -push]) - damping @ v - stiffness @ z) / mass])

        states = solve(rates, t, [0.0] * 6)
        reading = np.array([rates(a, b)[3] for a, b in zip(t, states.T, strict=True)])
        lab.write(f"level{i}", "time (s),Force (N),Acceleration (m/s2)", t, u(t), reading, held=i == 1)


@device(beyond=True, floor=False)
def loudspeaker(lab: Lab, rng: np.random.Generator) -> None:
    """A suspension that stiffens, and a force factor that falls with the excursion, V and mm."""
    f, t = 50 * rng.uniform(0.9, 1.1), np.arange(4000) / 4000
    w2 = (2 * np.pi * f) ** 2
    for i, size in enumerate([2.0, 5.0, 8.0, 6.0]):
        u = multisine(rng, size, 15, 180, 1.0)

        def rates(t: float, y: np.ndarray, u=u) -> list[float]:
            x, v, current = y
            factor = 5.0 * (1 - 8.0 * x - 6e3 * x * x)
            force = factor * current - 1.0 * v - 0.012 * w2 * x * (1 + 2.5e4 * x * x)
            return [v, force / 0.012, (float(u(t)) - 6.0 * current - factor * v) / 0.5e-3]

        z = solve(rates, t, [0, 0, 0])[0]
        lab.write(f"run{i}", "t (s),Voltage (V),excursion (mm)", t, u(t), 1e3 * z, noise=0.004, held=i == 1)


@device("cubic-stiffness")
def harvester(lab: Lab, rng: np.random.Generator) -> None:
    """A beam that softens, shaken by its base, m/s² and mm."""
    f = 25 * rng.uniform(0.9, 1.1)
    w2, t = (2 * np.pi * f) ** 2, np.arange(3500) / (25 * f)
    for i, (size, ratio) in enumerate([(2.0, 0.9), (6.0, 0.97), (10.0, 1.0), (8.0, 0.94)]):
        u = sine(size, ratio * f)
        z = solve(oscillator(f, 45, -1.0, u, lambda z, v, u, t: 2500 * w2 * z**3), t, [0, 0])[0]
        head = "time (s),base acceleration (m/s^2),tip displacement (mm)"
        lab.write(f"run{i}", head, t, u(t), 1e3 * z, noise=0.006, colour=0.4, held=i == 1)


@device("bouc-wen")
def ropes(lab: Lab, rng: np.random.Generator) -> None:
    """An isolator of wire ropes, N and mm."""
    f = 11 * rng.uniform(0.9, 1.1)
    w2, t = (2 * np.pi * f) ** 2, np.arange(4000) / (40 * f)
    for i, size in enumerate([1.0, 3.0, 6.0, 4.0]):
        u = multisine(rng, size, 0.2 * f, 2 * f, 1 / t[-1])

        def rates(t: float, y: np.ndarray, u=u) -> list[float]:
            z, v, h = y
            grip = 0.6 * abs(v) * abs(h) ** 0.5 * h + 0.4 * v * abs(h) ** 1.5
            return [v, float(u(t)) - 2 * np.pi * f / 40 * v - w2 * (0.6 * z + 0.4e-3 * h), (v - grip) / 1e-3]

        z = solve(rates, t, [0, 0, 0])[0]
        lab.write(f"run{i}", "time (s),force (N),displacement (mm)", t, u(t), 1e3 * z, noise=0.004, held=i == 1)
