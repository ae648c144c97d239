"""Zeros of the records' own beside the last model of a walk: told as they are there, or taken back.

They were found beside an earlier model. What that lacked may have moved the mean of a record as a zero of its own does.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ...campaign.apart import as_it_came
from ...campaign.record import Trace
from ...effects.registry import Registry
from ...fit import Fit, fit
from ...fit.rebuild import fit_at
from ...fit.zeros import numbers_of_zeros
from ...pulse import Report
from ..evidence.criterion import VERY_STRONG, Left, behind
from ..evidence.held_out import hurts
from ..linearised.regression import prepare
from ..linearised.shorten import one_stretch_each, working
from ..linearised.trajectory import Diverged
from ..records.between import differing
from ..records.differing import numbers_of, without_words
from .constant import with_its_constant


def with_last_zeros(last: Fit, library: Registry, report: Report) -> Fit:
    """The last fit of a walk with the zeros of its records, and their errors, in the notes as they are beside it; with
    one zero for all, or none, if the criterion does not clearly prefer zeros of their own any more, nor held-out
    records do."""
    floating = next((trace for trace in last.campaign.traces if trace.floats), None)
    if floating is None or floating.own is None:
        return last
    kind = floating.own[0]
    report("the zeros of the records once more")
    records = tuple(as_it_came(record) if isinstance(record, Trace) else record for record in last.campaign.records)
    came = without_words(replace(last.campaign, records=records), kind)
    try:
        regression = prepare(working(last))
        counted = numbers_of_zeros(regression.fit.campaign.fitted)  # excerpts are read by zeros that are held
        own = Left(regression.left, regression.numbers - counted + numbers_of(last, kind))
        common = fit(last.model, came, initial=last.values)
        common, without = with_its_constant(common, prepare(working(common)), library, report)
        if behind(own, without) > -VERY_STRONG and not hurts(last, common):
            return common
    except (Diverged, np.linalg.LinAlgError):  # a motion without bound does not tell
        pass
    found = differing(one_stretch_each(fit_at(last.model, came, last.values, converged=False)), (kind,))
    return last if found is None else replace(last, campaign=found.said_in(last.campaign))
