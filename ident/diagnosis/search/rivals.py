"""What stood against an effect when it was added: the names between which that step chose."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import NamedTuple

from ..ranking.weigh import Candidate

_KEPT = 5  # of a step: those that were refitted, then the best of the others


class Rival(NamedTuple):
    """A candidate that was not taken: shares of the error beyond noise, as it was before the step, that it was
    predicted to remove and did in a refit; None if it was not refitted."""

    name: str
    predicted_gain: float
    confirmed_gain: float | None = None


def rivals_of(added: str, candidates: Iterable[Candidate], gains: Mapping[str, float]) -> tuple[Rival, ...]:
    """The candidates that stood against the one that was added, refitted ones first, the best first; `gains`: of
    refits."""
    others = [Rival(c.name, c.predicted_gain, gains.get(c.name)) for c in candidates if c.name != added]
    order = lambda one: (one.confirmed_gain is None, -(one.confirmed_gain or 0.0), -one.predicted_gain)
    return tuple(sorted(others, key=order)[:_KEPT])
