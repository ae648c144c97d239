"""`fit(model, campaign)` is a Fit: parameters with honest uncertainties, and the model's reading of every record."""

from __future__ import annotations

from dataclasses import replace
from functools import partial

import numpy as np

from ..campaign.campaign import Campaign
from ..campaign.record import Sweep, Trace
from ..model import Model
from ..pulse import Report
from .finish import Minimum, finish
from .linear.one_tone import hold_dragged, hold_gain, hold_quality, with_quality
from .minimise import AT_THE_FLOOR, minimise
from .problem import of_sweeps
from .result import Fit, SigmaChoice
from .solve import MAX_STEPS, How
from .task import Points
from .unseen import hold_unseen


def fit(
    model: Model,
    campaign: Campaign,
    *,
    sigma: SigmaChoice = "known",
    robust: bool = False,
    starts: int = 0,
    seed: int = 0,
    initial: Points | None = None,
    begun: np.ndarray | None = None,
    report: Report = lambda _: None,
    most: int = MAX_STEPS,
    until: float = np.inf,
) -> Fit:
    """Fit a model to the records of a campaign that are not held out.

    Minimises Σ ((measured − model)/σ)² over the fitted parameters and the initial states of the records that do not
    start at rest, from the records' own linear guess, from the effects' grids, and from `starts` random points
    around the first; or from `initial` alone, one point or several (SI, all parameters), with the initial states
    `begun` (records, s) SI that an earlier search found there, if they are known. The grids are tried until one start
    ends at the noise floor. A quality factor that steady sines of one frequency do not determine is held, at the value
    with which the model reaches the noise floor if there is one.

    **Arguments:** `sigma`: "known" (noise floors as given or estimated), "scaled" (error bars times the error over
    noise), "fitted" (each record's own residual); `robust`: large residuals count linearly; `report`: called with
    progress in words; `most` steps per start; `until`: the `time.monotonic()` at which the search ends where it is,
    not converged.

    **Raises:** UserError if there is nothing to fit.
    """
    if not campaign.fitted_sweeps:  # a curve tells gain and quality, whatever the traces do
        model = hold_quality(hold_gain(model, campaign.fitted), campaign.fitted)
    else:
        model = hold_unseen(model, campaign)
    all_else = with_quality(model)
    search = partial(minimise, campaign=campaign, how=How(robust, most, until))
    asked = partial(search, initial=initial, begun=begun, starts=starts, seed=seed, report=report)
    found = asked(model)
    if model.undetermined != all_else.undetermined and found.error > AT_THE_FLOOR:
        # What is left of the record's beginning may tell the quality factor after all.
        other = search(all_else, initial=found.values)
        if other.error < AT_THE_FLOOR:
            found = search(model, initial=other.values)
    elif found.error > AT_THE_FLOOR and not campaign.fitted_sweeps:
        held = hold_dragged(model, found.values, campaign.fitted)
        if held is not model:
            model, found = held, asked(held)
    if sigma == "fitted":
        campaign = _with_residual_noise(campaign, found)
        again = fit(model, campaign, robust=robust, initial=found.values, report=report, most=most, until=until)
        return replace(again, sigma="fitted", starts=found.starts)
    report("uncertainties")
    return finish(model, campaign, found, sigma)


def _with_residual_noise(campaign: Campaign, found: Minimum) -> Campaign:
    records, places = list(campaign.records), iter(found.data.tape.slices)
    sweeps = of_sweeps(found.data, found.best.found.residuals)
    for i, record in enumerate(records):
        if isinstance(record, Trace) and not record.holdout:
            own = next(places)
            residual = found.best.found.residuals[own][record.counted] * record.noise.sigma
            noise = replace(record.noise, sigma=float(np.sqrt(np.mean(residual**2))), method="residual of the fit")
            records[i] = replace(record, noise=noise)
        elif isinstance(record, Sweep) and not record.holdout:
            size = float(np.sqrt(np.mean(sweeps[record.name] ** 2)))
            noise = replace(record.noise, sigma=size * record.noise.sigma, method="residual of the fit")
            scaled = {name: None if (told := getattr(record, name)) is None else size * told
                      for name in ("relative_noise", "phase_noise", "own_noise")}  # fmt: skip
            records[i] = replace(record, noise=noise, **scaled)
    return replace(campaign, records=tuple(records))
