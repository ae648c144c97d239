"""Is the named law the device's own? What the named effects leave, if it still has a structure.

No law of a library has exactly the shape of a device's: the right one leaves a little, an impostor leaves more. Of the
first excess, right ones left up to 0.07 % (with two exceptions, 0.15 and 0.19 %), impostors 0.2 to 0.6 %, on devices
whose laws differ from the library's (`experiments/hidden_effects`, seeds 100 and 101). A law of the same coordinate and
nearly the same shape (Stribeck's friction, called Coulomb's) leaves as little as a right one, 0.02 to 0.09 %. The bound
is on the careful side: a doubt costs less than a wrong name.
"""

from __future__ import annotations

from collections.abc import Callable

from .colour_test import chance_of
from .score import Bench
from .stage import set_stage
from .subsets import TRIED, rank, regress, smallest_sufficient, spline_rows

_DOUBT = 0.0001  # of the first excess: structured misfit beyond which a law may be another of the same kind
_CHANCE = 1e-3


def lacking(bench: Bench, first: Bench, report: Callable[[str], None] = lambda _: None) -> float:
    """Share of the first excess that functions of the device's coordinates still find in what the effects leave.

    0 if it is within `_DOUBT`, or likely by chance (coloured noise allowed for).
    """
    excess = max(first.chi2 - first.n, 1e-9)
    report("does what is left have a structure?")
    stage = set_stage(bench)
    found = smallest_sufficient(rank(bench, stage))[0]
    share = (found.drop - found.dof) / excess
    if share < _DOUBT:
        return 0.0
    rows = spline_rows(bench, stage, found.side, found.coordinates)
    solved = regress(rows, bench.residual)
    return share if TRIED * chance_of(bench, rows.T @ solved.spread) < _CHANCE else 0.0
