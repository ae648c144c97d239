"""Fast sweeps in a fit: every pass simulated in time as it was run, and read as the instrument read it.

    r = (|Y| − A)/σ,   (arg Y − φ)/σ_φ

with the reading Y of a point (`response.passage`) at the parameters, and its derivatives through the same march. What
the phase in which a pass began may change of it counts as noise. A pass begins on the periodic orbit of the model at
its first frequency; where it has none, nothing had moved before.

Source: as of `response.transient` and `response.orbit`.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import lru_cache
from typing import NamedTuple

import numpy as np

from ..campaign.record import Sweep
from ..model import FREQUENCY, GAIN, QUALITY, Model
from ..response import Equation, respond
from ..response.orbit import find_orbit
from ..response.passage import Passages, lay_passages
from ..response.periodic import steps_per_period
from .start_scale import size_of_hidden

_SHARE = 0.1  # of the noise floor of all points together: so far the solver's step may move the response
_FINEST, _COARSEST = 1e-6, 1e-3  # of the response, whatever the noise


class Passed(NamedTuple):
    """Readings of a model: `tone` (points,) complex, m; by how much it may be `off`, (points,); and its derivatives
    `slopes` (d, points)."""

    tone: np.ndarray
    off: np.ndarray
    slopes: np.ndarray


@dataclass(frozen=True, eq=False)
class Passes:
    """The points of fast sweeps, one pass after another.

    **Arguments:** `passages`: as the solver takes them; `measured`, `phase` (NaN where none was measured), `deviation`,
    `phase_deviation`: (points,); `steps` of the solver a period; `off`: (points,) m, by which readings of a model may
    be off, in either direction; `known`: where orbits were found last, by equation.
    """

    sweeps: tuple[Sweep, ...]
    passages: Passages
    measured: np.ndarray
    phase: np.ndarray
    deviation: np.ndarray
    phase_deviation: np.ndarray
    steps: int
    off: np.ndarray
    known: dict[Equation, dict[int, np.ndarray]] = field(default_factory=dict)

    @property
    def phased(self) -> np.ndarray:
        """(points,) whether the phase was measured."""
        return np.isfinite(self.phase)

    @property
    def count(self) -> int:
        """How many numbers were measured."""
        return len(self.phase) + int(np.count_nonzero(self.phased))

    def points_of(self, sweep: int) -> np.ndarray:
        """Which of the points are those of a sweep, in the order of its file."""
        own = np.array([k for k, _ in self.passages.runs])[self.passages.pass_of] == sweep
        points = np.flatnonzero(own)
        return points[np.argsort(self.passages.rows[points])]

    def places(self, sweep: int) -> np.ndarray:
        """Which of the numbers are those of a sweep, (k,): its amplitudes, then its phases."""
        points = self.points_of(sweep)
        after = len(self.phase) + np.cumsum(self.phased) - 1
        return np.concatenate([points, after[points][self.phased[points]]])

    @property
    def order(self) -> np.ndarray:
        """The numbers one sweep after another."""
        return np.concatenate([self.places(k) for k in range(len(self.sweeps))])

    @np.errstate(over="ignore", invalid="ignore")  # a motion without bound is refused for its cost
    def solve(self, equation: Equation, values: np.ndarray, directions: np.ndarray, width: int = 0) -> Passed:
        """Readings at some values (m,) SI, and derivatives along directions (d, m); `width`, how many directions a
        march takes at least."""
        width, start = max(width, len(directions)), []
        for k, prelude in enumerate(self.passages.preludes):
            start.append(self._begun(equation, k, prelude, values, directions, width))
        begin, kicks = np.array([s for s, _ in start]), np.stack([d for _, d in start], axis=1)
        filled = np.zeros((width, len(values)))
        filled[: len(directions)] = directions
        wide = np.zeros((width, *begin.shape))
        wide[: len(directions)] = kicks
        found = respond(equation, self.passages.tape, values, begin, filled, wide)
        slopes, _ = self.passages.read(found.slopes[: len(directions)])
        return Passed(*self.passages.read(found.readings), slopes)

    def weighed(self, equation: Equation, values: np.ndarray, width: int = 0) -> Passes:
        """The same with what the beginning of a pass may change of the model's readings at these values as noise."""
        off = np.abs(self.solve(equation, values, np.zeros((0, len(values))), width).off) / np.sqrt(2.0)
        return replace(self, off=np.where(np.isfinite(off), off, 0.0))

    def _begun(
        self, equation: Equation, k: int, prelude, values: np.ndarray, directions: np.ndarray, width: int
    ) -> tuple[np.ndarray, np.ndarray]:
        """The state in which a pass begins, (s,), and its derivatives (d, s)."""
        lane, n = prelude.lanes[0], 2 + len(equation.history_units)
        omega, level = float(lane.omega), complex(lane.voltage[0], -lane.rate[0] / lane.omega)
        mass, (_, force) = equation.model.mass_of(values), equation.constants
        stiffness, damping = equation.model.spring_and_damper(values[FREQUENCY], values[QUALITY], mass)
        answer = values[GAIN] * force * level / (stiffness - (mass + lane.load) * omega**2 + 1j * omega * damping)
        size = max(abs(answer), 1e-300)
        hidden = size_of_hidden(equation.history_units, size, abs(level), omega) * equation.swings(values)
        unit = np.array([size, omega * size, *hidden])
        guess = np.zeros(n)
        guess[:2] = answer.real, (1j * omega * answer).real
        known = self.known.setdefault(equation, {})
        if equation.timeless:
            for begin in (known[k], guess) if k in known else (guess,):
                found = find_orbit(equation, prelude, values, directions, begin, unit, width)
                if found.found:
                    known[k] = found.start
                    return found.start, found.slopes
        return np.zeros(n), np.zeros((len(directions), n))

    def residuals(self, found: Passed) -> np.ndarray:
        """(count,) (model − measured) in noise floors: of all amplitudes, then of the phases."""
        off = np.angle(found.tone * np.exp(-1j * np.where(self.phased, self.phase, 0.0)))
        size, turn = self._noise
        return np.concatenate([(np.abs(found.tone) - self.measured) / size, (off / turn)[self.phased]])

    def slopes(self, found: Passed) -> np.ndarray:
        """Derivatives of the residuals along the directions of the readings, (d, count)."""
        relative = found.slopes / np.where(found.tone == 0, 1.0, found.tone)
        size, turn = self._noise
        return np.concatenate(
            [np.abs(found.tone) * relative.real / size, (relative.imag / turn)[:, self.phased]], axis=1
        )

    @property
    def _noise(self) -> tuple[np.ndarray, np.ndarray]:
        """Standard deviations of amplitudes, m, and phases, rad, (points,) each."""
        turn = self.off / np.maximum(self.measured, self.deviation)
        return np.hypot(self.deviation, self.off), np.hypot(self.phase_deviation, turn)


