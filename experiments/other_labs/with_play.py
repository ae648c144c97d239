"""Gears, lead screws and linear motors: a drive with lost motion, teeth along the way, drives with corners."""

from __future__ import annotations

import numpy as np

from .lab import Lab, Signal, device, multisine, oscillator, sine, solve, steps


def _played(u: Signal, width: float, end: float, points: int = 400_000) -> Signal:
    """The drive after an exact play of half width `width`, from rest, as a line through many points."""
    t = np.linspace(0.0, end, points)
    p, out = 0.0, np.empty(points)
    for i, x in enumerate(u(t).tolist()):
        p = min(max(p, x - width), x + width)
        out[i] = p
    return lambda at: np.interp(at, t, out)


@device("backlash")
def gear(lab: Lab, rng: np.random.Generator) -> None:
    """A servo of 9 Hz behind a gear, sums of sines and sines, V and mm."""
    f, quality, width = 9 * rng.uniform(0.8, 1.2), rng.uniform(4, 12), rng.uniform(0.15, 0.4)
    w, t = 2 * np.pi * f, np.arange(3000) / 320
    drives = [
        multisine(rng, 1.0, 0.5, 14, 0.25),
        sine(1.6, 0.45 * f),
        multisine(rng, 0.5, 0.5, 14, 0.25),
        sine(1.0, 1.1 * f),
    ]
    for i, u in enumerate(drives):
        ramped: Signal = lambda t, u=u: u(t) * (1 - np.exp(-np.asarray(t) * f))
        z = solve(oscillator(f, quality, 0.1 * w * w, _played(ramped, width, t[-1])), t, [0, 0], most=t[1])[0]
        lab.write(f"run{i}", "time (s),servo (V),edge (mm)", t, ramped(t), z, noise=0.005, held=i == 3)


@device("backlash")
def lead_screw(lab: Lab, rng: np.random.Generator) -> None:
    """An overdamped slide at the end of a screw with clearance, ramps and steps, V and um."""
    f, quality, width = 2.1 * rng.uniform(0.8, 1.2), rng.uniform(0.3, 0.5), rng.uniform(0.1, 0.3)
    w, t = 2 * np.pi * f, np.arange(2400) / 60
    for i, (size, share) in enumerate([(3, 0.05), (4, 0.5), (2, 0.5), (4, 0.05), (3, 0.3)]):
        u = steps(np.round(size * rng.uniform(-1, 1, 15), 2), t[-1], share * t[-1] / 15)
        z = solve(oscillator(f, quality, 40 * w * w, _played(u, width, t[-1])), t, [0, 0], most=t[1] / 4)[0]
        lab.write(f"move{i}", "time_s,drive_V,position_um", t, u(t), z, noise=0.006, held=i == 4)


@device("cogging")
def linear_motor(lab: Lab, rng: np.random.Generator) -> None:
    """A carriage on flexures that passes several magnets, A and mm."""
    f, pitch, t = 4 * rng.uniform(0.8, 1.2), rng.uniform(2, 5), np.arange(3200) / 160
    w = 2 * np.pi * f
    force, phase = rng.uniform(0.2, 0.4) * w * w * pitch / (2 * np.pi), rng.uniform(0, 2 * np.pi)
    law = lambda z, v, u, t: -force * (np.sin(2 * np.pi * z / pitch + phase) - np.sin(phase))
    for i, size in enumerate([2.0, 4.0, 3.0, 1.0, 3.5]):
        u = multisine(rng, size, 0.3, 7, 0.1)
        eased: Signal = lambda t, u=u: u(t) * (1 - np.exp(-2 * np.asarray(t)))
        z = solve(oscillator(f, 6, 0.8 * w * w, eased, law), t, [0, 0], most=t[1])[0]
        lab.write(f"pass{i}", "time_s,current_A,position_mm", t, eased(t), z, noise=0.005, held=i == 4)


@device("cubic-stiffness")
def triangles(lab: Lab, rng: np.random.Generator) -> None:
    """A stage of 180 Hz that softens, driven by triangles of a generator, V and um: their corners ring in a spline."""
    f, quality = 180 * rng.uniform(0.8, 1.2), rng.uniform(10, 40)
    w, t = 2 * np.pi * f, np.arange(2600) / (25 * f)
    for i, (size, rate) in enumerate([(2, 0.11), (5, 0.23), (4, 0.07), (5, 0.31)]):
        turn = f * rate * rng.uniform(0.95, 1.05)
        u: Signal = lambda t, a=size, n=turn: a * 2 / np.pi * np.arcsin(np.sin(2 * np.pi * n * np.asarray(t)))
        z = solve(
            oscillator(f, quality, 1.5 * w * w, u, lambda z, v, u, t: 0.001 * w * w * z**3), t, [0, 0], most=t[1] / 3
        )[0]
        lab.write(f"scan{i}", "time_s,drive_V,displacement_um", t, u(t), z, noise=0.004, digits=8, held=i == 3)
