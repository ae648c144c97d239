"""Devices whose drive is held: by a converter, a switch, a controller that computes first. Each interval between two
edges is integrated by itself."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from scipy.integrate import solve_ivp
from scipy.linalg import expm

from .lab import Lab, device


def solve_held(rates: Callable, t: np.ndarray, edges: np.ndarray, levels: np.ndarray) -> np.ndarray:
    """(n,) displacements from rest at times `t` under `levels` that begin at the `edges`, and nothing before."""
    state, begun, level = np.zeros(2), t[0], 0.0
    out = np.zeros(len(t))
    for end, following in zip([*edges, np.inf], [*levels, 0.0], strict=True):
        inside, stop = np.flatnonzero((t > begun) & (t <= end)), min(end, t[-1])
        if stop > begun:
            at = np.unique(np.append(t[inside], stop))
            found = solve_ivp(lambda _, y, u=level: rates(*y, u), (begun, stop), state, "DOP853", at,
                              rtol=1e-9, atol=1e-12)  # fmt: skip
            out[inside], state, begun = found.y[0][: len(inside)], found.y[:, -1], stop
        level = following
    return out


@device("cubic-stiffness")
def converter(lab: Lab, rng: np.random.Generator) -> None:
    """A multisine as a converter gives it out, on the clock of the samples, 20 of them in a period; V and mm."""
    f = 25 * rng.uniform(0.9, 1.1)
    w2, t = (2 * np.pi * f) ** 2, np.arange(1500) / (20 * f)
    tones = np.arange(0.3, 2.0, 0.1) * f
    for i, size in enumerate([0.05, 0.1, 0.18, 0.14]):
        u = np.sum([np.cos(2 * np.pi * one * t + rng.uniform(0, 2 * np.pi)) for one in tones], axis=0)
        u *= size / np.std(u)
        rates = lambda z, v, u: [v, w2 * (u - z - 0.25 * z**3) - np.sqrt(w2) / 12 * v]
        lab.write(f"multi{i}", "t (s),command (V),z (mm)", t, u, solve_held(rates, t, t, u), digits=7, held=i == 3)


@device("quadratic-damping")
def switched_valve(lab: Lab, rng: np.random.Generator) -> None:
    """A square wave, measured: its edges lie 0.7 of an interval before the sample that shows them; A and mm."""
    f = 25 * rng.uniform(0.9, 1.1)
    w, step = 2 * np.pi * f, 1 / (40 * f)
    t = step * np.arange(3000)
    for i, size in enumerate([0.3, 0.6, 1.0, 0.8]):
        shown = np.arange(10, 3000, int(rng.integers(90, 140)))
        levels = size * (np.arange(len(shown)) % 2 == 0)
        u = np.concatenate([[0.0], levels])[np.searchsorted(shown, np.arange(3000), side="right")]
        rates = lambda z, v, u: [v, w * w * (u - z) - w / 12 * v - 0.08 * abs(v) * v]
        z = solve_held(rates, t, (shown - 0.7) * step, levels)
        lab.write(f"sq{i}", "t (s),valve (A),lift (mm)", t, u, z, digits=7, held=i == 3)


@device("coulomb-friction")
def controller(lab: Lab, rng: np.random.Generator) -> None:
    """Random levels, each commanded one sample before it acts; V and mm."""
    f = 25 * rng.uniform(0.9, 1.1)
    w, step = 2 * np.pi * f, 1 / (30 * f)
    t = step * np.arange(2500)
    for i, size in enumerate([0.3, 0.6, 1.0, 0.8]):
        u = np.repeat(size * rng.choice([-1.0, 1.0], 500), 5)
        rates = lambda z, v, u: [v, w * w * (u - z - 0.03 * np.tanh(v / (0.01 * w))) - w / 12 * v]
        lab.write(f"prbs{i}", "t (s),command (V),z (mm)", t, u, solve_held(rates, t, t + step, u), digits=7,
                  held=i == 3)  # fmt: skip


@device()
def relay(lab: Lab, rng: np.random.Generator) -> None:
    """A linear device under a relay that falls 0.4 of an interval before the sample; V and um."""
    f = 140 * rng.uniform(0.9, 1.1)
    w, step = 2 * np.pi * f, 1 / (25 * f)
    t = step * np.arange(2500)
    for i, size in enumerate([1.0, 2.0, 1.5]):
        shown = np.cumsum(rng.integers(20, 90, 60)) + 5
        shown = shown[shown < 2500]
        levels = size * (np.arange(len(shown)) % 2 == 0)
        u = np.concatenate([[0.0], levels])[np.searchsorted(shown, np.arange(2500), side="right")]
        z = solve_held(lambda z, v, u: [v, w * w * (u - z) - w / 20 * v], t, (shown - 0.4) * step, levels)
        lab.write(f"relay{i}", "t (s),relay (V),z (um)", t, u, z, digits=8, held=i == 2)


@device()
def geophone(lab: Lab, rng: np.random.Generator) -> None:
    """A linear device under a coil that a switch reverses on the clock of the samples, read as a velocity; mA, mm/s."""
    f = 4.5 * rng.uniform(0.9, 1.1)
    w, step = 2 * np.pi * f, 1 / (40 * f)
    whole = expm(step * np.array([[0, 1, 0], [-w * w, -w / 0.9, 8.0], [0, 0, 0]]))[:2]
    for i, (size, hold) in enumerate([(1.0, 9), (0.5, 13), (0.8, 20)]):
        u, state = size * np.repeat(rng.choice([-1.0, 1.0], 3000 // hold), hold), [np.zeros(2)]
        for level in u[:-1]:
            state.append(whole @ [*state[-1], level])
        v = 1e3 * np.array(state)[:, 1]
        lab.write(f"coil{i}", "t (s),coil (mA),velocity (mm/s)", step * np.arange(len(u)), u, v, bits=8, held=i == 2)