def lay_passes(sweeps: Sequence[Sweep], model: Model) -> Passes:
    """The passes of fast sweeps for a model, in steps that err by less than a tenth of what the noise of all points
    together lets a response be known to."""
    noise = min(float(np.min(sweep.deviation / np.maximum(sweep.amplitude, sweep.deviation))) for sweep in sweeps)
    count = sum(len(sweep.frequency) for sweep in sweeps)
    allowed = float(np.clip(_SHARE * noise / np.sqrt(count), _FINEST, _COARSEST))
    return _laid(tuple(sweeps), steps_per_period(model.steps_per_period, allowed))


@lru_cache(maxsize=8)  # the models that are compared on some sweeps lie on the same tape
def _laid(sweeps: tuple[Sweep, ...], steps: int) -> Passes:
    passages = lay_passages(sweeps, steps)
    which = np.array([k for k, _ in passages.runs])[passages.pass_of]
    joined = lambda parts: np.array([parts[k][row] for k, row in zip(which, passages.rows, strict=True)], float)
    unknown = [np.full(len(s.frequency), np.nan) if s.phase is None else s.phase for s in sweeps]
    measured = joined([s.amplitude for s in sweeps])
    return Passes(sweeps, passages, measured, joined(unknown), joined([s.deviation for s in sweeps]),
                  joined([s.phase_deviation for s in sweeps]), steps, np.zeros(len(measured)))  # fmt: skip


def in_smaller_steps(passes: Passes) -> Passes:
    """The same with twice as many steps a period."""
    twice = lay_passages(passes.sweeps, 2 * passes.steps)
    return replace(passes, passages=twice, steps=2 * passes.steps, known={})
