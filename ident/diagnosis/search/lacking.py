"""Is the named law the device's own? What the named effects leave, if it still has a structure.

No law of a library has exactly the shape of a device's: the right one leaves a little, an impostor leaves more. Of the
first excess, right ones left up to 0.07 % (with two exceptions, 0.15 and 0.19 %), impostors 0.2 to 0.6 %, on devices
whose laws differ from the library's (`experiments/hidden_effects`, seeds 100 and 101). A law of the same coordinate and
nearly the same shape (Stribeck's friction, called Coulomb's) leaves as little as a right one, 0.02 to 0.09 %. The bound
is on the careful side: a doubt costs less than a wrong name. Less still is seen of a curve over the law's own
coordinates, which is one question and not as many as there are sets of coordinates.
"""

from __future__ import annotations

import numpy as np
from scipy.special import chdtri  # not `scipy.stats`, whose import takes half a second

from ...effects.dependence import Side, depends_on
from ...pulse import Report
from ..evidence.coloured_noise import chance_of
from ..evidence.criterion import Left, clearly_better
from ..evidence.enough import ANOTHER_LAW
from ..linearised.regression import Regression
from ..unknown.coordinates import Stage, set_stage
from ..unknown.subsets import TRIED, Block, blocks_of, rank, regress, smallest_sufficient, spline_rows

_DOUBT = 0.0001  # of the first excess: structured misfit beyond which a law may be another of the same kind
_ANOTHER_CURVE = 0.00002  # the same for a curve over the law's own coordinates, one test instead of many
_CHANCE = 1e-3  # by which noise of that colour has such a structure, all that were tried together


def lacking(regression: Regression, first: Regression, report: Report = lambda _: None) -> float:
    """Share of the first excess that functions of the device's coordinates still find in what the effects leave.

    0 if it is little, or likely by chance (coloured noise allowed for); and of sweeps, whose points are no motion.
    """
    if not regression.trajectories.tape.spans:
        return 0.0
    regression, first = regression.of_traces(), first.of_traces()
    excess = first.above_noise
    report("does what is left have a structure?")
    stage, ranked = rank(regression)
    found = smallest_sufficient(ranked)[0]
    share = _structure(regression, stage, found.side, found.blocks, TRIED) / excess
    if share >= _DOUBT:
        return share
    laws = [law for law in _laws_of(regression) if law is not None]
    curves = [_structure(regression, stage, law[0], blocks_of(law[1]), len(laws)) / excess for law in laws]
    return max((share for share in curves if share >= _ANOTHER_CURVE), default=0.0)


def leaves_no_structure(regression: Regression, met: Regression) -> bool:
    """Whether what a model leaves has no structure, where a share `ANOTHER_LAW` of what its last terms met would show;
    `met`: the regression before them.

    Chance alone decides how little of a structure shows: that asks for no level of noise, which is never known so
    well.
    """
    if not regression.trajectories.tape.spans:
        return False
    regression, met = regression.of_traces(), met.of_traces()
    found = smallest_sufficient(rank(regression)[1])[0]
    shows = float(chdtri(found.dof, _CHANCE / TRIED))
    return shows < ANOTHER_LAW * met.excess and lacking(regression, met) < ANOTHER_LAW


def says_more_than_shapes(regression: Regression, met: Regression) -> bool:
    """Whether the last terms of a model clearly say more than any functions of the coordinates of the laws before them
    do, along the motion that was measured: however those were bent, they would not say it. The functions pay no price
    for their many numbers, but for what these take from noise. `met`: the regression before those terms. No answer
    where one of the laws has a memory, or three coordinates."""
    if not regression.trajectories.tape.spans:
        return False
    regression, met = regression.of_traces(), met.of_traces()
    laws = _laws_of(met)
    if not laws or None in laws:
        return False
    stage = set_stage(met)
    rows = np.concatenate([spline_rows(met, stage, law[0], blocks_of(law[1])) for law in laws if law is not None])
    solved = regress(rows, met.residual)
    bent = met.residual - solved.coefficients @ rows
    bent *= np.sqrt(1.0 + solved.dof / max(float(bent @ bent), 1e-300))
    return clearly_better(Left(regression.residual, 0.0), Left(bent, 0.0))


def _laws_of(regression: Regression) -> set[tuple[Side, tuple[str, ...]] | None]:
    """The side and the coordinates of each law of a model, but for constants; None in the place of one that has a
    memory, or more coordinates than two."""
    laws = [depends_on(effect) for effect in regression.fit.model.effects]
    return {law if law is not None and len(law[1]) <= 2 else None for law in laws if law is None or law[1]}


def _structure(regression: Regression, stage: Stage, side: Side, blocks: tuple[Block, ...], tried: int) -> float:
    """Fall of χ² by some functions, beyond that of noise; 0 if chance does it, so many tried."""
    rows = spline_rows(regression, stage, side, blocks)
    solved = regress(rows, regression.residual)
    likely = tried * chance_of(regression, rows.T @ solved.spread) >= _CHANCE
    return 0.0 if likely else solved.drop - solved.dof
