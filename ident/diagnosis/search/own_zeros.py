"""The linear side at every node of a walk: has the sensor a zero of its own in each record?

An amplifier that drifts, or is set anew, moves the zero between records by less than what the first model misses, so
that it shows only beside an effect; what bends to mimic it there is no physics, and held-out records, whose zero is
another again, refute what is right. Their levels are looked for as those of the fitted records are.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from ...campaign.apart import TOLD, read_apart
from ...campaign.campaign import Campaign
from ...campaign.record import Trace
from ...fit import Fit
from ..evidence.criterion import VERY_STRONG, Left, behind, criteria
from ..evidence.enough import adequate, at_floor
from ..evidence.held_out import foretold
from ..linearised.regression import Regression
from ..linearised.shorten import one_stretch_each
from ..ranking.look import Look
from ..ranking.pairs import Pair, best_pair
from ..ranking.score import score_beside, significant
from ..ranking.weigh import Candidate
from ..records.between import comparable, differing, rows_of
from ..records.differing import Differing, numbers_of

LEVEL = "level"


def with_own_zeros(current: Fit, look: Look) -> Campaign | None:
    """The campaign with its records read by zeros of their own, if the criterion prefers those to a common one, beside
    the effects that say most with either, two at most; None where they are few, or as they should be."""
    campaign, regression = current.campaign, look.regression
    if not comparable(current) or any(record.differs for record in campaign.records):
        return None
    beside = regression.beside(rows_of(regression, LEVEL))
    more = numbers_of(regression.fit, LEVEL)
    if adequate(regression, promise=regression.chi2 - beside.chi2) and foretold(current):
        return None
    if behind(Left(beside.residual, regression.numbers + more), regression) > -VERY_STRONG:
        return None
    one_for_all = _best(regression, look.real, look.pair, 0, look)
    # Where effects with no more numbers than the zeros alone reach the floor, what zeros take besides may be noise, or
    # a finer shape of those, which bends the mean.
    few = one_for_all.numbers <= regression.numbers + more
    if few and at_floor(float(one_for_all.left @ one_for_all.left), regression):
        return None
    (scored,) = score_beside([beside], look.library)
    zeros = _best(beside, significant(scored), best_pair(beside, scored), more, look)
    if behind(zeros, one_for_all) > -VERY_STRONG:
        return None
    look.report("has the sensor a zero of its own in each record?")
    found = differing(one_stretch_each(current), (LEVEL,))
    return found and _read_so(campaign, found)


def has_own_zeros(campaign: Campaign) -> bool:
    """Whether the records are read by zeros of their own, be they levels or baselines."""
    return any(record.own is not None and TOLD[record.own[0]].of_zero for record in campaign.traces)


def _read_so(campaign: Campaign, found: Differing) -> Campaign:
    """The records of a campaign by the zeros that were found, of long ones in a stretch of each."""
    levels = {trace.name: trace.number(LEVEL) for trace in found.fit.campaign.traces}
    read = tuple(read_apart(r, LEVEL, [levels[r.name]]) if isinstance(r, Trace) else r for r in campaign.records)
    return found.said_in(replace(campaign, records=read))


def _best(regression: Regression, effects: Sequence[Candidate], pair: Pair | None, more: int, look: Look) -> Left:
    """What is left by scores with no effect, one or two, whichever the criterion prefers; `more`: numbers that the
    regression absorbs besides."""
    numbers, left = regression.numbers + more, regression.residual
    after = lambda rows: left - rows.T @ (rows @ left)
    tried = [Left(left, numbers)]
    tried += [Left(after(one.signature), numbers + one.dof + histories(one.name, look)) for one in effects]
    if pair is not None:
        tried.append(Left(pair.left, pair.numbers + more + sum(histories(name, look) for name in pair.names)))
    return tried[int(np.argmin(criteria(tried)))]


def histories(effect: str, look: Look) -> int:
    """How many zeros of the records' own an effect brings: a slow memory has one in each that begins in motion."""
    begun = sum(record.start != "rest" for record in look.regression.fit.campaign.fitted)
    return begun * len(look.library[effect].hidden_units)
