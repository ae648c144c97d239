"""What a pass and its way back over the same frequencies differ by, as a measure of their noise.

Two readings at one frequency need no curve between them: their difference is noise alone, wherever both passes lie on
one branch. If the device has changed between the passes they differ by more than neighbouring points scatter;
`repeatability` says so, and they are none.
"""

from __future__ import annotations

from functools import reduce

import numpy as np

from ..record import Run, Sweep
from .jump import on_two_branches
from .repeatability import CLEAR
from .variances import USUAL, Scatter, shares


def way_back(sweep: Sweep, variances: np.ndarray) -> Scatter | None:
    """The differences of passes up and down at each level, relative to the amplitude; None where there are none, or
    they are larger than `variances`, (3,) of σ, r and σ_φ, explain."""
    if sweep.dwell is not None:  # a fast sweep differs from its way back by physics
        return None
    pairs = [(a, b) for a in sweep.runs for b in sweep.runs if a.up and b.is_back_of(a)]
    found = [one for a, b in pairs if (one := _differences(sweep, a, b)) is not None]
    if not found:
        return None
    whole = reduce(Scatter.beside, found)
    expected = np.maximum(whole.share @ variances, 1e-300)
    return whole if float(np.median(whole.squared / expected)) < CLEAR * USUAL else None


def _differences(sweep: Sweep, up: Run, down: Run) -> Scatter | None:
    same = np.isclose(sweep.frequency[up.rows][:, None], sweep.frequency[down.rows], rtol=1e-6)
    here, there = up.rows[np.any(same, axis=1)], down.rows[np.argmax(same, axis=1)[np.any(same, axis=1)]]
    a, b = sweep.amplitude[here], sweep.amplitude[there]
    apart = on_two_branches(a, b)
    here, there, size = here[~apart], there[~apart], 0.5 * (a + b)[~apart]
    if not len(here) or not np.all(size > 0):
        return None
    turn = np.zeros(len(here)) if sweep.phase is None else sweep.phase[here] - sweep.phase[there]
    first, second = sweep.amplitude[here] / size, sweep.amplitude[there] / size * np.exp(-1j * turn)
    sizes = np.column_stack([sweep.amplitude[here], sweep.amplitude[there]])
    along, across = shares(np.column_stack([first, -second]), sizes)
    squared, share = (first - second).real ** 2, along
    if sweep.phase is not None:
        squared = np.concatenate([squared, (first - second).imag ** 2])
        share = np.concatenate([share, across])
    return Scatter(squared, share, np.ones(len(squared)))
