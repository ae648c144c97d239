"""The reading of a model with given parameters: what it says the sensor should have shown."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..campaign.campaign import Campaign
from ..campaign.record import Trace
from ..model import FREQUENCY, QUALITY, Model
from ..response import lay_out
from .assemble import assemble, begin
from .fit_starts import fit_starts
from .on_orbits import on_orbits
from .problem import readings


def read(model: Model, values: np.ndarray, records: Sequence[Trace]) -> list[np.ndarray]:
    """Readings of a model with given parameters; unknown initial states are fitted."""
    tape = lay_out(records, float(values[FREQUENCY]), float(values[QUALITY]), model)
    campaign = Campaign("", tuple(records), model.device)
    static, data = assemble(model, campaign, records, tape, values, held=True)
    unknowns = begin(data, static)
    if static.starts_free:
        unknowns, found = fit_starts(static, data, unknowns)
        static, data, unknowns = on_orbits(static, data, records, unknowns)
        shown = readings(static, data, unknowns) if data.steady else found.readings
    else:
        shown = readings(static, data, unknowns)
    return [shown[own] for own in tape.slices]
