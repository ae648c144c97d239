"""Harmonics of curves in a fit: what each says of the response with the amplitude that was measured.

    r = (E|H + n| − A)/s,   s² = Var|H + n| + ¼ (|H(A₁ + σ₁)| − |H(A₁ − σ₁)|)²

with the model's harmonic H at the measured amplitude A₁, the noise n of the harmonic, whose amplitude is never read as
nothing (`campaign.sweeps.rice`), and what the noise of A₁ does to H. s is renewed between searches.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from ..campaign.record import Sweep
from ..campaign.sweeps.rice import read_beside


@dataclass(frozen=True, eq=False)
class Heard:
    """Harmonics of some `orders` at points of curves.

    **Arguments:** (orders, points) `amplitude`, m, NaN where it was not measured; `noise` of its real part; and the
    `deviation` by which it counts.
    """

    orders: tuple[int, ...]
    amplitude: np.ndarray
    noise: np.ndarray
    deviation: np.ndarray

    @property
    def known(self) -> np.ndarray:
        """(orders, points) whether it was measured."""
        return np.isfinite(self.amplitude)

    @property
    def count(self) -> int:
        """How many numbers were measured."""
        return int(np.count_nonzero(self.known))

    def places(self, points: np.ndarray) -> np.ndarray:
        """Which of the numbers are those of some points."""
        number = np.cumsum(self.known.ravel()).reshape(self.known.shape) - 1
        return number[:, points][self.known[:, points]]

    def residuals(self, harmonics: np.ndarray) -> np.ndarray:
        """(count,) (model − measured) in noise floors, of the model's harmonics (orders, points), m."""
        mean, _, _ = read_beside(np.abs(harmonics), self.noise)
        return ((mean - self.amplitude) / self.deviation)[self.known]

    def slopes(self, harmonics: np.ndarray, change: np.ndarray) -> np.ndarray:
        """How the residuals change with changes of the harmonics, (orders, d, points): (d, count)."""
        size = np.abs(harmonics)
        _, slope, _ = read_beside(size, self.noise)
        along = np.real(np.conj(harmonics)[:, None] * change) / np.maximum(size, 1e-300)[:, None]
        rows = np.moveaxis(along * (slope / self.deviation)[:, None], 1, 0)
        return rows[:, self.known]

    def weighed(self, here: np.ndarray, above: np.ndarray, below: np.ndarray) -> Heard:
        """The same with the noise as it is beside a model's harmonics, (orders, points), and beside those at amplitudes
        that are larger and smaller by theirs."""
        _, _, spread = read_beside(np.abs(here), self.noise)
        moved = np.nan_to_num(0.5 * (np.abs(above) - np.abs(below)))
        return replace(self, deviation=np.where(np.isfinite(spread), np.hypot(spread, moved), self.noise))


def lay_overtones(sweeps: Sequence[Sweep], kept: Sequence[np.ndarray]) -> Heard:
    """The harmonics of those points of sweeps that are kept, (n,) bool each."""
    orders = tuple(sorted({one.order for sweep in sweeps for one in sweep.overtones}))
    count = sum(int(np.count_nonzero(rows)) for rows in kept)
    amplitude, noise, first = np.full((len(orders), count), np.nan), np.ones((len(orders), count)), 0
    for sweep, rows in zip(sweeps, kept, strict=True):
        own = slice(first, first + int(np.count_nonzero(rows)))
        for one in sweep.overtones:
            k = orders.index(one.order)
            amplitude[k, own], noise[k, own] = one.amplitude[rows], one.noise[rows]
        first = own.stop
    return Heard(orders, amplitude, noise, noise)
