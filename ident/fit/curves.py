"""Amplitude-frequency curves in a fit: what every measured point says about the parameters, in noise floors.

At the frequency and the amplitude (and phase) of a measured point the model needs a certain force of its actuator; at
the measured level that gives another. The logarithm of their ratio, in units of what the noise of the amplitude does to
it, is the residual of the point. Away from folds that is (model − measured)/σ to first order. At a fold, where the
amplitude has no finite slope, it is finite and smooth: no point has to be assigned a branch, and a fit that begins
where the model jumps elsewhere finds its way. Points that may not have settled (`campaign.settled`) do not count.

    r = −L⁻¹ ln(Û(f, A) e^{iφ}/U),   L Lᵀ = ½ Σ_± d dᵀ + diag(0, σ_φ²),   d = ln(Û(f, A ± σ)/Û(f, A))

Û is the measured drive U times that ratio, complex relative to the response; real and imaginary part of the logarithm
are two numbers, and without a phase φ the real part alone counts. L is renewed between searches and held within each,
so that a search minimises something. Harmonics that were measured are further numbers, of the response with the
measured amplitude (`fit.overtones`).

Source: as of `response.controlled`; S. J. Julier, J. K. Uhlmann, Unscented filtering and nonlinear estimation, Proc.
IEEE 92 (2004) 401 (the noise carried through the model).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import NamedTuple

import numpy as np

from ..campaign.record import Sweep
from ..campaign.sweeps.settled import settled
from ..effects.dependence import depends_on
from ..model import Model
from ..response import Equation
from ..response.controlled import Controlled, Points, at_amplitude
from ..response.periodic import Periodic, steps_per_period
from .overtones import Heard, lay_overtones

_SHARE = 0.1  # of the noise floor of all points together: so far the solver's step may move the response
_REACH = 0.5  # of the scale of an unknown: as far as a slope is followed
_NEAR = 1e-2  # of it: what a slope leaves of such a step is its square, and as small as the last one of a search
BENT = ("sensor", ("z",))  # what a sensor does that is not linear
_ACROSS = 3.0  # λ where there is one: one motion answers wherever no reading falls faster than the cube of its size
_FINEST, _COARSEST = 1e-6, 1e-3  # of the response, whatever the noise


class Known(NamedTuple):
    """Steady responses of a model at some values, and how they move: `by` (d, points, n + 1) along `directions` (d,
    m)."""

    found: Controlled
    directions: np.ndarray | None = None
    by: np.ndarray | None = None

    def moved_to(self, model: Periodic) -> tuple[np.ndarray, bool]:
        """Where the unknowns, (points, n + 2), are to first order at the values of another model; as they are, if that
        is further than a slope reaches; NaN where there was no response. And whether all are so near that one look will
        find them."""
        unknowns = np.where(self.found.converged[:, None], self.found.unknowns, np.nan)
        if self.directions is None or self.by is None:
            return unknowns, False
        change = model.values - self.found.model.values
        share = np.linalg.lstsq(self.directions.T, change, rcond=None)[0]
        step, scale = np.einsum("d,dpk->pk", share, self.by), self.found.seat.scale
        n = step.shape[1] - 1
        farthest = np.max(np.abs(step / scale[:, : n + 1])[:, [0, 1, n]], axis=1)
        unknowns[:, : n + 1] += np.where((farthest < _REACH)[:, None], step, 0.0)
        return unknowns, bool(np.all(farthest < _NEAR) and np.all(self.found.converged))


@dataclass(frozen=True, eq=False)
class Curves:
    """The points of some sweeps that had settled, one sweep after another.

    **Arguments:** `settled`: per sweep, (n,) which of its points these are; `points`: as the solver takes them;
    `measured`: (points,) amplitude, m; `phase`: (points,) rad, NaN where none was measured; `deviation`,
    `phase_deviation`: (points,); `steps` of the solver per period; `white`: (points, 2, 2) L⁻¹; `slices`: the points of
    each sweep; `heard`: the harmonics of the points; `known`: what was found last, by equation.
    """

    sweeps: tuple[Sweep, ...]
    settled: tuple[np.ndarray, ...]
    points: Points
    measured: np.ndarray
    phase: np.ndarray
    deviation: np.ndarray
    phase_deviation: np.ndarray
    steps: int
    white: np.ndarray
    slices: tuple[slice, ...]
    heard: Heard
    known: dict[Equation, Known] = field(default_factory=dict)

    @property
    def phased(self) -> np.ndarray:
        """(points,) whether the phase was measured."""
        return np.isfinite(self.phase)

    @property
    def count(self) -> int:
        """How many numbers were measured."""
        return len(self.phase) + int(np.count_nonzero(self.phased)) + self.heard.count

    def apart(self, equation: Equation, found: Controlled | None) -> Curves:
        """The same with responses of its own, those `found` where they are known: one reading may have several motions,
        and a search is not to go on from those of another."""
        known = self.known.get(equation)
        if found is not None and np.all(found.converged) and (known is None or known.found is not found):
            known = Known(found)
        return replace(self, known={} if known is None else {equation: known})

    def places(self, own: slice) -> np.ndarray:
        """Which of the numbers are those of a sweep, (k,): its amplitudes, its phases, then its harmonics."""
        points = np.arange(own.start, own.stop)
        after = len(self.phase) + np.cumsum(self.phased) - 1
        last = len(self.phase) + int(np.count_nonzero(self.phased)) + self.heard.places(points)
        return np.concatenate([points, after[points][self.phased[points]], last])

    def solve(self, equation: Equation, values: np.ndarray, directions: np.ndarray | None = None) -> Controlled:
        """The model's steady responses with the measured amplitudes; `directions`, (d, m) of the values, along which
        the slopes will be asked for."""
        model = Periodic(equation, np.asarray(values, float), self.steps)
        known = self.known.get(equation)
        if known is None:
            found = at_amplitude(model, self.points)
        else:
            start, near = known.moved_to(model)
            found = at_amplitude(model, self.points, start, directions if near else None)
        self.known[equation] = Known(found)
        return found

    def residuals(self, found: Controlled) -> np.ndarray:
        """(count,) (model − measured) in noise floors: of all amplitudes, then of the phases."""
        raised = (self.measured / self.points.amplitude) ** (1 / (1 + self.points.tilt))
        ratio = found.needed * raised / self.points.level
        rows = self.rows(-np.log(ratio * np.exp(1j * np.where(self.phased, self.phase, -np.angle(ratio)))))
        if self.heard.count:
            rows[len(rows) - self.heard.count :] = self.heard.residuals(found.overtones(self.heard.orders))
        return rows

    def rows(self, logarithms: np.ndarray) -> np.ndarray:
        """Differences of the logarithm of the drive, (…, points), in noise floors, (…, count); of harmonics none."""
        both = np.stack([np.real(logarithms), np.imag(logarithms)], axis=-1)
        white = np.einsum("pij,...pj->...pi", self.white, both)
        none = np.zeros((*white.shape[:-2], self.heard.count))
        return np.concatenate([white[..., 0], white[..., self.phased, 1], none], axis=-1)

    def slopes(self, found: Controlled, directions: np.ndarray) -> np.ndarray:
        """Derivatives of the residuals along directions (d, m) of the values, (d, count)."""
        if not len(directions):
            return np.zeros((0, self.count))
        moved = found.moves(directions)
        self.known[found.model.equation] = Known(found, directions, moved.unknowns)
        rows = self.rows(-moved.needed / found.needed)
        if self.heard.count:
            orders = self.heard.orders
            change = self.heard.slopes(found.overtones(orders), found.overtone_slopes(orders, directions))
            rows[:, rows.shape[1] - self.heard.count :] = change
        return rows

    @np.errstate(over="ignore", invalid="ignore")  # where the model has no steady response
    def weighed(self, equation: Equation, values: np.ndarray) -> Curves:
        """The same with the noise carried through the model at these values."""
        here = self.solve(equation, values)
        amplitude = self.points.amplitude
        off, beside = [], self.beside(here)
        for there in beside:
            good = there.converged & here.converged
            linear = (there.points.amplitude / amplitude) ** (1 / (1 + self.points.tilt))
            off.append(np.log(np.where(good, there.needed / here.needed, linear)))
        found = self.with_deviations(np.array(off))
        if not self.heard.count:
            return found
        three = (one.overtones(self.heard.orders) for one in (here, *beside))
        return replace(found, heard=self.heard.weighed(*three))

    def beside(self, here: Controlled) -> tuple[Controlled, Controlled]:
        """The model's steady responses with amplitudes that are larger, and smaller, by the noise."""
        above, below = (
            np.maximum(self.points.amplitude + side * self.deviation, 0.1 * self.points.amplitude)
            for side in (1.0, -1.0)
        )
        there = lambda amplitude: at_amplitude(
            here.model, self.points._replace(amplitude=amplitude), here.unknowns.copy()
        )
        return there(above), there(below)

    def with_deviations(self, off: np.ndarray) -> Curves:
        """The same if the noise of the amplitude changes the logarithm of the drive by (2, points), on both sides."""
        return replace(self, white=self._whitening(off))

    def _whitening(self, off: np.ndarray) -> np.ndarray:
        """L⁻¹ of deviations of the logarithm, (2, points), one for each side of the amplitude's noise."""
        both = np.stack([np.real(off), np.imag(off)], axis=-1)  # (2, points, 2)
        spread = 0.5 * np.einsum("spi,spj->pij", both, both)
        spread[:, 1, 1] += np.where(self.phased, self.phase_deviation, 1.0) ** 2
        spread[~self.phased, 0, 1] = spread[~self.phased, 1, 0] = 0.0
        return np.linalg.inv(np.linalg.cholesky(spread))


