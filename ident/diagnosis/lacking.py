"""Is the named law the device's own? What the named effects leave, if it still has a structure.

No law of a library has exactly the shape of a device's: the right one leaves a little, an impostor leaves more. Of the
first excess, right ones left up to 0.07 % (with two exceptions, 0.15 and 0.19 %), impostors 0.2 to 0.6 %, on devices
whose laws differ from the library's (`experiments/hidden_effects`, seeds 100 and 101). The bound is on the careful
side: a doubt costs less than a wrong name.
"""

from __future__ import annotations

from collections.abc import Callable

from .colour_test import chance_of
from .enough import ANOTHER_LAW
from .score import Bench
from .stage import set_stage
from .subsets import TRIED, rank, regress, smallest_sufficient, spline_rows

_CHANCE = 1e-3


def lacking(bench: Bench, first: Bench, report: Callable[[str], None] = lambda _: None) -> float:
    """Share of the first excess that functions of the device's coordinates still find in what the effects leave.

    0 if what is left is within the noise, within `ANOTHER_LAW`, or likely by chance (coloured noise allowed for).
    """
    excess = max(first.chi2 - first.n, 1e-9)
    if bench.chi2 - bench.n < ANOTHER_LAW * excess:
        return 0.0
    report("does what is left have a structure?")
    stage = set_stage(bench)
    found = smallest_sufficient(rank(bench, stage))[0]
    share = (found.drop - found.dof) / excess
    if share < ANOTHER_LAW:
        return 0.0
    rows = spline_rows(bench, stage, found.side, found.coordinates)
    solved = regress(rows, bench.residual)
    return share if TRIED * chance_of(bench, rows.T @ solved.spread) < _CHANCE else 0.0
