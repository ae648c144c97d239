"""A fit prepared for regressions: what it leaves of the records, and what its own parameters can make of that."""

from __future__ import annotations

from collections.abc import Hashable
from dataclasses import dataclass, field, replace
from functools import cached_property, lru_cache
from itertools import pairwise
from typing import Any

import numpy as np

from ...effects.effect import AbstractEffect
from ...fit import Fit
from ...fit.passes import Passes
from ...fit.start_score import start_rows
from ...model import FREQUENCY, QUALITY, Model
from ...response import Equation
from .balance import balanced, samples_of
from .basis import orthonormal
from .columns import Terms, contributions, no_histories
from .curve_columns import Moves, Plane, curve_order, plane_of
from .push_columns import push_columns
from .trajectory import Diverged, Trajectories, lay_out
from .whiten import Whitening, whiten, whitening_of

_TINY = 1e-20  # a step in an imaginary direction loses no digits (Squire, Trapp, 1998, SIAM Rev. 40, 110)
_FARTHEST = 0.7  # of its value: so far a shape may be moved in one step, which keeps its sign
_LEAST = 0.1  # of its stiffness and of its damping: what is left to the linear part at the least
_CREDIBLE = 0.25  # of the excess that a fit left: the most that its own parameters can be believed to absorb still
# Of the acceleration: what the equation of motion must explain of it to be believed beyond that. It was 0.91 to 1.00 on
# twenty devices with inertia, below 0.05 on a stage without and on a fit that had run away from its resonance.
_INERTIA = 0.5


