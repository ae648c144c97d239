"""Curves for tests: the Duffing oscillator by the method of averaging, followed up and down along its branches."""

from __future__ import annotations

from pathlib import Path

import numpy as np

RESONANCE, QUALITY = 500.0, 40.0


def duffing(
    level: float, frequency: np.ndarray, cubic: float = 0.1, resonance: float = RESONANCE, quality: float = QUALITY
) -> np.ndarray:
    """(n,) complex amplitudes at frequencies in the order of the sweep; the linear peak at level 1 is 1.

    a²[(1 + ¾ c a² − r²)² + (r/Q)²] = (level/Q)²; the root nearest to the last amplitude is followed.

    Source: A. H. Nayfeh, D. T. Mook, Nonlinear Oscillations, 1979, §4.1.1.
    """
    found, last = [], 0.0
    for f in frequency:
        r, k = f / resonance, 0.75 * cubic
        square = [k**2, 2 * k * (1 - r**2), (1 - r**2) ** 2 + (r / quality) ** 2, -((level / quality) ** 2)]
        roots = np.roots(square if cubic else square[2:])
        real = np.sqrt(np.sort(roots[np.abs(roots.imag) < 1e-9].real))
        last = real[0] if len(real) == 1 else min((real[0], real[-1]), key=lambda a: abs(a - last))
        found.append(last * np.exp(-1j * np.angle(1 + k * last**2 - r**2 + 1j * r / quality)))
    return np.array(found)


def both_ways(levels: tuple[float, ...], frequency: np.ndarray, cubic: float = 0.1) -> tuple[np.ndarray, ...]:
    """Frequencies, levels, up (bool) and complex amplitudes of sweeps up and then down at each level."""
    columns = []
    for level in levels:
        for up in (True, False):
            f = frequency if up else frequency[::-1]
            columns.append((f, np.full(len(f), level), np.full(len(f), up), duffing(level, f, cubic)))
    f, level, up, response = (np.concatenate(part) for part in zip(*columns, strict=True))
    return f, level, up, response


def write_table(path: Path, header: str, columns: list[np.ndarray], separator: str = ",") -> Path:
    rows = "\n".join(separator.join(f"{x:.9g}" for x in row) for row in zip(*columns, strict=True))
    path.write_text(f"{header}\n{rows}\n", encoding="utf-8")
    return path
