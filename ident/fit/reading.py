"""The reading of a model with given parameters: what it says the sensor should have shown."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from ..campaign.campaign import Campaign
from ..campaign.record import Trace
from ..model import Model
from ..response import make_groups
from .assemble import assemble, begin
from .problem import Data, Static, Unknowns, evaluate, read_groups


def read(model: Model, values: np.ndarray, records: Sequence[Trace]) -> list[np.ndarray]:
    """Readings of a model with given parameters; initial states of records that do not start at rest are fitted."""
    groups, layout = make_groups(records, float(values[0]), float(values[1]), model.steps_per_period)
    held = replace(model, held=frozenset(p.name for p in model.parameters), freed=frozenset())
    static, data = assemble(held, Campaign("", tuple(records), model.device), groups, layout, values)
    unknowns = begin(groups, static)
    if any(record.start != "rest" for record in records):
        unknowns = fit_starts(static, data, unknowns)
    paths = read_groups(static, data, unknowns)
    return [np.asarray(paths[g])[lane, :n] for g, lane, n in layout.places]


_ROUNDS = 6
_STILL = 1e-7  # of the largest displacement and velocity


def fit_starts(static: Static, data: Data, unknowns: Unknowns) -> Unknowns:
    """Gauss–Newton on the initial states alone; they enter almost linearly. Never worse than where it began."""
    best, least = unknowns, np.inf
    for _ in range(_ROUNDS):
        found = evaluate(static, data, unknowns)
        cost = sum(float(np.sum(np.asarray(residual) ** 2)) for residual in found.residuals)
        if not cost < least:
            return best
        best, least = unknowns, cost
        moved, farthest = [], 0.0
        for residual, slope, group, now in zip(
            found.residuals, found.by_start, data.groups, unknowns.starts, strict=True
        ):
            slope, residual = np.asarray(slope), np.asarray(residual)
            gram = np.einsum("kln,mln->lkm", slope, slope)
            if not np.all(np.isfinite(gram)):
                return best
            # A start of which nothing is left where samples count stays as it was read; of an overdamped motion
            # displacement and velocity at the start leave the same trace.
            inverse = np.linalg.pinv(gram + 1e-12 * np.eye(2), rcond=1e-12, hermitian=True)
            step = np.einsum("lkm,mln,ln->lk", inverse, slope, residual)
            moved.append(np.asarray(now) - step * group.free)
            farthest = max(farthest, float(np.max(np.abs(step * group.free))))
        unknowns = Unknowns(unknowns.x, tuple(moved))
        if farthest < _STILL:
            break
    return unknowns
