"""Modes of free decays: each rings by itself, and only where it rings and how fast it fades is common to all records.

Source: D. J. Ewins, Modal Testing, 2000, §4.6 (complex exponentials: a free decay as a sum of them).
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from .decay import read_ringing
from .stretches import Stretch, free_motion


def next_line(stretches: Sequence[Stretch], points: np.ndarray) -> np.ndarray | None:
    """ln f and ln Q of the strongest line in what the modes at `points`, (k, 2), leave of the decays; None if nothing
    else rings."""
    left = [stretch.response - _fitted(stretch, points)[1] for stretch in stretches]
    loudest = int(np.argmax([float(x @ x) for x in left]))
    found = read_ringing(left[loudest], stretches[loudest].step)
    return None if found is None else np.log([found.frequency, found.quality])


def amplitudes(stretches: Sequence[Stretch], points: np.ndarray) -> np.ndarray:
    """The largest amplitude with which each mode begins, (k,), in the unit of the response."""
    begun = np.array([stretch.size * _fitted(stretch, points)[0] for stretch in stretches])
    return np.max(begun, axis=0)


def _fitted(stretch: Stretch, points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Amplitudes (k,) with which the modes begin, and their sum with a constant, (n,)."""
    columns = [free_motion(stretch, *map(float, np.exp(point))) for point in points]
    rows = np.hstack([*columns, np.ones((len(stretch.response), 1))])
    found = np.linalg.lstsq(rows, stretch.response, rcond=None)[0]
    return np.hypot(found[:-1:2], found[1:-1:2]), rows @ found
