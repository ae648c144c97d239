"""From a solution to a Fit: uncertainties, identifiability, readings, and the check of the solver's step."""

from __future__ import annotations

from typing import Sequence

import numpy as np

from ..campaign.campaign import Campaign
from ..campaign.record import Trace
from ..model import Model, ModelParameter
from ..response import make_groups
from ..response.groups import Layout
from . import solve
from .guess import DataScales
from .identifiability import identifiability
from .judge import combine, score_record
from .problem import Data, Static, Unknowns
from .reading import read
from .result import Estimate, Fit, SigmaChoice, Start
from .uncertainty import Linearisation, covariance, linearise


def finish(
    model: Model,
    campaign: Campaign,
    static: Static,
    data: Data,
    unknowns: Unknowns,
    layout: Layout,
    starts: tuple[Start, ...],
    sigma: SigmaChoice,
    scales: DataScales,
    converged: bool,
) -> Fit:
    """Everything that is known of a solution."""
    records = campaign.fitted
    values, fitted_readings = _readings(static, data, unknowns, layout)
    free, parameters = list(static.free), model.parameters
    positive = np.asarray(data.positive)
    found = linearise(solve.evaluate(static, data, unknowns), layout, records)
    scale = np.asarray(data.scale)
    linear = Linearisation(found.jacobian / scale, found.residual, found.spread / np.outer(scale, scale))
    stretch = np.where(positive, values[free], 1.0)  # d(physical value)/d(coordinate)
    spectrum = covariance(linear, np.asarray(data.prior_weight) * stretch)
    judged = identifiability([parameters[i] for i in free], values[free], positive, spectrum)
    readings = _with_heldout(model, campaign, values, fitted_readings)
    scores = tuple(score_record(record, r) for record, r in zip(campaign.traces, readings, strict=True))
    error = combine([s for s in scores if not s.holdout])
    factor = error.error_over_noise**2 if sigma == "scaled" and error is not None else 1.0
    matrix = factor * spectrum.matrix * np.outer(stretch, stretch)
    return Fit(
        model,
        campaign,
        values,
        _estimates(parameters, values, free, matrix, judged.determined, positive),
        static.free,
        matrix,
        judged.combinations,
        readings,
        scores,
        starts,
        sigma,
        converged,
        _step_error(static, data, unknowns, layout, records, fitted_readings, values, scales),
        scales,
        spectrum,
        linear,
    )


def _readings(
    static: Static, data: Data, unknowns: Unknowns, layout: Layout
) -> tuple[np.ndarray, list[np.ndarray]]:
    values, paths = solve.readings(static, data, unknowns)
    return np.asarray(values), [np.asarray(paths[g][lane, :n]) for g, lane, n in layout.places]


def _with_heldout(
    model: Model, campaign: Campaign, values: np.ndarray, fitted: Sequence[np.ndarray]
) -> tuple[np.ndarray, ...]:
    heldout = iter(read(model, values, campaign.heldout) if campaign.heldout else [])
    inside = iter(fitted)
    return tuple(next(heldout) if record.holdout else next(inside) for record in campaign.traces)


def _step_error(
    static: Static,
    data: Data,
    unknowns: Unknowns,
    layout: Layout,
    records: Sequence[Trace],
    coarse: Sequence[np.ndarray],
    values: np.ndarray,
    scales: DataScales,
) -> float:
    """Largest change of any reading when the solver's step is halved, in noise floors."""
    groups, finer = make_groups(records, 1.0 / scales.period, float(values[1]), substeps=[2 * s for s in layout.per_record])
    _, fine = _readings(static._replace(substeps=finer.substeps), data._replace(groups=groups), unknowns, finer)
    return max(
        float(np.max(np.abs(a - b))) / record.noise.sigma for record, a, b in zip(records, coarse, fine, strict=True)
    )


def _estimates(
    parameters: Sequence[ModelParameter],
    values: np.ndarray,
    free: list[int],
    matrix: np.ndarray,
    determined: np.ndarray,
    positive: np.ndarray,
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
        elif positive[k] and error > 3 * abs(value):
            flags = ("at-bound",)
        elif error > abs(value):
            flags = ("not-significant",)
        shown = error if determined[k] and np.isfinite(error) and error > 0 else None
        estimates.append(Estimate(parameter.name, value, shown, parameter.unit, True, flags))
    return tuple(estimates)
