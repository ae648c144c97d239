"""The missing term as a picture: a curve over one coordinate, a map over two, or the loop of a memory."""

from __future__ import annotations

from typing import Literal, NamedTuple

import numpy as np

from ...effects.dependence import Side
from ..linearised.regression import Regression
from .coordinates import Stage, absorbed
from .products import Product
from .splines import Places
from .subsets import Ranked, Solution, spline_functions
from .terms import amplitude_unit

_CURVE, _MAP = 121, 41  # points along an axis at least, and
_PER_SPLINE = 2


class Picture(NamedTuple):
    """The estimated function, without the part that the model's own linear terms absorb.

    **Arguments:**

    - `kind`: "value" (a constant), "curve", "map", "factor" (by which another coordinate is multiplied), or "loop" (a
      record's last period, of which `record` is the name).
    - `names`, `grids`: of the coordinates, SI; a map's values are (first, second).
    - `value`, `error`: SI in `unit`; one standard error at each point; NaN in a map where no record has been.
    """

    kind: Literal["value", "curve", "map", "factor", "loop"]
    names: tuple[str, ...]
    grids: tuple[np.ndarray, ...]
    value: np.ndarray
    error: np.ndarray
    unit: str
    record: str = ""


def draw(regression: Regression, stage: Stage, chosen: Ranked, solved: Solution) -> Picture:
    """The function that a regression on the splines of these coordinates has found; of a product, that of the one
    coordinate."""
    side, coordinates = chosen.side, chosen.coordinates
    if chosen.product is not None:
        return _varying(regression, stage, side, chosen.product, solved)
    unit, size = ("m", stage.sensor_unit) if side == "sensor" else ("N", stage.force_unit)
    names = tuple(name for name in coordinates if name not in ("1", "history"))
    noise = _noise(regression, solved)
    seen = stage.modelled if side == "sensor" else stage.moved
    record, place = "", {}
    grids: list[np.ndarray] = []
    weights, last = np.ones((1, 1)), slice(None)
    kind: Literal["value", "curve", "map", "loop"] = "value"
    if not names:
        found = spline_functions(stage, side, chosen.blocks, {"z": np.zeros((1, 1))})
    elif coordinates[-1] == "history":
        place, record, last = _largest(regression, seen)
        found = spline_functions(stage, side, chosen.blocks, place)
        kind, grids, weights = "loop", [place[names[0]]], np.ones(place["z"].shape)
    else:
        own = stage.ranges(side)
        least = _CURVE if len(names) == 1 else _MAP
        axes = [np.linspace(own[n].low, own[n].high, max(least, _PER_SPLINE * own[n].pieces)) for n in names]
        mesh = list(np.meshgrid(*axes, indexing="ij")) if len(names) == 2 else [axes[0][None]]
        found = spline_functions(stage, side, chosen.blocks, dict(zip(names, mesh, strict=True)))
        kind, grids, weights = ("curve" if len(names) == 1 else "map"), list(mesh), _visits(seen, names, axes)
    lines = [grid.ravel() for name, grid in zip(names, grids, strict=True) if absorbed(side, name)]
    if kind == "loop" and names == ("z",) and side != "sensor":
        lines.append(place["v"].ravel())
    functions = _without(found.reshape(len(found), -1).T, lines, weights.ravel())
    value = size * functions @ solved.coefficients
    error = size * noise * np.linalg.norm(functions @ solved.spread, axis=1)
    if kind == "loop":
        shown = (grids[0].ravel()[last],)
        return Picture("loop", names, shown, value[last], error[last], unit, record)
    if kind == "map":
        been = weights > 0
        value, error = (np.where(been, x.reshape(been.shape), np.nan) for x in (value, error))
        return Picture("map", names, (grids[0][:, 0], grids[1][0]), value, error, unit)
    return Picture(kind, names, tuple(g.ravel() for g in grids), value, error, unit)


def _noise(regression: Regression, solved: Solution) -> float:
    """What standard errors are multiplied by: what is left, where that is more than the noise."""
    return float(np.sqrt(max(1.0, (regression.chi2 - solved.drop) / regression.n)))


def _varying(regression: Regression, stage: Stage, side: Side, product: Product, solved: Solution) -> Picture:
    """The function of a product, where the motion mostly was, less the constant that the model has already where its
    factor is linear."""
    ranges, seen = stage.ranges(side), stage.modelled if side == "sensor" else stage.moved
    axis = np.linspace(*ranges[product.of].mostly, max(_CURVE, _PER_SPLINE * product.pieces))
    curves = product.curves({product.of: axis}, ranges).T
    constant = [np.ones(len(axis))] if product.known(side) else []
    curves = _without(curves, constant, _visits(seen, (product.of,), [axis], product.work(seen)).ravel())
    size = (stage.sensor_unit if side == "sensor" else stage.force_unit) / product.scale(ranges)
    error = size * _noise(regression, solved) * np.linalg.norm(curves @ solved.spread, axis=1)
    unit = amplitude_unit(side, product.powers)
    return Picture("factor", (product.of,), (axis,), size * curves @ solved.coefficients, error, unit)


def _without(functions: np.ndarray, lines: list[np.ndarray], weights: np.ndarray) -> np.ndarray:
    """Functions (points, k) less their best straight parts along `lines`, weighted."""
    if not lines:
        return functions
    root = np.sqrt(weights)[:, None]
    x = np.stack(lines, axis=1)
    x = x / np.max(np.abs(x), axis=0)
    return functions - x @ np.linalg.lstsq(root * x, root * functions, rcond=None)[0]


def _visits(
    seen: tuple[Places, ...], names: tuple[str, ...], axes: list[np.ndarray], weights: np.ndarray | None = None
) -> np.ndarray:
    """How often the records have been near each point of the grid, by their weights."""
    edges = [np.concatenate([[-np.inf], 0.5 * (a[1:] + a[:-1]), [np.inf]]) for a in axes]
    points = np.concatenate([np.stack([place[n].ravel() for n in names], axis=1) for place in seen])
    index = [np.searchsorted(e, points[:, i]) - 1 for i, e in enumerate(edges)]
    shape = tuple(len(a) for a in axes)
    flat = np.ravel_multi_index([np.clip(i, 0, n - 1) for i, n in zip(index, shape, strict=True)], shape)
    count = np.bincount(flat, weights, minlength=int(np.prod(shape))).reshape(shape).astype(float)
    return count if len(names) == 2 else count[None]


def _largest(regression: Regression, seen: tuple[Places, ...]) -> tuple[Places, str, slice]:
    """The places of the record that moved most, its name, and the points of its last period."""
    records = regression.fit.campaign.fitted
    chosen = max(range(len(records)), key=lambda i: float(np.ptp(records[i].response)))
    place = seen[chosen]
    points = place["z"].shape[1]
    omega = regression.trajectories.tape.lanes[chosen].omega
    period = 2 * np.pi / omega if omega > 0 else np.inf
    count = int(min(np.ceil(period / place["step"][0]) + 1, points))
    return place, records[chosen].name, slice(points - count, points)