@dataclass(frozen=True, eq=False)
class Regression:
    """A fit prepared for regressions: whitened residual (n,) without what the model absorbs, and how to project a
    column.

    The numbers of the sweeps follow those of the traces, one sweep after another, those that were run fast first.

    **Arguments:** `starts`: first sample of each record within n; `absorbed`: (n, q) orthonormal, the span of `known`
    (k, n), which moving the parameters along `directions` (k, m) does; `left` (n,) and `fit_chi2`: the whitened
    residual as the fit left it and its χ², with which refits are compared; `plane`: what the sweeps say while
    parameters move; `passes`: those that were run fast; `credible`: whether the model's own parameters could be
    followed along the measured motion, on which the score statistics rest (see `prepare`); `instead_of`: the regression
    of the best fit, if this one is of other values (see `anchor`), and `alone`, the record that they describe, if it is
    one; `scored`, `refitted`: what `score` and `confirm` have found on it, for several parts of a diagnosis ask the
    same.
    """

    fit: Fit
    trajectories: Trajectories
    whitenings: tuple[Whitening, ...]
    starts: tuple[int, ...]
    absorbed: np.ndarray
    residual: np.ndarray
    left: np.ndarray
    known: np.ndarray
    directions: np.ndarray
    plane: Plane | None = None
    passes: Passes | None = None
    credible: bool = True
    instead_of: Regression | None = None
    alone: str = ""
    scored: dict[type[AbstractEffect], Any] = field(default_factory=dict)
    refitted: dict[Hashable, Any] = field(default_factory=dict)

    @property
    def n(self) -> int:
        """How many samples count."""
        silent = sum(
            np.count_nonzero(whitening.masked) for whitening in self.whitenings if whitening.masked is not None
        )
        return len(self.residual) - int(silent)

    @property
    def places(self) -> tuple[slice, ...]:
        """Where each record's numbers are, silent ones too; those of the sweeps last."""
        return tuple(slice(a, b) for a, b in pairwise((*self.starts, len(self.residual))))

    @property
    def chi2(self) -> float:
        return float(self.residual @ self.residual)

    @property
    def above_noise(self) -> float:
        """χ² above that of noise, and no less than noise scatters by: a share of less would be a share of chance, and
        below a floor that is too high, none at all."""
        return max(self.chi2 - self.n, float(np.sqrt(2.0 * self.n)))

    @property
    def fit_chi2(self) -> float:
        return float(self.left @ self.left)

    @property
    def excess(self) -> float:
        """χ² of the best fit above that of noise."""
        return max(self.best_chi2 - self.n, 1e-9)

    @property
    def best_chi2(self) -> float:
        """What the best fit of the model leaves, wherever the regression stands: an effect gains what it leaves
        less."""
        return (self.instead_of or self).fit_chi2

    @property
    def to_explain(self) -> float:
        """χ² above that of noise that effects may take: here; or of what the best fit leaves, if the regression stands
        elsewhere, where χ² has another weight."""
        return max(self.chi2 - self.n, 1e-9) if self.instead_of is None else self.excess

    @property
    def settled(self) -> bool:
        """Whether the model's own parameters, along the measured motion, claim little of what its fit left."""
        little = _CREDIBLE * max(self.fit_chi2 - self.n, self.n)
        return self.credible and (not self.whitenings or self.fit_chi2 - self.chi2 < little)

    @cached_property
    def unexplained(self) -> float:
        """What the equation of motion leaves of the traces, over what inertia alone makes of them (χ² both).

        What it leaves of mass times measured acceleration is the residual without what the parameters absorb, both seen
        through the dynamics of the model.
        """
        trajectories, tape = self.trajectories, self.trajectories.tape
        accelerations = [
            np.gradient(path.v, lane.step / 2) for path, lane in zip(trajectories.paths, tape.lanes, strict=True)
        ]
        windows = zip(trajectories.dynamics, tape.windows(accelerations), strict=True)
        rows = push_columns(
            tape, trajectories.dynamics, [(np.asarray(d.mass)[:, None] * a)[:, None] for d, a in windows]
        )
        inertia = by_record(self, rows)[0]
        left = self.residual[: len(inertia)]
        return float(left @ left) / max(float(inertia @ inertia), 1e-300)

    @property
    def numbers(self) -> int:
        """How many numbers of the fit the records determine."""
        return self.fit.freedom

    def moved(self, added: np.ndarray) -> np.ndarray | None:
        """Where the model's own parameters (m,) go when something is added that does (n,) to the readings; None if
        they could not be followed along the measured motion."""
        if not self.credible:
            return None
        step, _, _, _ = np.linalg.lstsq(self.known.T, self.left - added, rcond=1e-10)
        return self.stepped(step)

    def stepped(self, step: np.ndarray) -> np.ndarray:
        """The model's own parameters (m,) after a step (k,) along the directions.

        The force on the stage is linear in stiffness, damping and amplitudes: a step in these is as long as the records
        say, however far it leads.
        """
        model, values = self.fit.model, self.fit.values
        whole = step @ self.directions
        found = values + whole
        for i, p in enumerate(model.parameters):
            if p.kind == "shape":
                found[i] = values[i] + np.clip(whole[i], -_FARTHEST * abs(values[i]), _FARTHEST * abs(values[i]))
        mass = float(model.mass_of(values))
        moved = values + 1j * _TINY * whole
        ahead = model.spring_and_damper(moved[FREQUENCY], moved[QUALITY], mass)  # and their slopes
        spring, damper = (max(x.real + x.imag / _TINY, _LEAST * x.real) for x in ahead)
        found[[FREQUENCY, QUALITY]] = model.times_of(spring, damper, mass, float(values[FREQUENCY]))
        for i, p in enumerate(model.parameters):
            if p.limits is not None:
                low, high = (limit * getattr(self.fit.scales, p.limits_scale) for limit in p.limits)
                found[i] = np.clip(found[i], low, high)
        return found

    def of_traces(self) -> Regression:
        """The regression without the points of sweeps, for what is known along a motion only."""
        if self.plane is None and self.passes is None:
            return self
        count = (*self.starts, len(self.left))[len(self.whitenings)]
        alone = replace(
            self, starts=self.starts[: len(self.whitenings)], left=self.left[:count], plane=None, passes=None
        )
        return _without(replace(alone, scored={}, refitted={}), self.known[:, :count], self.directions)

    def beside(self, rows: np.ndarray) -> Regression:
        """The regression with what whitened rows (k, n) can absorb out of its residual too."""
        absorbed = np.concatenate([self.absorbed, orthonormal(self.project(rows), rows)], axis=1)
        residual = self.left - absorbed @ (absorbed.T @ self.left)
        return replace(self, absorbed=absorbed, residual=residual, scored={}, refitted={})

    def project(self, stacked: np.ndarray) -> np.ndarray:
        """Whitened rows (k, n) without what the model absorbs."""
        return stacked - (stacked @ self.absorbed) @ self.absorbed.T


