"""From a model and records to the arrays that the compiled code works on."""

from __future__ import annotations

import numpy as np

from ..campaign.campaign import Campaign
from ..model import Model, ModelParameter
from ..response import Equation, Group
from ..response.groups import Layout
from .coordinates import to_coordinates
from .guess import DataScales
from .problem import Data, Static, Unknowns

_ON = 0.1  # of a limit: data scales of other records of the same device differ by that


def assemble(
    model: Model,
    campaign: Campaign,
    groups: tuple[Group, ...],
    layout: Layout,
    values: np.ndarray,
    scales: DataScales | None = None,
) -> tuple[Static, Data]:
    """The arrays of a fit whose unknowns are the model's fitted parameters, at `values` (m,) SI."""
    parameters = model.parameters
    free = tuple(i for i, p in enumerate(parameters) if p.fitted)
    bounds = np.array([bounds_of(parameters[i], float(values[i]), scales) for i in free]).reshape(-1, 2)
    priors = [campaign.priors.get(parameters[i].name) for i in free]
    data = Data(
        groups,
        np.asarray(values, float),
        bounds[:, 0],
        bounds[:, 1],
        np.ones(len(free)),
        np.zeros(len(free)),
        np.array([0.0 if p is None else p.mean for p in priors]),
        np.array([0.0 if p is None else 1.0 / p.deviation for p in priors]),
    )
    static = Static(Equation(model), layout.substeps, free, any(bool(np.any(group.free)) for group in groups))
    return static, at_values(data, static, np.asarray(values, float))


def bounds_of(parameter: ModelParameter, value: float, scales: DataScales | None) -> tuple[float, float]:
    """Lower and upper bound of a parameter (SI) in a fit that starts from `value`."""
    if not parameter.positive:
        return -np.inf, np.inf
    if parameter.limits is None or scales is None:
        return 0.0, np.inf
    unit = getattr(scales, parameter.limits_scale)
    # A value that the user gave outside the usual limits moves them; one that an earlier fit left on a limit does not.
    low, high = parameter.limits[0] * unit, parameter.limits[1] * unit
    return (low if value > low * (1 - _ON) else value / 3), (high if value < high * (1 + _ON) else value * 3)


def at_values(data: Data, static: Static, values: np.ndarray) -> Data:
    """The same fit with x = 0 at `values`."""
    chosen = values[list(static.free)]
    lower, upper = np.asarray(data.lower), np.asarray(data.upper)
    anchor = to_coordinates(chosen, lower, upper)
    scale = np.where(np.isfinite(lower), 1.0, np.where(chosen == 0, 1.0, np.abs(chosen)))
    return data._replace(template=values, anchor=anchor, scale=scale)


def begin(groups: tuple[Group, ...], static: Static) -> Unknowns:
    """Unknowns to start from: x = 0, initial states read off the first samples."""
    return Unknowns(np.zeros(len(static.free)), tuple(_measured_start(group) for group in groups))


def _measured_start(group: Group) -> np.ndarray:
    """Displacement and velocity read off the first samples, in units of the group's scale."""
    stride = max(1, round((group.lanes.voltage.shape[1] - 1) / 2 / (group.response.shape[1] - 1)))
    step = np.asarray(group.lanes.step) * stride
    few = min(5, group.response.shape[1])
    line = np.polynomial.polynomial.polyfit(np.arange(few), group.response[:, :few].T, min(2, few - 1))
    start = np.stack([line[0], line[1] / step], axis=1)
    return start / group.start_scale * group.free
