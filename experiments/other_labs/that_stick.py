"""Devices that stick: they stand still until what pushes them exceeds what holds, by events, not by a steep step."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

from .lab import Lab, Signal, device, multisine, sine


def stuck_and_slid(
    t: np.ndarray, push: Callable[[float, float, float], float], hold: float, slide: Callable[[float], float]
) -> np.ndarray:
    """(2, n) motion z̈ = push(t, z, ż) − slide(|ż|) sgn ż, from rest; it stands until |push| exceeds `hold`."""
    found = np.zeros((2, t.size))
    now, z, step, end = t[0], 0.0, t[1] - t[0], t[-1]
    while now < end:
        beyond = lambda at, z=z: abs(push(at, z, 0.0)) - hold
        if beyond(now) <= 0:  # stands
            grid = np.append(np.arange(now, end, 0.2 * step), end)
            over = np.flatnonzero(np.array([beyond(at) for at in grid]) > 0)
            until = end if not over.size else brentq(beyond, grid[over[0] - 1], grid[over[0]])
            found[:, (t >= now) & (t <= until)] = [[z], [0.0]]
            if not over.size:
                break
            now = until + 1e-9 * step
        way = np.sign(push(now, z, 0.0))
        rates = lambda at, y, way=way: [y[1], push(at, y[0], y[1]) - way * slide(abs(y[1]))]
        turns = lambda at, y, way=way: way * y[1]
        turns.terminal, turns.direction = True, -1
        speed = way * 1e-9 * max(abs(push(now, z, 0.0)), 1e-9) * step
        slid = solve_ivp(
            rates, (now, end), [z, speed], "RK45", rtol=1e-8, atol=1e-13, max_step=2 * step, events=turns,
            dense_output=True,
        )  # fmt: skip
        inside = (t > now) & (t <= slid.t[-1])
        if np.any(inside):
            found[:, inside] = slid.sol(t[inside])
        now, z = float(slid.t[-1]), float(slid.y[0, -1])
    return found


def _stage(u: Signal, f: float, quality: float, gain: float) -> Callable[[float, float, float], float]:
    w = 2 * np.pi * f
    return lambda t, z, v: gain * float(u(t)) - w * w * z - w / quality * v


@device("coulomb-friction|stribeck-friction", floor=False)
def sticking_stage(lab: Lab, rng: np.random.Generator) -> None:
    """A stage on dry guides, N and mm, that stands for a third of the time at small drives."""
    f, t = 7.5 * rng.uniform(0.9, 1.1), np.arange(3000) / 300
    for i, size in enumerate([2.0, 3.5, 6.0, 4.5]):
        u = multisine(rng, size, 0.8, 11, 0.2)
        z = stuck_and_slid(t, _stage(u, f, 15, 1 / 1.8), 1.6 / 1.8, lambda speed: 1.6 / 1.8)[0]
        lab.write(f"run{i}", "t (s),Force (N),displacement (mm)", t, u(t), 1e3 * z, digits=4, held=i == 3)


@device("stribeck-friction", floor=False)
def seal(lab: Lab, rng: np.random.Generator) -> None:
    """A piston on its spring, whose seal holds twice as much as it drags, V and mm."""
    f, t = 11 * rng.uniform(0.9, 1.1), np.arange(3000) / 450
    w2 = (2 * np.pi * f) ** 2
    for i, (size, ratio) in enumerate([(0.5, 0.4), (0.8, 0.9), (1.4, 0.6), (1.0, 0.75)]):
        u, grip = sine(size, ratio * f), 0.2e-3 * w2
        drag = lambda speed, grip=grip: grip * (0.5 + 0.5 * np.exp(-((speed / 4e-3) ** 2)))
        z = stuck_and_slid(t, _stage(u, f, 12, 1e-3 * w2), grip, drag)[0]
        lab.write(f"seal{i}", "time (s),valve (V),piston (mm)", t, u(t), 1e3 * z, noise=0.005, bits=14, digits=4,
                  held=i == 3)  # fmt: skip


@device("stribeck-friction", floor=False)
def geared_motor(lab: Lab, rng: np.random.Generator) -> None:
    """No spring: current and angle of a motor whose gear holds 1.8 times as much as it drags."""
    scale, t = rng.uniform(0.9, 1.1), np.arange(4000) / 400
    for i, size in enumerate([0.5, 0.8, 1.2, 1.0]):
        u = multisine(rng, size, 0.3, 4, 0.2)
        drag = lambda speed: 9.0 * (1.0 + 0.8 * np.exp(-((speed / 0.4) ** 2)))
        push = lambda at, z, v, u=u: 40 * scale * float(u(at)) - 3.0 * v
        z = stuck_and_slid(t, push, 16.2, drag)[0]
        lab.write(f"turn{i}", "time (s),Current (A),angle (deg)", t, u(t), np.degrees(z), noise=0.002, digits=4,
                  held=i == 3)  # fmt: skip
