"""Records whose transient has died away: they begin on a periodic orbit of the model, and no start of theirs is
fitted.

An orbit is followed as the parameters move: Newton's method begins where the nearest of the orbits found so far says
that it should be, to first order. Which of several orbits it is, was told by the record: the first is the one to which
Newton's method leads from the initial state that fits the record best.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from functools import lru_cache
from typing import NamedTuple

import numpy as np

from ..campaign.record import Trace
from ..response import Equation, Tape
from ..response.lane import lane_of
from ..response.orbit import Orbit, find_orbit, find_orbits, prelude_of

_KEPT = 24  # orbits that are remembered of each record: those of a search


class Known(NamedTuple):
    """An orbit at some `values` (m,), and the `directions` (d, m) along which its slopes are."""

    values: np.ndarray
    directions: np.ndarray
    orbit: Orbit

    def move_to(self, values: np.ndarray) -> np.ndarray:
        """How its start (s,) moves to other values, to first order."""
        if not len(self.directions):
            return np.zeros_like(self.orbit.start)
        share = np.linalg.lstsq(self.directions.T, values - self.values, rcond=None)[0]
        return share @ self.orbit.slopes


@dataclass(frozen=True, eq=False)
class Steady:
    """A steady record, the `record`-th of a fit: a period of its drive, the `unit` (s,) of its start, and the orbits
    that were found, the first one first."""

    record: int
    prelude: Tape
    unit: np.ndarray
    known: list[Known] = field(default_factory=list)

    def at(self, equation: Equation, values: np.ndarray, directions: np.ndarray, width: int) -> Orbit:
        """Its orbit at some values, and its derivatives along directions (d, m)."""
        moves = [known.move_to(values) for known in self.known]
        nearest = min(range(len(moves)), key=lambda k: float(np.max(np.abs(moves[k] / self.unit))))
        known = self.known[nearest]
        same = not len(directions) or np.array_equal(known.directions, directions)
        if same and np.array_equal(known.values, values):
            return known.orbit
        guess = known.orbit.start + _at_most(moves[nearest], self.unit)
        found = find_orbit(equation, self.prelude, values, directions, guess, self.unit, width)
        if found.found:
            if not len(self.known[0].directions):  # an orbit without slopes does not tell where it goes
                self.known.clear()
            self.known.append(Known(values, directions, found))
            del self.known[1:-_KEPT]
        return found

    def many(self, equation: Equation, values: np.ndarray) -> np.ndarray:
        """Starts (k, s) of its orbits at k sets of values (k, m), from the first that was found alone; NaN where none
        was."""
        first = self.known[0]
        guesses = np.array([first.orbit.start + _at_most(first.move_to(one), self.unit) for one in values])
        starts, found = find_orbits(equation, self.prelude, values, guesses, first.orbit, self.unit)
        nothing = np.zeros((0, values.shape[1]))
        for k in np.flatnonzero(~found):  # the derivatives are others there
            alone = find_orbit(equation, self.prelude, values[k], nothing, guesses[k], self.unit)
            starts[k] = alone.start if alone.found else np.nan
        return starts

    def stepped(self, record: Trace, substeps: int) -> Steady:
        """The same in other steps of the solver; where its orbit was, the next one is looked for."""
        last = self.known[-1]
        return replace(self, prelude=_prelude(record, substeps), known=[last._replace(directions=last.directions[:0])])

    def mirrored(self, record: Trace, substeps: int) -> Steady:
        """That of the record with its drive turned round, as physics has it that are symmetric."""
        first = self.known[0]
        turned = first.orbit._replace(start=-first.orbit.start, slopes=-first.orbit.slopes)
        return replace(self, prelude=_prelude(record, substeps), known=[first._replace(orbit=turned)])


def _at_most(step: np.ndarray, unit: np.ndarray) -> np.ndarray:
    """A step of a start, no longer than its unit: where a slope leads far, the orbit is somewhere else by then."""
    return step / max(float(np.max(np.abs(step / unit))), 1.0)


def repeats(record: Trace, equation: Equation) -> bool:
    """Whether a record is steady, with a drive and a model that come back to where they were."""
    return record.start == "steady" and _repeated(record) and equation.timeless


def _repeated(record: Trace) -> bool:
    return record.period is not None and record.driven


def no_orbit(record: Trace, equation: Equation) -> str:
    """Why a record that is called steady is on no periodic orbit."""
    if not _repeated(record):
        return "its drive does not repeat itself"
    if not equation.timeless:
        return "the model changes with time"
    return "no stable periodic motion of the model was found for it"


@lru_cache(maxsize=64)  # hypotheses about one record ask for it again
def _prelude(record: Trace, substeps: int) -> Tape:
    assert record.period is not None  # it repeats
    return prelude_of(lane_of(record, substeps), record.period * record.step)


def begin_steady(
    record: Trace, place: int, substeps: int, equation: Equation, values: np.ndarray, guess: np.ndarray,
    unit: np.ndarray, width: int,
) -> Steady | None:  # fmt: skip
    """A steady record on the stable orbit that is nearest to a guess of its start, (s,); None if there is none.

    `place`: which record of the fit it is; `substeps` of the solver per sample. A memory that nothing moves stays as a
    record begins with it.
    """
    prelude = _prelude(record, substeps)
    nothing = np.zeros((0, len(values)))
    fresh = np.concatenate([guess[:2], np.zeros(len(guess) - 2)])
    for one in (fresh, guess):
        found = find_orbit(equation, prelude, values, nothing, one, unit, width)
        if found.stable:
            return Steady(place, prelude, unit, [Known(values, nothing, found)])
    return None
