"""A stepped sine, up and down, integrated through: the state is carried from each frequency to the next.

Dimensionless as in `experiments.hidden_effects.laws`, whose laws act here: time in 1/ω0, e in units of the largest
drive. Each frequency is held for a number of periods, and a lock-in takes the fundamental of the last of them.
"""

from __future__ import annotations

import numpy as np

from experiments.hidden_effects.laws import STATES, driven, march, sensed

STEPS = 64  # per period of the highest frequency
READ = 8  # periods over which the lock-in averages
HARMONICS = 7  # that it tells apart from the fundamental


def drive_phase(ratios: np.ndarray, periods: int) -> tuple[np.ndarray, np.ndarray, np.ndarray, float]:
    """Phase of the drive (rad), its frequency and the number of the point at every half step, and the step.

    The phase runs on where the frequency changes, as that of a generator does.

    **Arguments:** `ratios`: (k,) frequencies over ω0, in the order of the sweep; `periods`: how many each is held.
    """
    step = 2 * np.pi / (np.max(ratios) * STEPS)
    counts = np.ceil(2 * np.pi * periods / (ratios * step)).astype(int)
    point = np.append(np.repeat(np.arange(len(ratios)), 2 * counts), len(ratios) - 1)
    frequency = ratios[point]
    phase = np.concatenate([[0.0], np.cumsum(frequency[:-1] * step / 2)])
    return phase, frequency, point, step


def fundamental(signal: np.ndarray, phase: np.ndarray) -> complex:
    """A e^{iφ} of signal = A sin(phase + φ) + a mean and harmonics, by least squares."""
    basis = [np.ones_like(phase)]
    for k in range(1, HARMONICS + 1):
        basis += [np.sin(k * phase), np.cos(k * phase)]
    weights = np.linalg.lstsq(np.stack(basis, 1), signal, rcond=None)[0]
    return complex(weights[1], weights[2])


def sweep(
    ratios: np.ndarray, level: float, periods: int, gain: float, quality: float, c: np.ndarray, s: np.ndarray,
    geometry: np.ndarray,
) -> np.ndarray:  # fmt: skip
    """(k,) fundamental of what the sensor reads, relative to the drive e = level sin(…), from rest.

    **Arguments:** `c`, `s`: coefficients (laws,) and shape numbers (laws, 3); `geometry`: as `laws.force` takes it.
    """
    phase, frequency, point, step = drive_phase(ratios, periods)
    e, de = level * np.sin(phase), level * frequency * np.cos(phase)
    u = gain * driven(e, de, frequency, step / 2, c, s)  # type: ignore[arg-type]  # the frequency of every half step
    z, _, mode = march(np.zeros(STATES), u, e, step, 1, 0.0, 1.0, c, s, geometry, quality)
    y = sensed(z, mode, e[::2], np.zeros(len(z)), step, c, s)
    found = np.empty(len(ratios), complex)
    steps = point[::2]
    for k, ratio in enumerate(ratios):
        last = int(np.flatnonzero(steps == k)[-1])
        window = slice(last - round(READ * 2 * np.pi / (ratio * step)), last)
        found[k] = fundamental(y[window], phase[::2][window])
    return found
