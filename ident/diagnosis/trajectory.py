"""The trajectory that the stage really took, as far as a record tells: the model's own, corrected by the smoothed
residual.

A missing force is evaluated where the stage was, not where the wrong model puts it. The model's state carries the fast
motion exactly; only the slowly varying misfit needs smoothing, so that velocities stay clean at 3 % noise. Of a model
that stands at the noise floor nothing but noise would be followed: the less a residual stands above it, the less of it
is.

What a sensor adds is evaluated on the model's own motion: if the sensor is what differs, the stage moved as the model
says and the readings are not its path. (The cube of a reading that saturates has no third harmonic left.)
"""

from __future__ import annotations

from functools import partial
from typing import NamedTuple

import equinox as eqx
import jax
import numpy as np
from scipy.interpolate import CubicHermiteSpline
from scipy.signal import savgol_filter

from ..campaign.record import Trace
from ..fit import Fit
from ..fit.assemble import assemble, begin
from ..fit.problem import Data, Static, Unknowns, evaluate
from ..fit.reading import fit_starts
from ..response import make_groups
from ..response.groups import Layout
from ..response.lane import Lane, half_step_time
from ..response.transient import assemble as bind
from ..response.transient import integrate

_NOISE = 1.5  # residual over noise, squared, up to which a residual may be noise whose floor is not well known


class Diverged(ArithmeticError):
    """The motion of a model has no bound on a record: nothing can be compared with it."""


class Path(NamedTuple):
    """Displacement and velocity on the half-step grid of each lane, (lanes, 2 n + 1), m and m/s."""

    z: np.ndarray
    v: np.ndarray


class Scene(NamedTuple):
    """A fit laid out for diagnosis: the arrays of its fitted records, and the trajectories in them.

    **Arguments:** `residuals`: per record (n,), measured − model, m; `paths`: per group, the corrected trajectory;
    `own`: the model's.
    """

    static: Static
    data: Data
    layout: Layout
    unknowns: Unknowns
    paths: tuple[Path, ...]
    own: tuple[Path, ...]
    residuals: tuple[np.ndarray, ...]


@eqx.filter_jit
def _states(static: Static, data: Data, values: np.ndarray, starts: tuple) -> tuple:
    def one(substeps: int, start: jax.Array, lane: Lane) -> tuple:
        system = bind(static.equation, values, lane)
        return integrate(system, substeps, start, lane, half_step_time(lane))[:2]

    return tuple(
        jax.vmap(partial(one, substeps))(s * group.free * group.start_scale, group.lanes)
        for substeps, s, group in zip(static.substeps, starts, data.groups, strict=True)
    )


def lay_out(fit: Fit) -> Scene:
    """The scene of a fit: its model's states, corrected by the smoothed residual of each record.

    **Raises:** Diverged if the model's motion has no bound.
    """
    records = fit.campaign.fitted
    groups, layout = make_groups(records, 1.0 / fit.scales.period, float(fit.values[1]), fit.model.steps_per_period)
    static, data = assemble(fit.model, fit.campaign, groups, layout, fit.values, fit.scales)
    unknowns = begin(groups, static)
    if static.starts_free:
        unknowns = fit_starts(static, data, unknowns)
    found = evaluate(static, data, unknowns)
    states = _states(static, data, np.asarray(fit.values), unknowns.starts)
    paths, own = ([Path(*np.zeros((2, *g.lanes.voltage.shape))) for g in groups] for _ in range(2))
    residuals = []
    for record, (g, lane, n) in zip(records, layout.places, strict=True):
        residual = record.response - np.asarray(found.readings[g])[lane, :n]
        if not np.all(np.isfinite(residual)):
            raise Diverged(record.name)
        z, v = (np.asarray(x[lane, :n]) for x in states[g])
        correction, rate = _trusted(residual, record) * _smooth(residual, record.step, fit.scales.period)
        grid = record.time[0] + 0.5 * np.asarray(groups[g].lanes.step)[lane] * np.arange(paths[g].z.shape[1])
        inside = np.minimum(grid, record.time[-1])
        for path, spline in (
            (paths[g], CubicHermiteSpline(record.time, z + correction, v + rate)),
            (own[g], CubicHermiteSpline(record.time, z, v)),
        ):
            path.z[lane], path.v[lane] = spline(inside), spline(inside, 1)
        residuals.append(residual)
    return Scene(static, data, layout, unknowns, tuple(paths), tuple(own), tuple(residuals))


def _trusted(residual: np.ndarray, record: Trace) -> float:
    """Share of a residual that is followed."""
    excess = float(np.mean(residual[record.skip :] ** 2)) / record.noise.sigma**2
    noise = _NOISE * (1.0 + 2.0 * record.noise.relative_error) ** 2
    return max(0.0, 1.0 - (noise / excess) ** 2)


def _smooth(residual: np.ndarray, step: float, period: float) -> np.ndarray:
    """Residual and its rate, (2, n), smoothed over about a sixth of the resonance's period by local cubics."""
    window = max(int(period / step / 6) // 2 * 2 + 1, 5)
    if len(residual) <= window:
        return np.zeros((2, len(residual)))
    return np.array([savgol_filter(residual, window, 3, deriv=order, delta=step) for order in (0, 1)])
