"""`ident.fit(data)`: a fit of records as they come, from files or memory, on the linear model that they ask for."""

from __future__ import annotations

import time
from collections.abc import Iterable, Sequence
from functools import partial
from numbers import Integral
from typing import Any, get_args

import numpy as np

from ..campaign.campaign import Campaign
from ..campaign.read import read_campaign
from ..effects.effect import AbstractEffect
from ..effects.registry import effect_class
from ..errors import UserError
from ..model import Model, make_effect
from ..pulse import Report
from ..threads import one_thread
from .fit import fit
from .floors import sharpened
from .linear.start_model import start_model, with_drives
from .result import Fit, SigmaChoice

Effects = Model | Sequence[str | type[AbstractEffect]] | str | None
"""A model, or what `model_for` makes one of: names of effects, or classes of one's own."""


@one_thread
def fit_data(
    data: Any,
    effects: Effects = None,
    *,
    sigma: SigmaChoice = "known",
    robust: bool = False,
    starts: int = 0,
    seed: int = 0,
    initial: np.ndarray | None = None,
    seconds: float = np.inf,
    report: Report = lambda _: None,
    **told: Any,
) -> Fit:
    """Fit the records of `data` that are not held out, by least squares; what `ident fit` does, without its run folder.

    **Arguments:**

    - `data`, `told`: a campaign, files, or arrays, as of `read_campaign`.
    - `effects`: names of effects, or effect classes of one's own, instead of those of the campaign; () is the linear
      model alone. Or a whole model.
    - `sigma`, `robust`: what the error bars stand on, as in `ident.fit.fit.fit`.
    - `starts`, `seed`: random starts beside those that the records suggest; `initial`: (m,) SI, the one point to start
      from instead, such as `Fit.values` of a search that `seconds` ended. `report`: called with progress in words.

    **Raises:** UserError for data, effects or settings that cannot be used.
    """
    until = time.monotonic() + seconds
    if sigma not in get_args(SigmaChoice):
        raise UserError(f"sigma = {sigma!r} is no such choice", do=f"choose one of {', '.join(get_args(SigmaChoice))}")
    for name, number in (("starts", starts), ("seed", seed)):  # of NumPy, too
        if not isinstance(number, Integral) or isinstance(number, bool) or number < 0:
            raise UserError(f"{name} = {number!r} is no such number", do="give a whole number, 0 or more")
    campaign = with_drives(read_campaign(data, **told))
    model = model_for(campaign, effects, report)
    if initial is not None:
        initial = _initial(initial, model)
    fitted = partial(
        fit, model, sigma=sigma, robust=robust, starts=starts, seed=seed, initial=initial, report=report, until=until
    )
    found = fitted(campaign)
    sharper = None if sigma == "fitted" or time.monotonic() >= until else sharpened(found, complete=False)
    again = found if sharper is None else fitted(sharper)
    return again if again.converged or not found.converged else found  # whose time may have run out


def _initial(initial: Any, model: Model) -> np.ndarray:
    """(m,) SI, where a search shall begin. **Raises:** UserError if it is no value of each parameter."""
    names = [p.name for p in model.parameters]
    try:
        values = np.zeros(0) if np.iscomplexobj(initial) else np.asarray(initial, dtype=float)
    except (TypeError, ValueError):
        values = np.zeros(0)
    if values.shape != (len(names),) or not np.all(np.isfinite(values)):
        what = "initial is no value of each parameter"
        raise UserError(what, do=f"give {len(names)} finite numbers, SI: {', '.join(names)}")
    return values


def model_for(campaign: Campaign, effects: Effects, report: Report = lambda _: None) -> Model:
    """The model of a fit: as it is, or with the linear part that the records choose and these effects."""
    if isinstance(effects, Model):
        return effects
    several = isinstance(effects, Iterable) and not isinstance(effects, (str, type))
    asked = None if effects is None else tuple(effects) if several else (effects,)
    names = None if asked is None else [one for one in asked if isinstance(one, str)]
    model = start_model(campaign, names, report)
    for own in () if asked is None else asked:
        if not isinstance(own, str):
            one = effect_class(own)
            model = model + make_effect(campaign, one.name, {one.name: one})
    return model
