"""A candidate that was confirmed and taken, as the step of a walk: what it ties with, and what stood against it."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType

from ...effects.registry import Registry
from ...fit import Fit
from ..evidence.enough import Role
from ..linearised.regression import Regression
from ..ranking.confirm import Confirmed
from ..ranking.weigh import Candidate
from .rivals import rivals_of
from .steps import Step
from .ties import weighed_ties


def step_with(
    found: Confirmed,
    regression: Regression,
    real: list[Candidate],
    library: Registry,
    role: Role,
    fit: Fit,
    *,
    tried: list[Confirmed],
    gains: Mapping[str, float] = MappingProxyType({}),
) -> Step:
    """The step that adds what was found.

    **Arguments:** `regression`: of the fit before, with the `real` candidates there; `fit`: with what was found;
    `tried`: refits of candidates, the one that was found among them, and `gains` of refits.
    """
    name = found.candidate.name
    ties, tied = weighed_ties(regression, found, real, library, tried)
    return Step(
        added=name,
        predicted_gain=found.candidate.predicted_gain,
        confirmed_gain=found.gain,
        tie_set=ties.names,
        role=role,
        fit=fit,
        reasons=ties.reasons,
        tied=tied,
        regression=regression,
        rivals=rivals_of(name, real, gains),
    )
