"""What stands against an effect when it is added: the names between which that step chooses."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import NamedTuple

from ..evidence.equivalences import mistaken
from ..ranking.confirm import Confirmed, confirm
from ..ranking.look import Look
from ..ranking.weigh import Candidate
from ..side_by_side import at_once

_KEPT = 5  # of a step: those that were refitted, then the best of the others


class Rival(NamedTuple):
    """A candidate that was not taken: shares of the error beyond noise, as it was before the step, that it was
    predicted to remove and did in a refit; None if it was not refitted."""

    name: str
    predicted_gain: float
    confirmed_gain: float | None = None


def beside_the_tried(name: str, tried: Iterable[Confirmed], look: Look) -> list[Confirmed]:
    """Refits of the laws for which an effect is mistaken and whose scores had not promised enough to be tried.

    A score is of first order: an even force moves the mean and makes a second harmonic, and only its square a
    resonance. Where held-out records are not foretold by a law that leaves only noise of the fitted ones, that is no
    reason against another.
    """
    known = {found.candidate.name for found in tried}
    likely = mistaken(look.library[name], look.library) - known
    asked = [candidate for candidate in look.candidates if candidate.name in likely]
    return at_once(lambda one: confirm(look.regression, look.library[one.name], one), asked, look.report, "rivals")


def rivals_of(added: str, candidates: Iterable[Candidate], gains: Mapping[str, float]) -> tuple[Rival, ...]:
    """The candidates that stood against the one that was added, refitted ones first, the best first; `gains`: of
    refits."""
    others = [Rival(c.name, c.predicted_gain, gains.get(c.name)) for c in candidates if c.name != added]
    order = lambda one: (one.confirmed_gain is None, -(one.confirmed_gain or 0.0), -one.predicted_gain)
    return tuple(sorted(others, key=order)[:_KEPT])
