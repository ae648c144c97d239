"""Which points of a sweep had settled, as far as the sweeps themselves tell.

Where a branch ends, a motion settles as slowly as one likes: the last point before the fold creeps towards it, the
first one beyond it lingers beside a branch that is no longer there, and what has left it swings past the other before
it comes to rest. Whatever the dwell, the points beside a jump are the ones that had most need of a longer one.

So it is where a curve is about to fold: its flank is steep, nothing jumps, and the motion creeps. There it comes from
below on the way up and from above on the way down, and the two ways differ. Where none of them jumps, no two branches
can be the reason.

Source: S. H. Strogatz, Nonlinear Dynamics and Chaos, 1994, §4.3 (the bottleneck that a fold leaves behind), §3.4
(critical slowing down).
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy.special import ndtri

from ..record import Run, Sweep
from .jump import jump_of

_BY_CHANCE = 0.002  # that any point of a run leaves its way back so far by noise


def settled(sweep: Sweep, group: Sequence[Sweep] = ()) -> np.ndarray:
    """(n,) bool: all points but those on either side of a jump and within it, and those that a way back contradicts.

    `group`: sweeps of the same device, one of which may hold the way back.
    """
    found = np.ones(len(sweep.frequency), bool)
    if sweep.fast:  # it is simulated as it was run
        return found
    for run in sweep.runs:
        jump = jump_of(sweep, run.rising)
        if jump is not None:
            found[run.rising[jump.low : jump.high + 1]] = False
        elif sweep.dwell is None:  # a fast sweep lags everywhere
            others = (one for one in group if one is not sweep and one.load == sweep.load and not one.fast)
            for other in (sweep, *others):
                for back in other.runs:
                    if back.is_back_of(run) and jump_of(other, back.rows) is None:
                        found[run.rows] &= ~_contradicted(sweep, run, other, back)
    return found


def _contradicted(sweep: Sweep, run: Run, other: Sweep, back: Run) -> np.ndarray:
    """(k,) bool: points of a run whose amplitude at the same frequency differs on the way back by more than noise."""
    f, there = sweep.frequency[run.rows], other.frequency[back.rows]
    same = np.isclose(f[:, None], there, rtol=1e-6)
    nearest = back.rows[np.argmax(same, axis=1)]
    a, b = sweep.amplitude[run.rows], other.amplitude[nearest]
    noise = np.hypot(sweep.deviation[run.rows], other.deviation[nearest])
    return np.any(same, axis=1) & (np.abs(a - b) > -ndtri(_BY_CHANCE / (2 * len(f))) * noise)
