"""Where the motion at each frequency of a stepped sine ends: by Newton's method on the map of one period.

The same laws as `sweeps`, integrated by the same steps, but the wait until a motion has settled is left out, which is
nine tenths of the time. At each frequency the search begins with the motion at the one before; where that leads
nowhere near, or to a motion that does not hold, as beyond a fold, the transient is followed after all. For laws that
remember nothing but the last periods of the drive.

Source: A. H. Nayfeh, B. Balachandran, Applied Nonlinear Dynamics, 1995, §6.3 (shooting).
"""

from __future__ import annotations

import numpy as np
from numba import njit

from experiments.hidden_effects.laws import BOUC, CREEP, LAG_E, LAG_S, MODE, STATES, VISCO, driven, march, sensed

from .sweeps import STEPS

_REMEMBERED = 3  # periods after which a loop of the drive has closed
_OFF = 1e-6  # of the motion: by how much a state is moved to find a slope
_CLOSED = 1e-8  # difference of a state after a period, of the motion, that is none
_ROUNDS = 12
_FAR = 0.5  # of the motion: a root that is farther from the motion at the frequency before is another branch
_LOWEST = 0.1  # of a linear motion at the drive: what `the motion` is at least


def remembers(c: np.ndarray) -> bool:
    """Whether a law of those with coefficients `c` has a state that a motion or a longer time shapes."""
    return bool(np.any(c[[BOUC, VISCO, MODE, LAG_E, CREEP, LAG_S]] != 0))


def settled_sweep(
    ratios: np.ndarray, level: float, periods: int, gain: float, quality: float, c: np.ndarray, s: np.ndarray,
    geometry: np.ndarray,
) -> np.ndarray:  # fmt: skip
    """(k,) as `sweeps.sweep`, of which `periods` are followed only where Newton's method does not find the motion."""
    found, x = np.empty(len(ratios), complex), np.zeros(2)
    phase = np.pi / STEPS * np.arange(2 * STEPS * _REMEMBERED + 1)
    last = slice(2 * STEPS * (_REMEMBERED - 1), None)
    tone = np.exp(-1j * phase[:-1:2][:STEPS]) * 2j / STEPS  # 2i/N Σ sin(φ + a) e^{−iφ} = e^{ia}
    for k, ratio in enumerate(ratios):
        step = 2 * np.pi / (ratio * STEPS)
        e, de = level * np.sin(phase), level * ratio * np.cos(phase)
        u = gain * driven(e, de, ratio, step / 2, c, s)
        x, z = _orbit(x, u[last], e[last], step, periods, c, s, geometry, quality, _LOWEST * level)
        y = sensed(z, np.zeros_like(z), e[last][::2], np.zeros_like(z), step, c, s)
        found[k] = np.sum(y[:-1] * tone)
    return found


@njit(error_model="numpy")
def _orbit(x, u, e, step, periods, c, s, geometry, quality, lowest):
    """The state (z, ż) at the beginning of a period that repeats itself, and the displacement over it."""
    begun, state = x.copy(), np.zeros(STATES)
    for waited in range(2):
        closed = False
        for _ in range(_ROUNDS):
            state[:2] = x
            here = march(state, u, e, step, 1, 0.0, 1.0, c, s, geometry, quality)
            size = max(np.max(np.abs(here[0])), lowest)
            if not size < 1e3:
                break
            off = here[:2, -1] - x
            slope = np.empty((2, 2))
            for i in range(2):
                state[:2] = x
                state[i] += _OFF * size
                slope[:, i] = (march(state, u, e, step, 1, 0.0, 1.0, c, s, geometry, quality)[:2, -1]
                               - here[:2, -1]) / (_OFF * size)  # fmt: skip
            trace, det = slope[0, 0] + slope[1, 1], slope[0, 0] * slope[1, 1] - slope[0, 1] * slope[1, 0]
            if np.max(np.abs(off)) < _CLOSED * size:
                closed = abs(det) < 1 and abs(trace) < 1 + det  # both multipliers within the unit circle
                break
            left = 1 - trace + det  # of I − slope, to be inverted
            if left == 0:
                break
            x = x + np.array([
                ((1 - slope[1, 1]) * off[0] + slope[0, 1] * off[1]) / left,
                (slope[1, 0] * off[0] + (1 - slope[0, 0]) * off[1]) / left,
            ])  # fmt: skip
        if closed and (waited or np.max(np.abs(x - begun)) < _FAR * size):
            return x, here[0]
        if waited:
            break
        state[:2] = begun
        for _ in range(periods):
            state[:2] = march(state, u, e, step, 1, 0.0, 1.0, c, s, geometry, quality)[:2, -1]
        x = state[:2].copy()
        begun = x.copy()
    state[:2] = begun
    here = march(state, u, e, step, 1, 0.0, 1.0, c, s, geometry, quality)
    return here[:2, -1].copy(), here[0]
