"""What level 1.5 of the magnetic oscillator tells of level 0.5: `python -m experiments.real.magnetic_reach`.

Nothing here is `ident`: an oscillator whose stiffness and damping are polynomials of the amplitude A is fitted by SciPy,

    |ω0(A)² − ω² + i ω c(A)| A = g U,   ω0(A) = k₀ + Σ k_i A^i,   c(A) = Σ c_j A^j,

to level 1.5 alone, to 0.5 alone, and to 1.5 with a little of 0.5. Laws that level 1.5 does not tell apart disagree at 0.5.
"""

from __future__ import annotations

import csv
from dataclasses import dataclass

import numpy as np
from scipy.optimize import least_squares

from experiments import public_data

FITTED, JUDGED = 1.5, 0.5
START = {"k0": 37.9, "k2": 5.5, "c0": 0.45}  # Hz, of the largest amplitude of all levels
LITTLE = 0.1  # weight of a point of level 0.5 beside one of 1.5


@dataclass(frozen=True, eq=False)
class Level:
    """Points of a drive level: `frequency`, Hz; `amplitude`, of the largest of all levels."""

    drive: float
    frequency: np.ndarray
    amplitude: np.ndarray

    @property
    def peak(self) -> float:
        return float(np.max(self.amplitude))


@dataclass(frozen=True)
class Law:
    """Powers of the amplitude in the stiffness and in the damping, and their `numbers`, the drive's last, logarithmic."""

    stiffness: tuple[int, ...]
    damping: tuple[int, ...]
    numbers: np.ndarray

    def needed(self, frequency: np.ndarray, amplitude: np.ndarray) -> np.ndarray:
        """Logarithm of the drive, per unit of level, that answers at a frequency with an amplitude."""
        split = len(self.stiffness)
        powers = lambda which, numbers: sum(x * amplitude**p for x, p in zip(numbers, which, strict=True))
        k, c = powers(self.stiffness, self.numbers[:split]), powers(self.damping, self.numbers[split:-1])
        return np.log(np.abs(k * np.abs(k) - frequency**2 + 1j * frequency * c) * amplitude) - self.numbers[-1]

    def residuals(self, level: Level) -> np.ndarray:
        """(model − measured) to first order, of the level's peak."""
        step, f, a = 1e-3, level.frequency, level.amplitude
        off, above, below = (self.needed(f, a + side * step) - np.log(level.drive) for side in (0.0, 1.0, -1.0))
        slope = np.hypot(above - off, off - below) / (np.sqrt(2) * step)
        return off / np.maximum(slope, 1e-3) / level.peak

    def error(self, level: Level) -> float:
        """Per cent of the level's peak, between the points and the nearest response of the law."""
        tried = np.linspace(1e-4, 1.6, 6000)
        found = []
        for f, a in zip(level.frequency, level.amplitude, strict=True):
            off = self.needed(np.full_like(tried, f), tried) - np.log(level.drive)
            roots = tried[:-1][off[:-1] * off[1:] < 0]
            found.append(np.min(np.abs(roots - a)) if len(roots) else np.inf)
        return 100 * float(np.sqrt(np.mean(np.square(found)))) / level.peak


def fitted(levels: dict[Level, float], stiffness: tuple[int, ...], damping: tuple[int, ...]) -> Law:
    """The law with these powers that is nearest to some levels, each with its weight."""
    first = next(iter(levels))
    start = np.array([START.get(f"k{p}", 0.0) for p in stiffness] + [START.get(f"c{p}", 0.0) for p in damping] + [0.0])
    off = Law(stiffness, damping, start).needed(first.frequency, first.amplitude)
    start[-1] = np.median(off) - np.log(first.drive)

    def residuals(numbers: np.ndarray) -> np.ndarray:
        law = Law(stiffness, damping, numbers)
        return np.concatenate([np.clip(weight * law.residuals(level), -1, 1) for level, weight in levels.items()])

    found = least_squares(residuals, start, x_scale=np.maximum(0.02 * np.abs(start), 0.05), max_nfev=400)
    return Law(stiffness, damping, found.x)


def read() -> dict[float, Level]:
    """The levels of the table."""
    with (public_data.data_folder("magnetic_oscillator") / "frid_frf_4levels.csv").open(encoding="utf-8") as file:
        rows = np.array([[float(row[name] or "nan") for name in ("drive_level", "freq_Hz", "amp_V")]
                         for row in csv.DictReader(file)])  # fmt: skip
    rows = rows[np.isfinite(rows[:, 2])]
    largest = np.max(rows[:, 2])
    return {u: Level(u, *rows[rows[:, 0] == u][:, 1:].T / np.array([[1.0], [largest]])) for u in np.unique(rows[:, 0])}


def main() -> None:
    """Print and assert."""
    levels = read()
    taught, judged = levels[FITTED], levels[JUDGED]
    both = {taught: 1.0, judged: LITTLE}
    cases = {
        "cubic spring, linear damping": fitted({taught: 1.0}, (0, 2), (0,)),
        "and quintic spring": fitted({taught: 1.0}, (0, 2, 4), (0,)),
        "and damping v|v|": fitted({taught: 1.0}, (0, 2), (0, 1)),
        "and damping v³": fitted({taught: 1.0}, (0, 2), (0, 2)),
        "damping v|v| alone": fitted({taught: 1.0}, (0, 2), (1,)),
        "all powers, a little of 0.5": fitted(both, (0, 1, 2, 3, 4), (0, 1, 2, 3)),
        "cubic spring, linear damping, 0.5 alone": fitted({judged: 1.0}, (0, 2), (0,)),
    }
    n = len(taught.frequency)
    first, found = cases["cubic spring, linear damping"], {}
    chi2 = lambda law: float(np.sum(law.residuals(taught) ** 2))
    print(f"{'law':42} error at {FITTED:g} and {JUDGED:g}, % of peak   n ln(χ²/χ² of the first) + k ln n at {FITTED:g}")
    for name, law in cases.items():
        price = (len(law.numbers) - len(first.numbers)) * np.log(n)
        found[name] = law.error(taught), law.error(judged), n * np.log(chi2(law) / chi2(first)) + price
        print(f"{name:42} {found[name][0]:6.2f} {found[name][1]:6.2f} {found[name][2]:+10.1f}")


if __name__ == "__main__":
    main()
