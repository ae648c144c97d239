"""From a solution to a Fit: uncertainties, identifiability, readings, and the check of the solver's step."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple, TypeVar

import numpy as np

from ..campaign.campaign import Campaign
from ..campaign.record import Trace
from ..model import Model, ModelParameter
from .coordinates import slopes
from .curve_reading import CurveReading, read_curves, told, told_in_time
from .identifiability import identifiability
from .judge import combine, score_record
from .linear.guess import DataScales
from .problem import Data, Static
from .reading import read_and_zeros
from .result import Estimate, Fit, SigmaChoice, Solved, Start
from .solve import Solution
from .uncertainty import Linearisation, covariance, linearise
from .zeros import read_by

T = TypeVar("T")


class Minimum(NamedTuple):
    """Where least squares ended: the arrays of the fit, the `best` solution, and every start."""

    static: Static
    data: Data
    best: Solution
    starts: tuple[Start, ...]
    scales: DataScales

    @property
    def error(self) -> float:
        """Error over noise of the best solution."""
        cost = self.best.cost
        return self.data.error_of(cost) if np.isfinite(cost) else np.inf

    @property
    def values(self) -> np.ndarray:
        """(m,) SI, all parameters of the model."""
        return self.best.found.values


def finish(model: Model, campaign: Campaign, minimum: Minimum, sigma: SigmaChoice) -> Fit:
    """Everything that is known of a solution."""
    static, data, best, starts, scales = minimum
    found, records = best.found, campaign.fitted
    values = found.values
    free, parameters = list(static.free), model.parameters
    in_x = linearise(found, data, records)
    scale = data.scale
    linear = Linearisation(in_x.jacobian / scale, in_x.residual, in_x.spread / np.outer(scale, scale))
    stretch = slopes(values[free], data.lower, data.upper)  # d(physical value)/d(coordinate)
    spectrum = covariance(linear, data.prior_weight * stretch)
    judged = identifiability([parameters[i] for i in free], values[free], stretch, spectrum)
    motion = found.response.readings
    zero = data.zeros_beside(motion)
    inside = [(motion[own], zero[own]) for own in data.tape.slices]
    heldout = read_and_zeros(model, values, campaign.heldout) if campaign.heldout else []
    both = _in_order(campaign, inside, heldout)
    shown = tuple(moved for moved, _ in both)
    if data.zeros:
        campaign = read_by(campaign, [own for _, own in both])
        data, found = data._replace(response=data.response - zero), found._replace(readings=motion)
    curves = _curves(model, campaign, minimum)
    by_trace, by_sweep = iter(zip(campaign.traces, shown, strict=True)), iter(curves)
    scores = tuple(
        score_record(*next(by_trace)) if isinstance(record, Trace) else next(by_sweep).score
        for record in campaign.records
    )
    error = combine([s for s in scores if not s.holdout])
    factor = error.error_over_noise**2 if sigma == "scaled" and error is not None else 1.0
    matrix = factor * spectrum.matrix * np.outer(stretch, stretch)
    return Fit(
        model=model,
        campaign=campaign,
        values=values,
        estimates=_estimates(parameters, model.units(campaign.order), values, free, matrix, judged.determined, data),
        free=static.free,
        covariance=matrix,
        combinations=judged.combinations,
        readings=shown,
        scores=scores,
        starts=starts,
        sigma=sigma,
        converged=best.converged,
        scales=scales,
        spectrum=spectrum,
        linear=linear,
        solved=Solved(static, data, best.unknowns, found),
        curves=curves,
    )


def _curves(model: Model, campaign: Campaign, minimum: Minimum) -> tuple[CurveReading, ...]:
    """Readings of all sweeps, in the campaign's order."""
    data, found = minimum.data, minimum.best.found
    fitted: list[CurveReading] = []
    rows = found.residuals[data.tape.samples :]
    if data.curves is not None and found.steady is not None:
        fitted += told(data.curves, found.steady.model, rows, found.steady.converged)
        rows = rows[data.curves.count :]
    if data.passes is not None and found.passed is not None:
        fitted += told_in_time(data.passes, minimum.static.equation, found.values, rows, found.passed)
    by_place = {id(one.sweep): one for one in (*fitted, *read_curves(model, found.values, campaign.heldout_sweeps))}
    return tuple(by_place[id(sweep)] for sweep in campaign.sweeps)


def _in_order(campaign: Campaign, fitted: list[T], heldout: list[T]) -> tuple[T, ...]:
    inside, outside = iter(fitted), iter(heldout)
    return tuple(next(outside) if record.holdout else next(inside) for record in campaign.traces)


def at_bound(value: float, lower: float, upper: float, error: float) -> bool:
    """Whether a value ± `error` says no more than that it lies at the edge of its range."""
    if np.isfinite(upper):
        return value < 1.02 * lower or value > 0.98 * upper
    return lower == 0.0 and error > 3 * abs(value)


def _estimates(
    parameters: Sequence[ModelParameter],
    units: Sequence[str],
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
            estimates.append(Estimate(parameter.name, value, None, units[i], False, ("held",)))
            continue
        k = free.index(i)
        error = float(np.sqrt(max(matrix[k, k], 0.0)))
        flags: tuple[str, ...] = ()
        if not determined[k]:
            flags = ("undetermined",)
        elif at_bound(value, float(data.lower[k]), float(data.upper[k]), error):
            flags = ("at-bound",)
        elif error > abs(value):
            flags = ("not-significant",)
        # At the edge of a range the slope of the bijection vanishes, and with it any error bar that could be given.
        known = determined[k] and np.isfinite(error) and error > 0
        edge = "at-bound" in flags and np.isfinite(data.upper[k])
        shown = error if known and not edge else None
        estimates.append(Estimate(parameter.name, value, shown, units[i], True, flags))
    return tuple(estimates)
