"""The linear side at every node of a walk: has the sensor a zero of its own in each record?

An amplifier that drifts, or is set anew, moves the zero between records by less than what the first model misses, so
that it shows only beside an effect; what bends to mimic it there is no physics, and held-out records, whose zero is
another again, refute what is right. Their levels are looked for as those of the fitted records are.
"""

from __future__ import annotations

from dataclasses import replace

from ...campaign.apart import as_it_came, curves, read_apart
from ...campaign.campaign import Campaign
from ...campaign.record import Trace
from ...fit import Fit, fit
from ...fit.rebuild import fit_at
from ...pulse import Report
from ..evidence.criterion import VERY_STRONG, Left, behind
from ..evidence.enough import adequate
from ..evidence.held_out import foretold
from ..linearised.shorten import one_stretch_each
from ..ranking.look import Look
from ..records.between import comparable, differing, rows_of

LEVEL = "level"


def with_own_zeros(current: Fit, look: Look) -> Campaign | None:
    """The campaign with its records read by zeros of their own, if the criterion prefers those, with their numbers, to
    the model as it is and to it with any effect more; None where they are few, or as they should be."""
    campaign, regression = current.campaign, look.regression
    if not comparable(current) or any(record.differs for record in campaign.records):
        return None
    rows = rows_of(regression, LEVEL)
    left = regression.beside(rows).residual
    if adequate(regression, promise=regression.chi2 - float(left @ left)) and foretold(current):
        return None
    levels = Left(left, regression.numbers + len(rows))
    if behind(levels, regression) > -VERY_STRONG or any(behind(levels, one) > 0 for one in _with_effects(look)):
        return None
    look.report("has the sensor a zero of its own in each record?")
    return _read_so(current, campaign, words=True)


def has_own_zeros(campaign: Campaign) -> bool:
    """Whether the records are read by zeros of their own."""
    return any(record.own is not None and record.own[0] == LEVEL for record in campaign.traces)


def with_zeros_anew(last: Fit, report: Report) -> Fit:
    """The last fit of a walk, the zeros found again beside it if they were looked for on the way: what had been missing
    may have bent them."""
    if not has_own_zeros(last.campaign):
        return last
    report("the zeros of the records once more")
    as_they_came = replace(last.campaign, records=tuple(as_it_came(record) for record in last.campaign.records))
    there = fit_at(last.model, as_they_came, last.values, converged=False)
    told = _read_so(there, as_they_came, words=False)
    return last if told is None else fit(last.model, told, initial=last.values)


def _read_so(fitted: Fit, campaign: Campaign, words: bool) -> Campaign | None:
    """The records of a campaign by the zeros that a fit to them tells, long ones by a stretch of each."""
    found = differing(one_stretch_each(fitted), (LEVEL,))
    if found is None:
        return None
    levels = {
        trace.name: size[0] * _size(trace) for trace, size in zip(found.fit.campaign.traces, found.sizes, strict=True)
    }
    read = tuple(
        read_apart(r, LEVEL, [levels[r.name] / _size(r)]) if isinstance(r, Trace) else r for r in campaign.records
    )
    return replace(campaign, records=read, notes=(*campaign.notes, *([found.words] if words else [])))


def _size(trace: Trace) -> float:
    """What a level is counted in."""
    return float(curves(trace)[0, 0])


def _with_effects(look: Look) -> list[Left]:
    """What each effect that matters leaves by its score."""
    regression = look.regression
    left = lambda rows: regression.residual - rows.T @ (rows @ regression.residual)
    return [Left(left(one.signature), regression.numbers + one.dof) for one in look.real]
