"""The linear oscillator nearest to amplitude-frequency curves: from their peaks, or from all complex points at once.

    |ω0² − ω² + iωω0/Q| A = G U

holds at every point of a linear device. Where phases were measured the equation is linear in ω0², ω0/Q and G, and one
least-squares solution is the answer; where not, the peak of the weakest level and its half-power width begin a search.

Source: D. J. Ewins, Modal Testing, 2000, §4.2 (half-power width); the equation is M. Levi's, W. Levy, Complex-curve
fitting, IRE Trans. Automatic Control 4 (1959) 37, for one mode.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import lru_cache

import numpy as np
from scipy import optimize

from ...campaign.record import Sweep, same_level
from .guess import LEAST_QUALITY, DataScales, LinearGuess

_HALF_POWER = math.sqrt(0.5)
_MOST_QUALITY = 1e6
_RING_UPS = 100.0  # periods that stand for the duration of a record, where a curve has none


def guess_curves(sweeps: Sequence[Sweep], held: float | None = None) -> LinearGuess:
    """The linear oscillator nearest to the curves; `held`: its quality factor, if that is known."""
    return _searched(tuple(sweeps), held)


@lru_cache(maxsize=32)  # every model of a campaign starts from it
def _searched(sweeps: tuple[Sweep, ...], held: float | None) -> LinearGuess:
    frequency, quality = _peak(sweeps)
    join = lambda name: np.concatenate([np.asarray(getattr(sweep, name), float) for sweep in sweeps])
    omega, level, amplitude = 2 * np.pi * join("frequency"), join("acting"), join("amplitude")
    weight = np.minimum(amplitude / np.maximum(join("deviation"), 1e-300), 1e3)
    weight = weight / np.max(weight)

    def logarithms(x: np.ndarray) -> np.ndarray:
        own, q = math.exp(x[0]), math.exp(x[1]) if held is None else held
        return np.log(amplitude * np.hypot(own**2 - omega**2, omega * own / q) / level)

    def left(x: np.ndarray) -> np.ndarray:
        off = logarithms(x)
        return weight * (off - np.average(off, weights=weight**2))

    ends = (
        (math.log(np.min(omega) / 2), math.log(np.max(omega) * 2)),
        (math.log(LEAST_QUALITY), math.log(_MOST_QUALITY)),
    )
    starts = [(frequency, quality), (frequency, 3 * quality), (frequency, quality / 3)]
    found = []
    for f, q in starts:
        x = np.clip(
            [math.log(2 * np.pi * f), math.log(q)], [ends[0][0] + 1e-6, ends[1][0] + 1e-6], [ends[0][1], ends[1][1]]
        )
        found.append(optimize.least_squares(left, x, bounds=np.array(ends).T, loss="soft_l1", f_scale=0.05))
    best = min(found, key=lambda one: one.cost)
    gain = math.exp(np.average(logarithms(best.x), weights=weight**2))
    quality = math.exp(best.x[1]) if held is None else held
    misfit = math.sqrt(float(np.mean(left(best.x) ** 2)))
    return LinearGuess(math.exp(best.x[0]) / (2 * np.pi), quality, gain * _sign(sweeps, math.exp(best.x[0])), misfit)


def _peak(sweeps: Sequence[Sweep]) -> tuple[float, float]:
    """Frequency (Hz) of the peak of the weakest level, and its quality factor by the half-power width."""
    sweep = min(sweeps, key=lambda s: float(np.min(s.level)))
    rows = same_level(sweep.level)[0]
    rows = rows[np.argsort(sweep.frequency[rows], kind="stable")]
    f, a = sweep.frequency[rows], sweep.amplitude[rows]
    top = int(np.argmax(a))
    high = np.flatnonzero(a >= _HALF_POWER * a[top])
    width = max(float(f[high[-1]] - f[high[0]]), float(np.median(np.diff(np.unique(f)))))
    return float(f[top]), float(np.clip(f[top] / width, 2 * LEAST_QUALITY, 1e4))


def _sign(sweeps: Sequence[Sweep], omega: float) -> float:
    """Sign of the gain: below resonance the response goes with the drive, or against it."""
    total = 0.0
    for sweep in sweeps:
        if sweep.phase is not None:
            below = (2 * np.pi * sweep.frequency < omega) * 2.0 - 1.0
            total += float(np.sum(below * sweep.amplitude / sweep.acting * np.cos(sweep.phase)))
    return -1.0 if total < 0 else 1.0


def curve_scales(sweeps: Sequence[Sweep], frequency: float) -> DataScales:
    """The largest values in the curves, by which shape parameters are placed."""
    largest = lambda values: max(float(np.max(v)) for v in values)
    displacement = largest(s.amplitude for s in sweeps)
    velocity = largest(2 * np.pi * s.frequency * s.amplitude for s in sweeps)
    voltage = largest(s.acting for s in sweeps)
    slew = largest(2 * np.pi * s.frequency * s.acting for s in sweeps) / np.sqrt(2)
    return DataScales(displacement, velocity, voltage, 1 / frequency, _RING_UPS / frequency, slew)


def joined_scales(one: DataScales, other: DataScales) -> DataScales:
    """The larger of two of each; the durations of traces."""
    larger = {
        name: max(getattr(one, name), getattr(other, name)) for name in ("displacement", "velocity", "voltage", "slew")
    }
    return one._replace(**larger)
