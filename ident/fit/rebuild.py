"""A Fit from numbers that were found before: everything but the search."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..campaign.campaign import Campaign
from ..model import Model
from ..response import divided, lay_out
from . import solve
from .assemble import assemble, begin
from .curves import lay_curves
from .finish import Minimum, finish
from .fit_starts import fit_starts
from .on_orbits import on_orbits
from .problem import evaluate
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
) -> Fit:
    """The Fit of a model at given values: readings and uncertainties are computed anew, but nothing is searched.

    Only unknown initial states are fitted, at those values.

    **Arguments:** `values`: (m,) SI, in the order of `model.parameters`; `sigma`, `starts`, `converged`: as the search
    reported them; `substeps`: of the solver per sample of each fitted record, if they are known.
    """
    records = campaign.fitted
    guess = first_guess(model, campaign)
    scales = scales_of(campaign, guess.frequency)
    first = float(base_values(model, guess, scales)[0])  # the search chose its solver step from the same numbers
    if substeps is None:
        tape = lay_out(records, max(guess.frequency, first), guess.quality, model)
    else:
        tape = divided(records, substeps)
    curves = lay_curves(campaign.fitted_sweeps, model) if campaign.fitted_sweeps else None
    static, data = assemble(model, campaign, records, tape, np.asarray(values, float), scales, curves=curves)
    if curves is not None:
        data = data._replace(curves=curves.weighed(static.equation, np.asarray(values, float)))
    data, unknowns, found = solve.rescale(static, data, begin(data, static))
    if static.starts_free:
        unknowns, found = fit_starts(static, data, unknowns)
        static, data, unknowns = on_orbits(static, data, records, unknowns)
    if data.steady:
        found = evaluate(static, data, unknowns)
    there = solve.Solution(unknowns, float("nan"), 0, converged, found)
    return finish(model, campaign, Minimum(static, data, there, tuple(starts), scales), sigma)
