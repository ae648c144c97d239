"""What a walk from a model to a better one has found: its steps, and the whole of it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Literal, NamedTuple

from ...campaign.campaign import Campaign
from ...fit import Fit
from ..evidence.enough import Role
from ..linearised.regression import Regression
from ..ranking.look import Look
from ..ranking.weigh import Candidate
from .parts import Parts
from .rivals import Rival

Verdict = Literal["adequate", "identified", "ambiguous", "not-in-library"]


class Step(NamedTuple):
    """One addition: what, how much it was predicted and confirmed to gain, what it ties with, and the fit after it.

    `reasons`: why it ties, in words; `tied`: the candidates that do, as scored on `regression`, the fit before;
    `instead`: where an effect and a few simpler ones do as well; `partner`: the effect that was added with it, where
    neither alone explains what both do together; `rivals`: what stood against it; `moved`: whether its laws have come
    to another minimum since its ties were told.
    """

    added: str
    predicted_gain: float
    confirmed_gain: float
    tie_set: tuple[str, ...]
    role: Role
    fit: Fit
    reasons: tuple[str, ...] = ()
    tied: tuple[Candidate, ...] = ()
    regression: Regression | None = None
    instead: Parts | None = None
    partner: str | None = None
    rivals: tuple[Rival, ...] = ()
    moved: bool = False


class Walked(NamedTuple):
    """A walk so far: the fit it began with, its steps, and the gains of what the first of them had tried."""

    start: Fit
    steps: tuple[Step, ...] = ()
    gains: Mapping[str, float] = MappingProxyType({})

    @property
    def final(self) -> Fit:
        """The fit with all that was added."""
        return self.steps[-1].fit if self.steps else self.start


@dataclass(frozen=True, eq=False)
class Discovery:
    """The whole walk.

    **Arguments:** `start`: the fit it began with; `steps`: in order; `ranking`: candidates at the start, best first,
    and `confirmed`: gain of those that were refitted; `remaining`: significant candidates at the end; `regression`: of
    the end; `lacking`: share of the first excess that the named effects leave although it has a structure; `shorter`:
    formula of one law that says more than they do, with fewer numbers.
    """

    verdict: Verdict
    start: Fit
    steps: tuple[Step, ...]
    ranking: tuple[Candidate, ...]
    confirmed: Mapping[str, float]
    remaining: tuple[Candidate, ...]
    regression: Regression
    lacking: float = 0.0
    shorter: str = ""

    @property
    def final(self) -> Fit:
        """The fit with all that was found."""
        return self.steps[-1].fit if self.steps else self.start


class Ended(NamedTuple):
    """A walk that adds nothing more, unquestioned.

    **Arguments:** `look`: at its last fit; `at_best`: where it began, with the `ranking` there; `anew`: the records as
    they are to be read, where it has to be gone once more.
    """

    walked: Walked
    look: Look
    at_best: Regression
    ranking: tuple[Candidate, ...]
    anew: Campaign | None = None
