"""A look at curves with phase before any fit: what stiffness and what damping each measured point had.

A drive U and a response Z of a motion that is nearly a sine give the dynamic stiffness D = U/Z. For a mass, a spring
and a damper whose laws depend on displacement and velocity,

    Re D / β + ω² = Ω²(|Z|),     Im D / (β ω) = Γ(ω |Z|),

so that the curves of all levels fall on two, whose bends show the restoring and the damping law: Ω/2π is the backbone
curve, Γ = Ω/Q the damping rate. What depends on anything else, the level or the frequency, keeps the levels apart.

Source: T. Breunung, B. Balachandran, Frequency response based identification of nonlinear oscillators, J. Sound Vib.
2024, 118651, §2 (balance of the measured harmonics).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TypeVar

import numpy as np

from ..record import Sweep

Found = TypeVar("Found")
_INTERVALS = (6, 12, 24, 48)
"""Of the cubic splines through all levels. Laws of an amplitude are smooth, but for a bend or two; a stop bends one so
sharply that coarse splines keep levels apart that fall on one curve. Schwarz's criterion chooses, Annals of Statistics
6 (1978) 461."""


@dataclass(frozen=True, eq=False)
class LawCurve:
    """One of the two pictures: a quantity against an amplitude, with the curve through all levels.

    **Arguments:** `amplitude`, `value`, `deviation`, `level`: (n,) of the measured points; `at`, `curve`: (k,)
    the common curve; `misfit`: rms distance of the points from it, in their noise (in both directions).
    """

    amplitude: np.ndarray
    value: np.ndarray
    deviation: np.ndarray
    level: np.ndarray
    at: np.ndarray
    curve: np.ndarray
    misfit: float

    @property
    def bend(self) -> float:
        """Change of the common curve from its weakest to its strongest amplitude, as a fraction of its mean."""
        return float((self.curve[-1] - self.curve[0]) / np.mean(self.curve))


@dataclass(frozen=True, eq=False)
class DynamicStiffness:
    """`stiffness`: Ω/2π (Hz) against |Z| (m); `damping`: Γ (1/s) against ω|Z| (m/s); `slope`: β, V s²/m."""

    stiffness: LawCurve
    damping: LawCurve
    slope: float


def dynamic_stiffness(sweeps: Sequence[Sweep]) -> DynamicStiffness | None:
    """The two curves of all settled sweeps with phase that carry the same load; None without a phase or with too few
    points.

    β is what Re D loses with ω² at one and the same amplitude, so that no law is assumed to find it.
    """
    settled = [s for s in sweeps if s.phase is not None and not s.fast]
    used = [s for s in settled if s.quantity == "fundamental" and s.load == sweeps[0].load]
    if not used:
        return None
    f, level, a, phase, da, dp = (
        np.concatenate(parts)
        for parts in zip(
            *((s.frequency, s.level, s.amplitude, s.phase, s.deviation, s.phase_deviation) for s in used), strict=True
        )
    )
    good = (a > 5 * da) & (dp < 0.2)  # 1/Z is linear in the noise there
    f, level, a, phase, da, dp = (x[good] for x in (f, level, a, phase, da, dp))
    if len(f) < 5 * _INTERVALS[0]:
        return None
    omega = 2 * np.pi * f
    stiffness = level / a * np.exp(-1j * phase)
    along, across = np.abs(stiffness) * da / a, np.abs(stiffness) * dp
    cos2 = np.cos(phase) ** 2
    real_error = np.sqrt(cos2 * along**2 + (1 - cos2) * across**2)
    imaginary_error = np.sqrt((1 - cos2) * along**2 + cos2 * across**2)

    def slope(intervals: int) -> tuple[np.ndarray, np.ndarray, float]:
        at = np.linspace(float(np.min(a)), float(np.max(a)), 200)
        basis, shown, total = _splines(a, a, intervals), _splines(at, a, intervals), real_error
        scale, weights = np.mean(omega**2), np.zeros(basis.shape[1] + 1)
        columns = np.column_stack([basis, -(omega**2) / scale])
        for _ in range(2):  # the noise of the amplitude counts as much as the law is steep
            weights = np.linalg.lstsq(columns / total[:, None], stiffness.real / total, rcond=None)[0]
            total = np.hypot(real_error, da * np.interp(a, at, np.gradient(shown @ weights[:-1], at)))
        return stiffness.real - columns @ weights, total, float(weights[-1] / scale)

    beta = _best(slope, len(a))
    square = stiffness.real / beta + omega**2
    if beta == 0.0 or np.any(square <= 0):
        return None
    natural = np.sqrt(square) / (2 * np.pi)
    stiff = _curve(a, natural, real_error / abs(beta) / (8 * np.pi**2 * natural), da, level)
    damping = _curve(
        omega * a, stiffness.imag / (beta * omega), imaginary_error / (abs(beta) * omega), omega * da, level
    )
    return DynamicStiffness(stiff, damping, beta)


def _best(found: Callable[[int], tuple[np.ndarray, np.ndarray, Found]], n: int) -> Found:
    """What is found with the number of intervals that n points ask for; `found` gives what is left of them, and its
    deviations, beside it."""

    def price(intervals: int, left: np.ndarray, deviation: np.ndarray) -> float:
        chi2 = max(float(np.sum((left / deviation) ** 2)), 1e-300)
        return n * np.log(chi2) + 2 * float(np.sum(np.log(deviation))) + intervals * np.log(n)

    tried = [(intervals, *found(intervals)) for intervals in _INTERVALS if 5 * intervals <= n]
    return min(tried, key=lambda one: price(*one[:3]))[3]


def _splines(x: np.ndarray, over: np.ndarray, intervals: int) -> np.ndarray:
    """(n, at most intervals + 3) cubic B-splines at x, on evenly spaced knots over the range of `over`: a bend at large
    amplitudes, where few points are, is seen too. Where no points are (jumps) one piece bridges."""
    even = np.linspace(float(np.min(over)), float(np.max(over)), intervals + 1)
    held = np.histogram(over, even)[0][:-1] > 0
    knots = np.concatenate([even[:1], even[1:-1][held], even[-1:]])
    padded = np.concatenate([np.repeat(knots[0], 3), knots, np.repeat(knots[-1], 3)])
    from scipy.interpolate import BSpline  # here, because its import costs more than reading a campaign

    return BSpline.design_matrix(np.clip(x, knots[0], knots[-1]), padded, 3).toarray()


def _curve(x: np.ndarray, y: np.ndarray, error: np.ndarray, x_error: np.ndarray, level: np.ndarray) -> LawCurve:
    """The common curve; the noise of the amplitude counts as much as the curve is steep."""
    at = np.linspace(float(np.min(x)), float(np.max(x)), 200)

    def through(intervals: int) -> tuple[np.ndarray, np.ndarray, LawCurve]:
        basis, shown, total = _splines(x, x, intervals), _splines(at, x, intervals), error
        weights = np.zeros(basis.shape[1])
        for _ in range(2):
            weights = np.linalg.lstsq(basis / total[:, None], y / total, rcond=None)[0]
            slope = np.interp(x, at, np.gradient(shown @ weights, at))
            total = np.hypot(error, slope * x_error)
        left = y - basis @ weights
        misfit = np.sqrt(np.sum((left / total) ** 2) / max(len(x) - basis.shape[1], 1))
        return left, total, LawCurve(x, y, error, level, at, shown @ weights, float(misfit))

    return _best(through, len(x))