def lay_curves(sweeps: Sequence[Sweep], model: Model) -> Curves:
    """The points of sweeps for a model, their noise carried through its linear part."""
    kept = tuple(settled(sweep, sweeps) for sweep in sweeps)
    own = lambda parts: (np.asarray(part, float)[rows] for part, rows in zip(parts, kept, strict=True))
    join = lambda parts: np.concatenate(list(own(parts)))
    unknown = lambda s: np.full(len(s.frequency), np.nan)
    measured, deviation = join([s.amplitude for s in sweeps]), join([s.deviation for s in sweeps])
    points = Points(
        join([s.frequency for s in sweeps]),
        join([s.acting for s in sweeps]),
        np.maximum(measured, deviation),  # below its noise an amplitude says no more than that it is small
        join([np.full(len(s.frequency), s.load) for s in sweeps]),
        join([np.full(len(s.frequency), s.quantity == "half-peak-to-peak") for s in sweeps]) > 0,
        np.array(_ACROSS if any(depends_on(effect) == BENT for effect in model.effects) else 0.0),
    )
    phase = join([unknown(s) if s.phase is None else s.phase for s in sweeps])
    noise = float(np.min(deviation / np.maximum(measured, deviation)))
    allowed = np.clip(_SHARE * noise / np.sqrt(len(measured)), _FINEST, _COARSEST)
    ends = np.cumsum([0, *(int(np.count_nonzero(rows)) for rows in kept)])
    places = tuple(slice(int(a), int(b)) for a, b in zip(ends[:-1], ends[1:], strict=True))
    steps = steps_per_period(model.steps_per_period, float(allowed))
    laid = Curves(tuple(sweeps), kept, points, measured, phase, deviation, join([s.phase_deviation for s in sweeps]),
                  steps, np.zeros((0, 2, 2)), places, lay_overtones(sweeps, kept))  # fmt: skip
    linear = (deviation / points.amplitude / (1 + points.tilt)).astype(complex)
    return replace(laid, white=laid._whitening(np.array([linear, -linear])))


def in_smaller_steps(curves: Curves) -> Curves:
    """The same with twice as many steps per period."""
    return replace(curves, steps=2 * curves.steps)
