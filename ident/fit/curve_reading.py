"""What a model says of a sweep: its curves at the sweep's levels, the runs over them as the instrument made them, and
the jumps with their errors."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import NamedTuple

import numpy as np

from ..campaign.record import Run, Sweep
from ..campaign.sweeps.jump import jump_of
from ..model import Model
from ..response import Equation
from ..response.branches import Branch, Fold, follow
from ..response.controlled import Points, at_amplitude
from ..response.periodic import Periodic
from ..response.sweep import run_along
from .curves import Curves, lay_curves
from .judge import RecordScore
from .passes import Passed, Passes, lay_passes

_AROUND = 0.1  # of the band of a sweep, by which its curves are followed beyond it


class Jump(NamedTuple):
    """Where a run jumps, Hz: between which points it did as `measured`, None if not, and where the `model` turns back,
    None if nowhere within the run; `slope`: derivative of the model's by its values, (m,) Hz."""

    measured: float | None
    model: float | None
    slope: np.ndarray | None


class RunReading(NamedTuple):
    """A run: `reading`, (k,) m, in the order of the run; `apart`, (k,) where model and device were on different
    branches, so that the difference says nothing; `jump`, None where neither jumps."""

    run: Run
    branch: Branch
    reading: np.ndarray
    apart: np.ndarray
    jump: Jump | None


@dataclass(frozen=True, eq=False)
class Followed:
    """The curves of a model at the levels of some sweeps, followed when they are asked for, all side by side."""

    sweeps: tuple[Sweep, ...]
    model: Periodic

    @cached_property
    def branches(self) -> dict[tuple[str, float], Branch]:
        """By name of the sweep and level."""
        asked, levels, bands, sizes, loads = [], [], [], [], []
        for sweep in self.sweeps:
            low, high = float(np.min(sweep.frequency)), float(np.max(sweep.frequency))
            more = _AROUND * (high - low)
            acting = {run.level: float(np.median(sweep.acting[run.rows])) for run in sweep.runs}
            for level in sorted(acting):
                asked.append((sweep.name, level))
                levels.append(acting[level])
                bands.append((max(low - more, 0.5 * low), high + more))
                sizes.append(max(float(np.max(sweep.amplitude[r.rows])) for r in sweep.runs if r.level == level))
                loads.append(sweep.load)
        found = follow(self.model, np.array(levels), np.array(loads), np.array(bands), np.array(sizes))
        return dict(zip(asked, found, strict=True))


