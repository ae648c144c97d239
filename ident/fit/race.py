"""Several starts of one search: ever fewer go on.

After a few steps the worse half stops, after twice as many steps the worse half of the rest, and so on; the last one
goes on to its end. Which basin a start has found shows early; where in it the minimum lies is asked of one alone.

Source: Z. Karnin, T. Koren, O. Somekh, Almost optimal exploration in multi-armed bandits, ICML 2013, §3 (successive
halving).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from .solve import Search

FIRST = 3  # steps before the first half stops: the damping has then found its size, and the cost its order

GoOn = Callable[[int, Search, int], None]
"""Lets a search, the first, second … of all, go on until it has taken so many steps."""


def race(searches: Sequence[Search], most: int, go_on: GoOn) -> None:
    """Let searches go on, ever fewer of them, the last one until it has ended or taken `most` steps."""
    field, steps = list(enumerate(searches, 1)), FIRST
    while len(field) > 1 and steps < most:
        for number, one in field:
            go_on(number, one, steps)
        field = sorted(field, key=lambda one: cost_of(one[1]))[: (len(field) + 1) // 2]
        steps *= 2
    for number, one in field:
        go_on(number, one, most)


def cost_of(search: Search) -> float:
    """Σ r² where a search is, infinite for a motion without bound: such a one comes last."""
    return search.cost if np.isfinite(search.cost) else np.inf
