"""Whether the records see an effect that a model lacks: then none of its intervals is final, small as its residual is.

An omnibus test of what a model leaves spreads its power over every way in which noise could not be noise. The score
test asks each effect of the library alone, and so sees one long before the size of what is left does. It asks all
records, the held-out ones too: where a wrong model has bent its parameters until the fitted records agree, a level or a
frequency that it was not fitted to still tells. What even they do not tell may still be there: an interval holds only
as far as the model is the device.

Source: as in `score`.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ...campaign.record import Trace
from ...effects.registry import Registry
from ...fit import Fit, fit
from ..linearised.regression import prepare
from ..linearised.shorten import shortened, working
from .score import score, significant


def missing(fitted: Fit, library: Registry) -> tuple[str, ...]:
    """Why the model is not the whole device, in words; none if the records see no effect of the library in what it
    leaves of all of them."""
    unbounded = [s.name for s in fitted.trace_scores if not np.isfinite(s.rmse)]
    if unbounded:
        return (f"the model has no finite motion in {unbounded[0]}; ask `ident diagnose` what is missing",)
    seen = significant(score(prepare(_to_all_records(fitted)), library))
    if not seen:
        return ()
    best = min(seen, key=lambda candidate: candidate.p_value)
    whose = "all records, the held-out ones too" if fitted.campaign.heldout else "the records"
    others = f", as {len(seen) - 1} more would" if len(seen) > 1 else ""
    by_chance = "less than 1e-16" if best.p_value < 1e-16 else f"{best.p_value:.1g}"
    return (
        f"an effect is missing: {best.name} would explain part of what the model leaves of {whose}{others} "
        f"(probability by chance {by_chance}); ask `ident diagnose`",
    )


def _to_all_records(fitted: Fit) -> Fit:
    """The model fitted to the held-out traces too, from the fit's values; long records shortened."""
    campaign = fitted.campaign
    if not campaign.heldout:
        return working(fitted)
    records = tuple(replace(r, holdout=False) if isinstance(r, Trace) else r for r in campaign.records)
    return fit(fitted.model, shortened(replace(campaign, records=records)), initial=fitted.values)