@dataclass(frozen=True, eq=False)
class CurveReading:
    """A model's reading of a sweep: `settled`, (n,) which of its points count; `rows`, their residuals in noise floors
    as the fit counts them, phases after amplitudes; `unsolved`, how many of them have no response of the measured
    amplitude; `followed`: its curves, among those of others; `passed`: (n,) m, the readings where the points had not
    settled, and the sweep was simulated as it was run."""

    sweep: Sweep
    followed: Followed
    settled: np.ndarray
    rows: np.ndarray
    unsolved: int
    passed: np.ndarray | None = None

    @property
    def model(self) -> Periodic:
        return self.followed.model

    @cached_property
    def runs(self) -> tuple[RunReading, ...]:
        """Every run of the sweep over the model's curves."""
        branches = self.followed.branches
        return tuple(self._run(run, branches[self.sweep.name, run.level]) for run in self.sweep.runs)

    @property
    def reading(self) -> np.ndarray:
        """(n,) m, in the order of the file; NaN where the model's curve could not be followed."""
        found = np.full(len(self.sweep.frequency), np.nan)
        for run in self.runs:
            found[run.run.rows] = run.reading
        return found

    @property
    def residual(self) -> np.ndarray:
        """(n,) of the amplitudes, in noise floors; NaN where a point does not count."""
        found = np.full(len(self.settled), np.nan)
        found[self.settled] = self.rows[: np.count_nonzero(self.settled)]
        return found

    @property
    def of_harmonics(self) -> tuple[tuple[int, np.ndarray], ...]:
        """Of each harmonic that was measured, its order and (n,) the residuals in noise floors; NaN where a point does
        not count."""
        orders = () if self.passed is not None else tuple(one.order for one in self.sweep.overtones)
        count, found = int(np.count_nonzero(self.settled)), []
        first = count * (1 + (self.sweep.phase is not None))
        for k, order in enumerate(sorted(orders)):
            left = np.full(len(self.settled), np.nan)
            left[self.settled] = self.rows[first + k * count : first + (k + 1) * count]
            found.append((order, left))
        return tuple(found)

    @property
    def apart(self) -> np.ndarray:
        """(n,) where model and device were on different branches."""
        found = np.zeros(len(self.sweep.frequency), bool)
        for run in self.runs:
            found[run.run.rows] = run.apart
        return found

    @cached_property
    def backwards(self) -> tuple[Run, ...]:
        """Runs that only an exchanged direction explains: as they are called, more points are apart than the one by
        which a device may jump early; called the other way, none is that had settled."""
        called = [one for one in self.runs if np.count_nonzero(one.apart) > 1]
        turned = [self._run(replace(one.run, up=not one.run.up, rows=one.run.rows[::-1]), one.branch) for one in called]
        agrees = lambda one: not np.any(one.apart & self.settled[one.run.rows])
        return tuple(one.run for one, other in zip(called, turned, strict=True) if agrees(other))

    @property
    def score(self) -> RecordScore:
        """The error over the settled points on the right branch; in noise floors over all that had settled."""
        sweep, counted = self.sweep, self.settled & ~self.apart & np.isfinite(self.reading)
        difference = (sweep.amplitude - self.reading)[counted]
        rms = lambda x: float(np.sqrt(np.mean(x**2))) if len(x) else float("nan")
        signal = max(float(np.std(sweep.amplitude)), 1e-300)
        n, floor = int(np.count_nonzero(counted)), rms(sweep.deviation)
        return RecordScore(sweep.name, sweep.holdout, n, rms(difference), floor, rms(self.rows), signal)

    def _run(self, run: Run, branch: Branch) -> RunReading:
        sweep, rows = self.sweep, run.rows
        if self.passed is not None:
            return RunReading(run, branch, self.passed[rows], np.zeros(len(rows), bool), None)
        amplitude, frequency = sweep.amplitude[rows], sweep.frequency[rows]
        seen = jump_of(sweep, rows)
        measured = None if seen is None else seen.frequency
        if len(branch.length) < 2 or not np.ptp(branch.frequency):
            nothing = np.full(len(rows), np.nan)
            return RunReading(run, branch, nothing, np.zeros(len(rows), bool), None)
        swing = sweep.quantity == "half-peak-to-peak"
        passed = run_along(self.model, branch, frequency, float(amplitude[0]), swing, _scale(branch))
        fold = passed.fold
        apart = np.array([
            any(abs(other - a) < abs(r - a) for other in others)
            for a, r, others in zip(amplitude, passed.reading, passed.others, strict=True)
        ])  # fmt: skip
        if seen is not None and fold is not None:  # between the two jumps only one of them is still up
            i, after = np.arange(len(rows)), seen.after if run.up else len(rows) - seen.after
            apart |= (i >= min(after, passed.after)) & (i < max(after, passed.after))
        if fold is None and measured is None:
            return RunReading(run, branch, passed.reading, apart, None)
        jump = Jump(
            measured, None if fold is None else fold.frequency, None if fold is None else self._slope(fold, branch)
        )
        return RunReading(run, branch, passed.reading, apart, jump)

    def _slope(self, fold: Fold, branch: Branch) -> np.ndarray:
        """Derivative of a fold's frequency by the values, (m,): at its amplitude the level that is needed has no slope
        in the amplitude, so that frequency and values alone keep it."""
        one = lambda x: np.array([float(x)])
        points = Points(one(fold.frequency), one(branch.level), one(fold.amplitude), one(branch.load),
                        np.array([False]))  # fmt: skip
        here = at_amplitude(self.model, points)
        size = np.where(self.model.values == 0, 1.0, np.abs(self.model.values))
        with np.errstate(divide="ignore", invalid="ignore"):  # on the way of a search: NaN, which no error bar shows
            by_values = np.real(here.slopes(np.diag(size)) / here.needed)[:, 0] / size
            return -by_values / np.real(here.by_frequency / here.needed)[0]


def _scale(branch: Branch) -> np.ndarray:
    hidden = np.max(np.abs(branch.unknowns), axis=0)
    return np.where(hidden > 0, hidden, 1.0)


def read_curves(model: Model, values: np.ndarray, sweeps: Sequence[Sweep]) -> tuple[CurveReading, ...]:
    """Readings of a model with given parameters (m,) SI."""
    slow, fast = [s for s in sweeps if not s.fast], [s for s in sweeps if s.fast]
    equation, told_of = Equation(model), list[CurveReading]()
    if slow:
        curves = lay_curves(slow, model).weighed(equation, values)
        found = curves.solve(equation, values)
        told_of += told(curves, found.model, curves.residuals(found), found.converged)
    if fast:
        passes = lay_passes(fast, model).weighed(equation, values)
        passed = passes.solve(equation, values, np.zeros((0, len(values))))
        told_of += told_in_time(passes, equation, values, passes.residuals(passed), passed)
    by_place = {id(one.sweep): one for one in told_of}
    return tuple(by_place[id(sweep)] for sweep in sweeps)


def told(curves: Curves, model: Periodic, rows: np.ndarray, solved: np.ndarray) -> tuple[CurveReading, ...]:
    """Readings of sweeps whose residuals, (count,), are known."""
    followed = Followed(curves.sweeps, model)
    return tuple(
        CurveReading(sweep, followed, kept, rows[curves.places(own)], int(np.count_nonzero(~solved[own])))
        for sweep, kept, own in zip(curves.sweeps, curves.settled, curves.slices, strict=True)
    )


def told_in_time(
    passes: Passes, equation: Equation, values: np.ndarray, rows: np.ndarray, passed: Passed
) -> tuple[CurveReading, ...]:
    """Readings of sweeps that were simulated as they were run, whose residuals, (count,), are known."""
    followed, found = Followed(passes.sweeps, Periodic(equation, np.asarray(values, float), passes.steps)), []
    for k, sweep in enumerate(passes.sweeps):
        reading, all_of = np.abs(passed.tone[passes.points_of(k)]), np.ones(len(sweep.frequency), bool)
        found.append(CurveReading(sweep, followed, all_of, rows[passes.places(k)], 0, reading))
    return tuple(found)
