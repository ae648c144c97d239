"""Devices driven so far that no linear model comes near: a plate half-way to pull-in, a swing, a brake by a magnet,
a shaker on a resonance that bends, a plate that bounces off a rubber stop, a valve with a dead band."""

from __future__ import annotations

import numpy as np

from .lab import Lab, chirp, device, multisine, oscillator, sine, solve


@device("electrostatic-force")
def plate(lab: Lab, rng: np.random.Generator) -> None:
    """A parallel-plate actuator at 9 kHz, a sine beside a bias that is switched on in some periods, V and nm."""
    f, gap, t = 9300 * rng.uniform(0.9, 1.1), 2e-6, np.arange(3000) / 560e3
    attraction = 2.7e-9 * (2 * np.pi * f) ** 2
    levels = [(2, 1, 0.9), (2, 2, 0.95), (3, 1.2, 1.02), (3, 1, 0.97), (2.5, 2, 0.93), (3, 1.4, 1.0)]
    for i, (bias, size, at) in enumerate(levels):
        u = lambda t, b=bias, a=size, w=2 * np.pi * at * f: (1 - np.exp(-w * t / 6)) * (b + a * np.sin(w * t))
        law = lambda z, v, u, t: attraction * u * u / (1 - z / gap) ** 2
        z = solve(oscillator(f, 35, 0, u, law), t, [0, 0])[0]
        lab.write(f"run{i}", "time_us,voltage_V,displacement_nm", 1e6 * t, u(t), 1e9 * z, noise=0.004, held=i == 2)


@device("cogging", "coulomb-friction|stribeck-friction|presliding-friction", floor=False)
def swing(lab: Lab, rng: np.random.Generator) -> None:
    """A pendulum driven to 2.7 radian, in a dry bearing: its sine is softer than any polynomial says."""
    f, t = 1.1 * rng.uniform(0.97, 1.03), np.arange(4000) / 80
    w = 2 * np.pi * f
    for i, size in enumerate([1.0, 2.0, 3.0, 4.0, 2.5]):
        low, high = (0.55 * f, 1.55 * f) if i % 2 == 0 else (1.55 * f, 0.55 * f)
        u = chirp(size, low, high, t[-1])
        rates = lambda t, y, u=u: [
            y[1], -w * w * np.sin(y[0]) - w / 60 * y[1] - 0.12 * np.tanh(y[1] / 0.02) + float(u(t)),
        ]  # fmt: skip
        z = solve(rates, t, [0, 0])[0]
        lab.write(f"run{i}", "time_s,torque_Nm,angle_rad", t, u(t), z, noise=0.003, held=i == 1)


@device(beyond=True, floor=False)
def magnet(lab: Lab, rng: np.random.Generator) -> None:
    """A plate that a magnet brakes where it is near: damping that falls with the displacement, N and mm."""
    f, t = 6.5 * rng.uniform(0.9, 1.1), np.arange(3600) / 180
    for i, size in enumerate([1.0, 2.0, 4.0, 6.0, 5.0]):
        u = multisine(rng, 0.7 * size, 3.0, 11.0, 1 / 3)
        law = lambda z, v, u, t: -2.4 * v / (1 + (z / 0.012) ** 2)
        z = solve(oscillator(f, 200, 1, u, law), t, [0, 0])[0]
        lab.write(f"e{i}", "time_s,force_N,displacement_mm", t, u(t), 1e3 * z, noise=0.004, held=i == 4)


@device("cubic-stiffness")
def shaker(lab: Lab, rng: np.random.Generator) -> None:
    """Steady sines within five per cent of a resonance that climbs with the level: to a line they are a gain."""
    f, quality, t = 131 * rng.uniform(0.8, 1.25), rng.uniform(12, 30), np.arange(2000) / 8000
    hardening = rng.uniform(2e8, 5e8) * (2 * np.pi * f) ** 2
    levels = [(1, 0.95), (2, 0.98), (3, 1.0), (2.5, 1.02), (1.5, 1.0), (3, 0.97)]
    for i, (size, at) in enumerate(levels):
        u = sine(size, at * f)
        law = lambda z, v, u, t: -hardening * z**3
        z = solve(oscillator(f, quality, 2e-6 * (2 * np.pi * f) ** 2, u, law), t + 2.0, [0, 0], before=0.0)[0]
        lab.write(f"s{i}", "time_s,drive_V,displacement_um", t, u(t + 2.0), 1e6 * z, noise=0.003, held=i == 4)


@device("end-stop", "contact-loss|quadratic-damping|squeeze-film-damping")
def bouncing(lab: Lab, rng: np.random.Generator) -> None:
    """A plate that meets a rubber stop above it, which gives back a part of what it takes (Hunt, Crossley), N, mm."""
    f, t = 3.1 * rng.uniform(0.9, 1.1), np.arange(2600) / 130
    w, gap, loss = 2 * np.pi * f, 4e-3, rng.uniform(0.6, 1.4)
    hardness = rng.uniform(15, 30) * w * w
    for i, size in enumerate([0.7, 1.2, 1.8, 1.5]):
        u = chirp(size, 0.6 * f, 1.5 * f, t[-1])

        def law(z, v, u, t):
            depth = max(z - gap, 0.0)
            return -hardness * depth**1.5 * max(1 + loss * v, 0.0)

        z = solve(oscillator(f, 15, 3e-3 * w * w / 8, u, law), t, [0, 0], most=2e-3)[0]
        lab.write(f"h{i}", "time_s,force_N,displacement_mm", t, u(t), 1e3 * z, noise=0.006, held=i == 3)


@device(beyond=True, floor=False)
def valve(lab: Lab, rng: np.random.Generator) -> None:
    """A proportional valve that does nothing within its dead band, sines, a sweep and a switched drive, V and mm."""
    f, t = 28 * rng.uniform(0.9, 1.1), np.arange(2400) / 2000
    w, band = 2 * np.pi * f, rng.uniform(0.2, 0.35)
    dead = lambda u: np.sign(u) * np.maximum(np.abs(u) - band, 0.0)
    level = rng.choice([-1.2, 1.2], 60)
    switched = lambda t: level[np.minimum((np.asarray(t) * 50).astype(int), 59)]
    for i, u in enumerate([sine(1.5, 0.4 * f), chirp(2.0, 5, 60, t[-1]), switched, sine(0.9, 0.9 * f)]):
        pushed = lambda t, u=u: dead(u(t))
        z = solve(oscillator(f, 0.8, 2e-3 * w * w, pushed), t, [0, 0], most=5e-4)[0]
        lab.write(f"v{i}", "time_s,command_V,displacement_mm", t, u(t), 1e3 * z, noise=0.01, held=i == 3)
