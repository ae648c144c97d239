"""The reading of a model with given parameters: what it says the sensor should have shown."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..campaign.campaign import Campaign
from ..campaign.record import Trace
from ..model import Model
from ..response import lay_out
from .assemble import assemble, begin
from .problem import Data, Evaluation, Static, Unknowns, evaluate, readings


def read(model: Model, values: np.ndarray, records: Sequence[Trace]) -> list[np.ndarray]:
    """Readings of a model with given parameters; initial states of records that do not start at rest are fitted."""
    tape = lay_out(records, float(values[0]), float(values[1]), model.steps_per_period)
    campaign = Campaign("", tuple(records), model.device)
    static, data = assemble(model, campaign, records, tape, values, held=True)
    unknowns = begin(data, static)
    shown = fit_starts(static, data, unknowns)[1].readings if static.starts_free else readings(static, data, unknowns)
    return [shown[own] for own in tape.slices]


_ROUNDS = 6
_STILL = 1e-7  # of the largest displacement and velocity


def fit_starts(static: Static, data: Data, unknowns: Unknowns) -> tuple[Unknowns, Evaluation]:
    """Gauss–Newton on the initial states alone; they enter almost linearly. Never worse than where it began; the model
    there too."""
    best, kept, least = unknowns, None, np.inf
    for _ in range(_ROUNDS + 1):
        found = evaluate(static, data, unknowns)
        cost = float(found.residuals @ found.residuals)
        if kept is not None and not cost < least:
            break
        best, kept, least = unknowns, found, cost
        steps = np.zeros_like(unknowns.starts)
        for record, own in enumerate(data.tape.slices):
            slope = found.by_start[:, own]
            gram = slope @ slope.T
            if not np.all(np.isfinite(gram)):
                return best, kept
            # A start of which nothing is left where samples count stays as it was read; of an overdamped motion
            # displacement and velocity at the start leave the same trace.
            inverse = np.linalg.pinv(gram + 1e-12 * np.eye(2), rcond=1e-12, hermitian=True)
            steps[record] = inverse @ (slope @ found.residuals[own]) * (data.start_scale[record] > 0)
        unknowns = Unknowns(unknowns.x, unknowns.starts - steps)
        if np.max(np.abs(steps), initial=0.0) < _STILL:
            break
    assert kept is not None  # there was at least one round
    return best, kept
