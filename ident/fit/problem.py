"""A fit as arrays: residuals in units of the noise floor, and their Jacobian.

The unknowns are x, the fitted parameters in unbounded coordinates (ln p for positive ones) divided by `scale`, and the
initial states of the records that start neither at rest nor on the model's periodic orbit (`steady`): displacement,
velocity, and the hidden states of every memory, of whose history nothing is known. A record's initial state moves that
record only, so the Jacobian costs p + s tangent simulations whatever the number of records (p if none are unknown).
Samples of all traces stand one after another, (samples,); `data.tape.slices` says where each is. What the points of
sweeps say follows them, (numbers,) in all.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from ..response import Equation, Response, Tape, respond
from ..response.controlled import Controlled
from ..response.transient import fitting_width
from .coordinates import slopes, to_coordinates, to_values
from .curves import Curves
from .passes import Passed, Passes
from .steady import Steady
from .zeros import Zero, best_by


class Static(NamedTuple):
    """What a fit is about.

    **Arguments:** `equation`; `free`, positions of the fitted parameters in the model's list; `starts_free`, whether
    any record's initial state is fitted; `width`, how many directions a simulation takes at least, so that models with
    few free parameters need no program of their own.
    """

    equation: Equation
    free: tuple[int, ...]
    starts_free: bool
    width: int = 0


class Data(NamedTuple):
    """The numbers of a fit.

    **Arguments:**

    - `tape`: the drives; `response`, (samples,) measured, m; `weight`, (samples,) 1/σ, zero where a sample is not
      counted; `start_scale`, (records, s) the size of displacement, velocity and hidden states in a record: the unit of
      the fitted initial states, and as large as these are likely to be; zero where a record starts at rest, or steady.
    - `template`: (m,) SI values of all parameters, fitted or not.
    - `lower`, `upper`: (p,) bounds of the fitted ones (see coordinates); `scale`, `anchor`: (p,) unit and origin of x.
    - `prior_mean`, `prior_weight`: (p,) SI; weight 1/deviation, 0 without a prior.
    - `curves`: the points of the sweeps that had settled, if there are any, and `passes`: of the others; `steady`: the
      records that start on a periodic orbit; `zeros`: the records that have one of their own.
    - `misfit`: error over noise, one at the least, against which an unlikely history counts: where a model misses by a
      hundred noise floors, one of thirty times the drive would else pay for mimicking a little of that.
    """

    tape: Tape
    response: np.ndarray
    weight: np.ndarray
    start_scale: np.ndarray
    template: np.ndarray
    lower: np.ndarray
    upper: np.ndarray
    scale: np.ndarray
    anchor: np.ndarray
    prior_mean: np.ndarray
    prior_weight: np.ndarray
    curves: Curves | None = None
    passes: Passes | None = None
    steady: tuple[Steady, ...] = ()
    misfit: float = 1.0
    zeros: tuple[Zero, ...] = ()

    def misfit_of(self, found: Evaluation) -> float:
        """The `misfit` of what a model leaves."""
        squares = float(found.residuals @ found.residuals) / max(self.count, 1)
        return max(math.sqrt(squares), 1.0) if math.isfinite(squares) else self.misfit

    def error_of(self, cost: float) -> float:
        """Error over noise of a Σ r²."""
        return float(np.sqrt(cost / self.count))

    def errors_of(self, found: Evaluation) -> list[float]:
        """Error over noise of each record, infinite of a motion without bound."""
        squares = [float(np.sum(found.residuals[own] ** 2)) / max(np.count_nonzero(self.weight[own]), 1)
                   for own in self.tape.slices]  # fmt: skip
        return [math.sqrt(x) if math.isfinite(x) else math.inf for x in squares]

    def zeros_beside(self, readings: np.ndarray) -> np.ndarray:
        """The zeros of the records' own that fit best beside some readings, (samples,) each."""
        return best_by(self.zeros, self.tape.slices, self.weight, (self.response - readings)[None])[0]

    def with_zeros(self, readings: np.ndarray) -> np.ndarray:
        """Readings (samples,) with these zeros."""
        return readings + self.zeros_beside(readings) if self.zeros else readings

    def beside_zeros(self, rows: np.ndarray) -> np.ndarray:
        """Rows (k, samples), of readings or derivatives, without what these zeros take up of them."""
        return rows - best_by(self.zeros, self.tape.slices, self.weight, rows) if self.zeros else rows

    @property
    def count(self) -> int:
        """How many numbers are fitted."""
        sweeps = sum(0 if part is None else part.count for part in (self.curves, self.passes))
        return int(np.count_nonzero(self.weight)) + sweeps


class Unknowns(NamedTuple):
    """`x` (p,) and `starts` (records, s) in units of `start_scale`; of hidden states, what lies beyond those that a
    record would begin with if the drive had been switched on with it."""

    x: np.ndarray
    starts: np.ndarray


WORST = 1e8  # residual of a simulation that overflowed: finite, so that the step is rejected rather than the fit lost


def physical(static: Static, data: Data, x: np.ndarray) -> np.ndarray:
    """All parameters of the model in SI, (m,), from the unknowns x (p,)."""
    values = np.array(data.template, float)
    values[list(static.free)] = to_values(x * data.scale + data.anchor, data.lower, data.upper)
    return values


