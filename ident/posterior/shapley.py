"""Sharing an effect fairly among its causes, when causes act together.

    φ_i = Σ_{S ∌ i} |S|! (m − |S| − 1)!/m! · [v(S ∪ {i}) − v(S)]

The mean over all orders in which the mechanisms could be switched on of what switching on number i brings. Shares add
up to v(all) − v(none), and a mechanism that never changes anything gets nothing.

Source: L. S. Shapley, A value for n-person games, in Contributions to the Theory of Games II, 1953, 307.
"""

from __future__ import annotations

from itertools import combinations
from math import factorial

import numpy as np


def subsets(count: int) -> list[tuple[int, ...]]:
    """All subsets of so many mechanisms, the empty one first and the full one last."""
    return [chosen for size in range(count + 1) for chosen in combinations(range(count), size)]


def shapley(values: dict[tuple[int, ...], np.ndarray], count: int) -> np.ndarray:
    """(count, ...) shares of v(all) − v(none); `values`: v of each subset, arrays of one shape."""
    found = []
    for i in range(count):
        total = np.zeros_like(values[()])
        for chosen in subsets(count):
            if i not in chosen:
                weight = factorial(len(chosen)) * factorial(count - len(chosen) - 1) / factorial(count)
                total = total + weight * (values[tuple(sorted((*chosen, i)))] - values[chosen])
        found.append(total)
    return np.array(found)
