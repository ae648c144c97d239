"""Where no values of the model describe all records: those at which one record by itself is described best.

What bends the parameters of such a fit far from the device's are the strong records. Seen from there every candidate is
distorted; seen from the device's own small motion, or from any single record's, the missing effect stands out.
"""

from __future__ import annotations

from dataclasses import replace

from ..fit import Fit, fit
from ..fit.rebuild import fit_at
from .bench import Bench, prepare
from .shorten import working
from .side_by_side import at_once
from .trajectory import Diverged

_CLEARLY = 0.5  # of the joint error: so much better a record must be described by itself


def prepare_at_best(joint: Fit) -> Bench:
    """The bench of a fit; where its scores cannot be believed, that of the same model at the values which describe a
    single record best, if by itself it is described clearly better.

    If it is described to the noise those are the device's own, and the scores seen from there can be believed.
    """
    short = working(joint)
    bench = prepare(short)
    records = short.campaign.fitted
    if bench.credible or len(records) < 2:
        return bench
    alone = at_once(lambda record: fit(short.model, replace(short.campaign, records=(record,))), records)
    known = [one for one in alone if one.converged and not any(e.flags for e in one.estimates)]
    best = min(known, key=lambda one: one.fitted.error_over_noise, default=None)
    if best is None or not best.fitted.error_over_noise < _CLEARLY * short.fitted.error_over_noise:
        return bench
    try:
        there = prepare(fit_at(short.model, short.campaign, best.values), believed=best.trusted)
    except Diverged:  # on the strong records the motion has no bound
        return bench
    return replace(there, instead_of=bench)
