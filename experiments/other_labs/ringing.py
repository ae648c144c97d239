"""Beams that are let go, with more than one mode in what is read."""

from __future__ import annotations

import numpy as np

from .lab import Lab, device, solve


def _beam(f: float, law=None):
    """Two modes, the second at 6.3 times the frequency; forces act on the first."""
    w, w2 = 2 * np.pi * f, 2 * np.pi * 6.3 * f

    def rates(t: float, y: np.ndarray) -> list[float]:
        bent = 0.0 if law is None else law(y[0], y[1])
        return [y[1], -w * w * y[0] - w / 120 * y[1] + bent, y[3], -w2 * w2 * y[2] - w2 / 90 * y[3]]

    return rates


@device("second-mode")
def beam(lab: Lab, rng: np.random.Generator) -> None:
    """Nothing hidden; an accelerometer, to which the second mode is the louder one."""
    f = 23 * rng.uniform(0.9, 1.1)
    t = np.arange(4000) / (60 * f)
    for i, size in enumerate([1e-3, 0.5e-3, 0.75e-3]):
        y = solve(_beam(f), t, [size, 0, 0.05 * size * rng.uniform(0.5, 1.5), 0])
        a = np.array([(r := _beam(f)(0.0, one))[1] + r[3] for one in y.T])
        lab.write(f"ring{i}", "t (s),acceleration (m/s^2)", t, None, a, digits=7, held=i == 2)


@device("second-mode", "quadratic-damping")
def beam_in_air(lab: Lab, rng: np.random.Generator) -> None:
    """The tip in mm, with drag."""
    f = 23 * rng.uniform(0.9, 1.1)
    t = np.arange(4000) / (60 * f)
    for i, size in enumerate([1.0, 0.5, 0.75]):
        y = solve(_beam(f, lambda z, v: -0.006 * abs(v) * v), t, [size, 0, 0.25 * size, 0])
        lab.write(f"tip{i}", "t (s),tip (mm)", t, None, y[0] + y[2], digits=7, held=i == 2)