def in_ranges(
    static: Static, data: Data, unknowns: Unknowns, lower: np.ndarray, upper: np.ndarray
) -> tuple[Data, Unknowns]:
    """The same fit at the same point with other bounds (p,) in its coordinates. A unit of x changes the values as much
    as before, so that derivatives stay what they are."""
    values = physical(static, data, unknowns.x)[list(static.free)]
    scale = data.scale * slopes(values, data.lower, data.upper) / slopes(values, lower, upper)
    anchor = to_coordinates(values, lower, upper)
    changed = data._replace(lower=lower, upper=upper, scale=scale, anchor=anchor)
    return changed, Unknowns(np.zeros_like(unknowns.x), unknowns.starts)


class Evaluation(NamedTuple):
    """A model at one point.

    **Arguments:** `values`, (m,) SI; its `response` and `readings`, (samples,) m; `residuals` (model − measured)/σ,
    (numbers,), and their derivatives `by_x` (p, numbers) and `by_start` (s, samples), by the initial state of each
    sample's own record, empty if none is unknown; `starts`, (records, s) the initial states, SI; `steady`, its
    responses with the amplitudes of the sweeps; `passed`, its readings of those that had not settled.
    """

    values: np.ndarray
    response: Response
    readings: np.ndarray
    residuals: np.ndarray
    by_x: np.ndarray
    by_start: np.ndarray
    starts: np.ndarray
    steady: Controlled | None = None
    passed: Passed | None = None


@np.errstate(over="ignore", invalid="ignore")  # a motion without bound is refused for its cost
def evaluate(static: Static, data: Data, unknowns: Unknowns) -> Evaluation:
    """Residuals and Jacobian in one march."""
    values, p, tape = physical(static, data, unknowns.x), len(static.free), data.tape
    starts = unknowns.starts.shape[1] * static.starts_free
    directions = np.zeros((max(p + starts, static.width), len(values)))
    free = list(static.free)
    directions[np.arange(p), free] = slopes(values[free], data.lower, data.upper) * data.scale
    kicks = np.zeros((len(directions), *unknowns.starts.shape))
    for k in range(starts):
        kicks[p + k, :, k] = data.start_scale[:, k]
    begin = unknowns.starts * data.start_scale
    for one in data.steady:
        orbit = one.at(static.equation, values, directions[:p], len(directions))
        # Without an orbit there is no steady record: such a trial is refused, and a shorter step is taken.
        begin[one.record] = orbit.start if orbit.found else np.nan
        kicks[:p, one.record] = orbit.slopes
    found = respond(static.equation, tape, values, begin, directions, kicks)
    shown, change = data.with_zeros(found.readings), data.beside_zeros(found.slopes) * data.weight
    residuals = (shown - data.response) * data.weight
    change[~np.isfinite(change)] = 0.0
    by_start = change[p : p + starts]
    left, by_x, steady, passed = [residuals], [change[:p]], None, None
    if data.curves is not None:
        steady = data.curves.solve(static.equation, values, directions[:p])
        left.append(data.curves.residuals(steady))
        by_x.append(data.curves.slopes(steady, directions[:p]))
    if data.passes is not None:
        passed = data.passes.solve(static.equation, values, directions[:p], static.width)
        left.append(data.passes.residuals(passed))
        by_x.append(data.passes.slopes(passed))
    left = [np.where(np.abs(part) < WORST, part, WORST) for part in left]
    by_x = [np.where(np.isfinite(part), part, 0.0) for part in by_x]
    rows, slope = np.concatenate(left), np.concatenate(by_x, axis=1)
    return Evaluation(values, found, shown, rows, slope, by_start, begin, steady, passed)


def reweighed(static: Static, data: Data, values: np.ndarray) -> Data:
    """The same with the noise of the sweeps carried through the model at some values (m,)."""
    curves, passes = data.curves, data.passes
    return data._replace(
        curves=curves and curves.weighed(static.equation, values),
        passes=passes and passes.weighed(static.equation, values, static.width),
    )


def of_sweeps(data: Data, residuals: np.ndarray) -> dict[str, np.ndarray]:
    """The residuals of each sweep, by its name, of those of a fit: of its amplitudes, then of its phases."""
    found, first = {}, data.tape.samples
    if data.curves is not None:
        rows = residuals[first : first + data.curves.count]
        pairs = zip(data.curves.sweeps, data.curves.slices, strict=True)
        found |= {sweep.name: rows[data.curves.places(own)] for sweep, own in pairs}
        first += data.curves.count
    if data.passes is not None:
        rows = residuals[first:]
        found |= {sweep.name: rows[data.passes.places(k)] for k, sweep in enumerate(data.passes.sweeps)}
    return found


def readings(static: Static, data: Data, unknowns: Unknowns) -> np.ndarray:
    """Model readings alone, (samples,) m."""
    return data.with_zeros(motions(static, data, unknowns))


def motions(static: Static, data: Data, unknowns: Unknowns) -> np.ndarray:
    """What the sensor reads of the model's motion, (samples,) m, without zeros of the records' own."""
    starts = unknowns.starts.shape[1] * static.starts_free
    width = fitting_width(max(len(static.free) + starts, static.width))  # the program that is there
    nothing = np.zeros((width, len(data.template)))
    begin, kicks = unknowns.starts * data.start_scale, np.zeros((len(nothing), *unknowns.starts.shape))
    values = physical(static, data, unknowns.x)
    for one in data.steady:
        begin[one.record] = one.at(static.equation, values, nothing[:0], width).start
    return respond(static.equation, data.tape, values, begin, nothing, kicks).readings