@lru_cache(maxsize=8)  # the walk comes back to a fit
def prepare(fit: Fit, believed: bool = False) -> Regression:
    """Lay out a fit for regressions; `believed`, that its parameters are the device's own.

    What the model's own parameters absorb is taken along the measured motion, so that a large misfit does not bend
    it. Where inertia hardly matters that is too much: displacement is then the drive force over the stiffness, and to
    take both away, seen on the measured motion, "explains" whatever was measured. A fit has no such freedom, and shows
    it by having left what they claim to absorb; its own Jacobian is then taken instead. Where the equation of motion
    explains the acceleration, nothing can be taken away: what they absorb is then bent by the fit, not by them.

    **Raises:** Diverged if the model's motion has no bound, or no drive makes it answer as a sweep was measured.
    """
    trajectories = lay_out(fit)
    records = fit.campaign.fitted
    solved = trajectories.solved
    whitenings, by_start = [], start_rows(fit)
    for record, own in zip(records, trajectories.tape.slices, strict=True):
        # A steady start moves with every parameter and every candidate: what it may do is left to none of them.
        rows = by_start[:, own] if record.start != "rest" else None
        whitenings.append(whitening_of(record, rows))
    lengths = [len(r.time) - r.skip for r in records]
    white = [whiten(whitening, r[None])[0] for whitening, r in zip(whitenings, trajectories.residuals, strict=True)]
    left = list(white)
    curves, passes, samples = solved.data.curves, solved.data.passes, trajectories.tape.samples
    of_curves = samples + (0 if curves is None else curves.count)
    if passes is not None:
        if solved.found.passed is None or not np.all(np.isfinite(solved.found.passed.tone)):
            raise Diverged(passes.sweeps[0].name)
        lengths += [len(passes.places(k)) for k in range(len(passes.sweeps))]
        left.append(-solved.found.residuals[of_curves:][passes.order])
    if curves is not None:
        steady = solved.found.steady
        if steady is None or not np.all(np.isfinite(steady.needed)):
            raise Diverged(fit.campaign.fitted_sweeps[0].name)
        lengths += [len(curves.places(own)) for own in curves.slices]
        left.append(-solved.found.residuals[samples:of_curves][curve_order(solved)])
    starts = tuple(int(x) for x in np.concatenate([[0], np.cumsum(lengths)[:-1]]))
    residual = np.concatenate(left)
    empty = np.zeros((0, len(residual)))
    regression = Regression(
        fit, trajectories, tuple(whitenings), starts, empty.T, residual, residual, empty, np.zeros((0, len(fit.values)))
    )
    # A shape at its bound cannot move as its column says: to project that out would hide a misfit that remains.
    fitted = [i for i in solved.static.free if "at-bound" not in fit.estimates[i].flags]
    # A quality factor that had to be held (steady sines of one frequency) may be wrong: its error is no missing effect.
    bent = "held" in fit.estimates[QUALITY].flags and fit.model.form != "quasi-static"
    free = sorted({*fitted, QUALITY}) if bent else fitted
    directions = np.eye(len(fit.values))[free] * np.where(fit.values[free] == 0, 1.0, fit.values[free])[:, None]
    if curves is not None:
        regression = replace(regression, plane=plane_of(solved, directions))
    passed = None
    if passes is not None:
        regression = replace(regression, passes=passes)
        there = passes.solve(solved.static.equation, fit.values, directions, solved.static.width)
        passed = passes.slopes(there)[:, passes.order]
    # Of its own parameters the model itself says what they do to sweeps, all harmonics together.
    own, past = None if regression.plane is None else regression.plane.own, trajectories.histories[None]
    along_measured = stack(regression, fit.model, fit.values[None], directions, True, past, own, passed)
    with np.errstate(over="ignore"):
        squares = along_measured**2
    if not np.all(np.isfinite(squares)):  # next to the measured motion its own runs away
        raise Diverged((*fit.campaign.fitted, *fit.campaign.fitted_sweeps)[0].name)
    measured = _without(regression, along_measured, directions)
    if believed or measured.settled or measured.unexplained < _INERTIA:
        # What a candidate does to fast sweeps is known at the fit alone, and not along what was measured.
        return replace(measured, credible=passes is None)
    chosen = [solved.static.free.index(i) for i in fitted]
    regression = replace(regression, credible=False)
    by_x = solved.found.by_x[chosen]
    rows = [by_record(regression, by_x[:, :samples])]
    rows += [] if passes is None else [by_x[:, of_curves:][:, passes.order]]
    rows += [] if curves is None else [by_x[:, samples:of_curves][:, curve_order(solved)]]
    rows = np.concatenate(rows, axis=1)
    return _without(regression, rows, np.zeros((0, 0)))


