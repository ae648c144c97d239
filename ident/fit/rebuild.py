"""A Fit from numbers that were found before: everything but the search."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..campaign.campaign import Campaign
from ..model import Model
from . import solve
from .assemble import assemble_fit, begin, begin_at
from .finish import Minimum, finish
from .fit_starts import fit_starts
from .on_orbits import on_orbits
from .problem import evaluate, reweighed
from .result import Fit, SigmaChoice, Start
from .starts import base_values, first_guess, scales_of


def fit_at(
    model: Model,
    campaign: Campaign,
    values: np.ndarray,
    *,
    sigma: SigmaChoice = "known",
    starts: Sequence[Start] = (),
    converged: bool = True,
    substeps: Sequence[int] | None = None,
    begun: np.ndarray | None = None,
) -> Fit:
    """The Fit of a model at given values: readings and uncertainties are computed anew, but nothing is searched.

    Only unknown initial states are fitted, at those values.

    **Arguments:** `values`: (m,) SI, in the order of `model.parameters`; `sigma`, `starts`, `converged`: as the search
    reported them; `substeps`: of the solver per sample of each fitted record, and `begun` (records, s) SI, the initial
    states that it found, if they are known and those of this model: plays remember for ever how a record began, and
    from its first samples alone the search for that may end elsewhere.
    """
    records = campaign.fitted
    guess = first_guess(model, campaign)
    scales = scales_of(campaign, guess.frequency)
    base, values = base_values(model, guess, scales), np.asarray(values, float)
    static, data = assemble_fit(model, campaign, guess, scales, base, values, substeps)
    data = reweighed(static, data, values)
    if begun is not None and np.shape(begun) == data.start_scale.shape and np.all(np.isfinite(begun)):
        first = begin_at(data, static, begun)
    else:
        first = begin(data, static)
    data, unknowns, found = solve.rescale(static, data, first)
    if static.starts_free:
        unknowns, found = fit_starts(static, data, unknowns)
        static, data, unknowns = on_orbits(static, data, records, unknowns)
    if data.steady:
        found = evaluate(static, data, unknowns)
    there = solve.Solution(unknowns, float("nan"), 0, converged, found)
    return finish(model, campaign, Minimum(static, data, there, tuple(starts), scales), sigma)


def values_without(parent: Fit, *names: str) -> np.ndarray:
    """Values of all parameters but those of some effects."""
    return np.array([v for p, v in zip(parent.model.parameters, parent.values, strict=True) if p.effect not in names])
