"""Which points of a sweep had settled, as far as the sweep itself tells.

Where a branch ends, a motion settles as slowly as one likes: the last point before the fold creeps towards it, the
first one beyond it lingers beside a branch that is no longer there, and what has left it swings past the other before
it comes to rest. Whatever the dwell, the points beside a jump are the ones that had most need of a longer one.

Source: S. H. Strogatz, Nonlinear Dynamics and Chaos, 1994, §4.3 (the bottleneck that a fold leaves behind).
"""

from __future__ import annotations

import numpy as np

from .jump import jump_of
from .record import Sweep


def settled(sweep: Sweep) -> np.ndarray:
    """(n,) bool: all points but those on either side of a jump and within it."""
    found = np.ones(len(sweep.frequency), bool)
    for run in sweep.runs:
        rows = run.rows if run.up else run.rows[::-1]
        jump = jump_of(sweep, rows)
        if jump is not None:
            found[rows[jump.low : jump.high + 1]] = False
    return found
