"""From a solution to a Fit: uncertainties, identifiability, readings, and the check of the solver's step."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from ..campaign.campaign import Campaign
from ..model import Model, ModelParameter
from ..response import make_groups
from ..response.groups import Layout
from .coordinates import slopes
from .guess import DataScales
from .identifiability import identifiability
from .judge import combine, score_record
from .problem import Data, Static, Unknowns, evaluate, physical, read_groups
from .reading import read
from .result import Estimate, Fit, SigmaChoice, Start
from .solve import Solution
from .uncertainty import Linearisation, covariance, linearise


class Minimum(NamedTuple):
    """Where least squares ended: the arrays of the fit, the `best` solution, and every start."""

    static: Static
    data: Data
    layout: Layout
    best: Solution
    starts: tuple[Start, ...]
    scales: DataScales

    @property
    def error(self) -> float:
        """Error over noise at the best end."""
        return min((s.end for s in self.starts if np.isfinite(s.end)), default=np.inf)

    @property
    def values(self) -> np.ndarray:
        """(m,) SI, all parameters of the model."""
        return np.asarray(physical(self.static, self.data, self.best.unknowns.x))


def finish(model: Model, campaign: Campaign, minimum: Minimum, sigma: SigmaChoice) -> Fit:
    """Everything that is known of a solution."""
    static, data, layout, best, starts, scales = minimum
    unknowns, records = best.unknowns, campaign.fitted
    found = evaluate(static, data, unknowns)
    values = np.asarray(found.values)
    free, parameters = list(static.free), model.parameters
    in_x = linearise(found, layout, records)
    scale = np.asarray(data.scale)
    linear = Linearisation(in_x.jacobian / scale, in_x.residual, in_x.spread / np.outer(scale, scale))
    stretch = slopes(values[free], data.lower, data.upper)  # d(physical value)/d(coordinate)
    spectrum = covariance(linear, np.asarray(data.prior_weight) * stretch)
    judged = identifiability([parameters[i] for i in free], values[free], stretch, spectrum)
    inside = [np.asarray(found.readings[g])[lane, :n] for g, lane, n in layout.places]
    finer, heldout = _finer_and_heldout(model, campaign, static, data, unknowns, layout, values, scales)
    step_error = max(
        float(np.max(np.abs(a - b))) / record.noise.sigma for record, a, b in zip(records, inside, finer, strict=True)
    )
    readings = _in_order(campaign, inside, heldout)
    scores = tuple(score_record(record, r) for record, r in zip(campaign.traces, readings, strict=True))
    error = combine([s for s in scores if not s.holdout])
    factor = error.error_over_noise**2 if sigma == "scaled" and error is not None else 1.0
    matrix = factor * spectrum.matrix * np.outer(stretch, stretch)
    return Fit(
        model,
        campaign,
        values,
        _estimates(parameters, values, free, matrix, judged.determined, data),
        static.free,
        matrix,
        judged.combinations,
        readings,
        scores,
        starts,
        sigma,
        best.converged,
        step_error,
        scales,
        spectrum,
        linear,
    )


def _in_order(campaign: Campaign, fitted: list[np.ndarray], heldout: list[np.ndarray]) -> tuple[np.ndarray, ...]:
    inside, outside = iter(fitted), iter(heldout)
    return tuple(next(outside) if record.holdout else next(inside) for record in campaign.traces)


def _finer_and_heldout(
    model: Model,
    campaign: Campaign,
    static: Static,
    data: Data,
    unknowns: Unknowns,
    layout: Layout,
    values: np.ndarray,
    scales: DataScales,
) -> tuple[list[np.ndarray], list[np.ndarray]]:
    """Readings of the fitted records with half the step, and of the held-out records; one program computes both."""
    coarse = lambda records: make_groups(records, 1.0 / scales.period, float(values[1]), model.steps_per_period)[1]
    alone = campaign.heldout if any(record.start != "rest" for record in campaign.heldout) else ()
    beside = () if alone else campaign.heldout
    # The held-out ones with half a step too: most campaigns are then one group, which is traced and compiled once.
    steps = [2 * s for s in (*layout.per_record, *coarse(beside).per_record)]
    groups, places = make_groups((*campaign.fitted, *beside), 1.0 / scales.period, float(values[1]), substeps=steps)
    starts = [np.zeros_like(group.free) for group in groups]
    for (group, lane, _), (old, old_lane, _) in zip(places.places, layout.places, strict=False):
        scale = np.asarray(data.groups[old].start_scale) / groups[group].start_scale
        starts[group][lane] = np.asarray(unknowns.starts[old])[old_lane] * scale
    paths = read_groups(
        static._replace(substeps=places.substeps), data._replace(groups=groups), Unknowns(unknowns.x, tuple(starts))
    )
    found = [np.asarray(paths[group])[lane, :n] for group, lane, n in places.places]
    inside = len(campaign.fitted)
    return found[:inside], read(model, values, alone) if alone else found[inside:]


def _at_bound(value: float, lower: float, upper: float, error: float) -> bool:
    if np.isfinite(upper):
        return value < 1.02 * lower or value > 0.98 * upper
    return lower == 0.0 and error > 3 * abs(value)


def _estimates(
    parameters: Sequence[ModelParameter],
    values: np.ndarray,
    free: list[int],
    matrix: np.ndarray,
    determined: np.ndarray,
    data: Data,
) -> tuple[Estimate, ...]:
    estimates = []
    for i, parameter in enumerate(parameters):
        value = float(values[i])
        if i not in free:
            estimates.append(Estimate(parameter.name, value, None, parameter.unit, False, ("held",)))
            continue
        k = free.index(i)
        error = float(np.sqrt(max(matrix[k, k], 0.0)))
        flags: tuple[str, ...] = ()
        if not determined[k]:
            flags = ("undetermined",)
        elif _at_bound(value, float(data.lower[k]), float(data.upper[k]), error):
            flags = ("at-bound",)
        elif error > abs(value):
            flags = ("not-significant",)
        # At the edge of a range the slope of the bijection vanishes, and with it any error bar that could be given.
        known = determined[k] and np.isfinite(error) and error > 0
        edge = "at-bound" in flags and np.isfinite(data.upper[k])
        shown = error if known and not edge else None
        estimates.append(Estimate(parameter.name, value, shown, parameter.unit, True, flags))
    return tuple(estimates)