def _without(regression: Regression, known: np.ndarray, directions: np.ndarray) -> Regression:
    """The regression with what rows (k, n) can absorb taken out of its residual."""
    absorbed = orthonormal(known)
    residual = regression.left - absorbed @ (absorbed.T @ regression.left)
    found = replace(regression, absorbed=absorbed, residual=residual, known=known, directions=directions)
    if regression.plane is None or not len(directions):
        return found
    own = balanced(found, np.zeros((0, samples_of(found))), regression.plane.own.rows(slice(0)))
    if not np.all(np.isfinite(own.left)):  # no drive makes the model answer as was measured
        raise Diverged(regression.fit.campaign.fitted_sweeps[0].name)
    absorbed = orthonormal(own.slopes)
    return replace(found, absorbed=absorbed, residual=own.left - absorbed @ (absorbed.T @ own.left))


def stack(
    regression: Regression,
    model: Model,
    values: np.ndarray,
    directions: np.ndarray,
    linear: bool = False,
    begun: np.ndarray | None = None,
    moves: Moves | None = None,
    passed: np.ndarray | None = None,
) -> np.ndarray:
    """Whitened columns of all fitted records, (p q, n): what moving the parameters of `model` does.

    `values` are (p, m), and at each of them the columns are taken along `directions`, (q, m). The terms of `model`
    push, its linear ones only if asked for; the regression's own model answers. `begun`, (p, records, h): their
    histories, if the records do not begin with the drive; `moves`: what they do to the points of the sweeps, if there
    are any; `passed`, (p q, numbers), to those that were run fast.
    """
    trajectories, parts = regression.trajectories, []
    if trajectories.tape.spans:
        equation = Equation(model)
        pasts = no_histories(equation, len(values), trajectories.tape) if begun is None else begun
        parts.append(_along_traces(regression, Terms(equation, linear), values, directions, pasts))
    if passed is not None:
        parts.append(passed)
    if moves is not None:
        plane = regression.plane
        assert plane is not None  # there are sweeps
        parts.append(-plane.slopes(plane.needed, np.ones_like(plane.needed), plane.heard, moves))
    return np.concatenate(parts, axis=1)


def _along_traces(
    regression: Regression, asked: Terms, values: np.ndarray, directions: np.ndarray, pasts: np.ndarray
) -> np.ndarray:
    """`stack` of the traces."""
    trajectories = regression.trajectories
    both = contributions(asked, trajectories.tape, values, directions, trajectories.moved, trajectories.seen, pasts)
    forces, shown = zip(*both, strict=True)
    rows = np.zeros((len(values) * len(directions), trajectories.tape.samples))
    if asked.push:
        rows += push_columns(trajectories.tape, trajectories.dynamics, forces)
    if asked.show:
        rows += trajectories.tape.at_samples([np.moveaxis(part, 1, 2) for part in shown])
    return by_record(regression, rows)


def by_record(regression: Regression, rows: np.ndarray) -> np.ndarray:
    """Readings (d, samples) as whitened rows of the counted ones, (d, n)."""
    pairs = zip(regression.whitenings, regression.trajectories.tape.slices, strict=True)
    return np.concatenate([whiten(whitening, rows[:, own]) for whitening, own in pairs], axis=1)
