"""Devices shaken at their base, whose displacement was recorded: spring, damper and joints see the distance from it."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from scipy.interpolate import CubicSpline

from .lab import Lab, device, multisine, solve


def road(rng: np.random.Generator, size: float, f: float, length: float) -> CubicSpline:
    """A random height of some size, that begins with nothing."""
    t = np.linspace(0, length, int(200 * f * length))
    curve = multisine(rng, size, 0.3 * f, 4 * f, 0.1 * f)
    return CubicSpline(t, curve(t) * np.clip(t * f / 2, 0, 1) ** 2)


def carried(f: float, quality: float, height: CubicSpline, law: Callable | None = None) -> Callable:
    """z̈ = −(ω/Q) ẇ − ω² w + law(w, ẇ), with w the distance of the body from its base."""
    w, climb = 2 * np.pi * f, height.derivative()

    def rates(t: float, y: np.ndarray) -> list[float]:
        apart, pace = y[0] - height(t), y[1] - climb(t)
        return [y[1], -w * w * apart - w / quality * pace + (0.0 if law is None else law(apart, pace))]

    return rates


@device("cubic-stiffness")
def car(lab: Lab, rng: np.random.Generator) -> None:
    """A spring whose force is half as large again at 30 mm, road and body in mm."""
    f = 1.4 * rng.uniform(0.9, 1.1)
    t, w2 = np.arange(2000) / (40 * f), (2 * np.pi * f) ** 2
    for i, size in enumerate([0.006, 0.012, 0.02, 0.016]):
        u = road(rng, size, f, t[-1])
        z = solve(carried(f, 1.6, u, lambda z, v: -0.5 * w2 * z**3 / 0.03**2), t, [0, 0])[0]
        lab.write(f"road{i}", "t (s),road (mm),body (mm)", t, 1e3 * u(t), 1e3 * z, held=i == 3)


@device("coulomb-friction")
def seat(lab: Lab, rng: np.random.Generator) -> None:
    """A guide that rubs, floor in mm and seat in m/s²."""
    f = 2.2 * rng.uniform(0.9, 1.1)
    t = np.arange(2500) / (50 * f)
    for i, size in enumerate([0.004, 0.008, 0.015, 0.011]):
        u = road(rng, size, f, t[-1])
        rates = carried(f, 2.5, u, lambda z, v: -0.25 * np.tanh(v / 3e-3))
        a = np.array([rates(at, y)[1] for at, y in zip(t, solve(rates, t, [0, 0], most=0.02 / f).T, strict=True)])
        lab.write(f"floor{i}", "t (s),floor (mm),seat (m/s^2)", t, 1e3 * u(t), a, held=i == 3)


@device()
def shaking_table(lab: Lab, rng: np.random.Generator) -> None:
    """Nothing hidden; the table's own sensor in V, and the body in mm."""
    f = 9 * rng.uniform(0.9, 1.1)
    t = np.arange(2000) / (40 * f)
    for i, size in enumerate([0.002, 0.004, 0.003]):
        u = road(rng, size, f, t[-1])
        z = solve(carried(f, 1.2, u), t, [0, 0])[0]
        lab.write(f"table{i}", "t (s),table (V),body (mm)", t, 430 * u(t), 1e3 * z, held=i == 2)
