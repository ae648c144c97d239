"""`fit(model, campaign)` is a Fit: parameters with honest uncertainties, and the model's reading of every record."""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import replace
from functools import partial

import numpy as np

from ..campaign.campaign import Campaign
from ..campaign.record import Sweep, Trace
from ..errors import UserError
from ..model import FREQUENCY, QUALITY, Model
from ..pulse import Pulse, Report
from ..response import Tape
from . import solve
from .assemble import assemble_fit, at_values, begin, begin_at, tape_of
from .finish import Minimum, finish
from .fit_starts import fit_starts
from .linear.guess import DataScales, LinearGuess
from .linear.one_tone import hold_dragged, hold_gain, hold_quality, with_quality
from .on_orbits import on_orbits
from .problem import Data, Evaluation, Static, Unknowns, evaluate, of_sweeps, reweighed
from .race import cost_of, race
from .result import Fit, SigmaChoice, Start
from .settled import Search, settled
from .start_scale import small_size
from .starts import base_values, first_guess, random_points, scales_of, starting_points
from .unseen import hold_unseen

_KEPT_STARTS = 4  # of the grid, the ones whose first error is smallest
_IN_A_RACE = 6  # the same of starts whose ends are only compared
_AT_THE_FLOOR = 1.02  # error over noise with which no further start of the grid can be better
_REWEIGHED = 4  # times that the noise of curves is carried through the model anew, at most
_NEAR = 0.01  # of the cost: the search itself goes the rest
_ROUNDS = 2  # in which initial states are fitted before a search: they enter almost linearly
_SPREAD = 0.3  # of a parameter, by which random starts move it at most
_SEEN = 1.0  # noise floors of all numbers together by which a slope moves them at a small size, to be one
_LAST_STEPS = 25  # of a search in short steps of the solver, at most: the one in long ones has led near the minimum
_SETTLED = 0.01  # relative change of the cost by new weights that is not worth another search


def fit(
    model: Model,
    campaign: Campaign,
    *,
    sigma: SigmaChoice = "known",
    robust: bool = False,
    starts: int = 0,
    seed: int = 0,
    initial: np.ndarray | Sequence[np.ndarray] | None = None,
    begun: np.ndarray | None = None,
    report: Report = lambda _: None,
    most: int = solve.MAX_STEPS,
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
    search = partial(minimise, robust=robust, most=most, until=until)
    asked = partial(search, campaign=campaign, starts=starts, seed=seed, initial=initial, begun=begun, report=report)
    found = asked(model)
    if model.undetermined != all_else.undetermined and found.error > _AT_THE_FLOOR:
        # What is left of the record's beginning may tell the quality factor after all.
        other = search(all_else, campaign, initial=found.values)
        if other.error < _AT_THE_FLOOR:
            found = search(model, campaign, initial=other.values)
    elif found.error > _AT_THE_FLOOR and not campaign.fitted_sweeps:
        held = hold_dragged(model, found.values, campaign.fitted)
        if held is not model:
            model, found = held, asked(held)
    if sigma == "fitted":
        campaign = _with_residual_noise(campaign, found)
        again = fit(model, campaign, robust=robust, initial=found.values, report=report, most=most, until=until)
        return replace(again, sigma="fitted", starts=found.starts)
    report("uncertainties")
    return finish(model, campaign, found, sigma)


def minimise(
    model: Model,
    campaign: Campaign,
    *,
    robust: bool = False,
    starts: int = 0,
    seed: int = 0,
    initial: np.ndarray | Sequence[np.ndarray] | None = None,
    begun: np.ndarray | None = None,
    report: Report = lambda _: None,
    most: int = solve.MAX_STEPS,
    compared: bool = False,
    until: float = np.inf,
    scales: DataScales | None = None,
) -> Minimum:
    """The least-squares minimum alone, without uncertainties; arguments as in `fit`, `most` steps per start, and
    whether it is only `compared` with that of another model. `scales`: by which limits are placed, if not those of the
    campaign's records: of all records, where these are a part."""
    records, sweeps = campaign.fitted, campaign.fitted_sweeps
    if not records and not sweeps:
        what = "the campaign has no record that is not held out"
        raise UserError(what, do="add a record with holdout = false")
    told = [] if initial is None else list(np.atleast_2d(np.asarray(initial, float)))
    if told:
        guess = LinearGuess(float(told[0][FREQUENCY]), float(told[0][QUALITY]), float("nan"), float("nan"))
    else:
        report("reading the resonance off the records")
        guess = first_guess(model, campaign)
    scales = scales or scales_of(campaign, guess.frequency)
    base = told[0] if told else base_values(model, guess, scales)
    static, data = assemble_fit(model, campaign, guess, scales, base, compared=True)
    report(f"compiling the model ({len(static.free)} parameters, {len(records) + len(sweeps)} records)")
    points = told or starting_points(model, base, scales)
    if not told and starts:
        points = [base, *random_points(model, base, starts, _SPREAD, seed)]
    candidates = _first_errors(static, data, points, bool(told), begun)
    if sweeps and not told and (off := _off_zero(model, candidates[0], static, scales)):
        candidates = sorted([*candidates, *_first_errors(static, data, off, False, begun)], key=lambda start: start[0])
    if compared or not (starts or told):
        candidates = candidates[: _IN_A_RACE if told else _KEPT_STARTS]
    if told:  # what a start of a grid leaves says nothing of what the model will; costs of one race are of one kind
        misfit = data.misfit_of(candidates[0][-1])
        candidates = [(cost, there._replace(misfit=misfit), at, found) for cost, there, at, found in candidates]
    per_sample = lambda cost: float(np.sqrt(cost / data.count))

    def begun_at(start: tuple[float, Data, Unknowns, Evaluation]) -> solve.Search:
        own, (_, there, at, found) = static, start
        known: Evaluation | None = found
        if told:  # else the first search says which of several orbits a steady record shows
            own, there, at = on_orbits(static, there, records, at)
            known = None if there.steady else found
        return solve.Search(own, there, at, robust, known, compared)

    def go_on(number: int, one: solve.Search, most: int) -> None:
        stage = f"least squares, start {number} of {len(candidates)}"
        report(stage)
        pulse = Pulse(report, stage)
        one.go_on(most, lambda cost: pulse.beat(f"error over noise {per_sample(cost):.3g}"), until)

    if compared:
        searches = [begun_at(start) for start in candidates]
        race(searches, most, go_on)
    else:
        searches = []
        for number, start in enumerate(candidates, 1):
            searches.append(begun_at(start))
            go_on(number, searches[-1], most)
            enough = not starts and not told and per_sample(searches[-1].cost) < _AT_THE_FLOOR
            if time.monotonic() > until or enough:
                break
    # All starts had the same weights; those of the best one's model are its own.
    chosen = min(range(len(searches)), key=lambda i: cost_of(searches[i]))
    static, (data, best) = searches[chosen].static, searches[chosen].found
    pulse = Pulse(report, "least squares")
    watch = lambda cost: pulse.beat(f"error over noise {per_sample(cost):.3g}")
    search = lambda static, data, unknowns, most, begun=None: solve.least_squares(
        static, data, unknowns, robust, most, begun, watch, compared, until
    )
    static, data, best = settled(static, data, records, best, search, most, compared)
    data, best = _reweighed(static, data, best, search, most)
    data, best = _remembered(static, data, best, search, most)
    if not compared:
        data, best = _exactly(static, data, records, best, tape_of(model, campaign, guess, base), search, most)
    ends = [best if i == chosen else one.found[1] for i, one in enumerate(searches)]
    table = tuple(
        Start(per_sample(first), per_sample(end.cost), end.steps, end.converged)
        for (first, *_), end in zip(candidates, ends, strict=False)
    )
    return Minimum(static, data, best, table, scales)


def _reweighed(
    static: Static,
    data: Data,
    found: solve.Solution,
    search: Search,
    most: int,
) -> tuple[Data, solve.Solution]:
    """A solution with the noise of the curves carried through the model as it is there; `most` steps in all."""
    sweeps = data.curves is not None or data.passes is not None
    for _ in range(_REWEIGHED if sweeps and np.isfinite(found.cost) else 0):
        before, data = data, reweighed(static, data, found.found.values)
        same = before.curves is None or data.curves is None or np.array_equal(before.curves.white, data.curves.white)
        again = evaluate(static, data, found.unknowns)
        cost = float(again.residuals @ again.residuals)
        settled = (data.passes is None and same) or abs(cost - found.cost) < _SETTLED * found.cost
        found = found._replace(cost=cost, found=again)
        if settled or found.steps >= most:
            break
        data, better = search(static, data, found.unknowns, most - found.steps, again)
        found = better._replace(steps=found.steps + better.steps)
    return data, found


def _remembered(
    static: Static, data: Data, found: solve.Solution, search: Search, most: int
) -> tuple[Data, solve.Solution]:
    """A solution whose histories count against what it leaves itself, not what its start left; `most` steps in all."""
    while found.steps < most and np.isfinite(found.cost):
        misfit = data.misfit_of(found.found)
        held = float(np.sum((data.misfit * found.unknowns.starts[:, 2:]) ** 2))
        if held * (1 - (misfit / data.misfit) ** 2) < _SETTLED * found.cost:
            break
        data, better = search(static, data._replace(misfit=misfit), found.unknowns, most - found.steps, found.found)
        found = better._replace(steps=found.steps + better.steps)
    return data, found


def _exactly(
    static: Static, data: Data, records: Sequence[Trace], found: solve.Solution, tape: Tape, search: Search, most: int
) -> tuple[Data, solve.Solution]:
    """A solution in the steps of the solver that the error bars of its numbers need: those of a model that is only
    compared, which led near it, are up to three times as long."""
    if [span.substeps for span in tape.spans] == [span.substeps for span in data.tape.spans]:
        return data, found
    steady = tuple(one.stepped(records[one.record], tape.spans[one.record].substeps) for one in data.steady)
    data = data._replace(tape=tape, steady=steady)
    data, better = search(static, data, found.unknowns, min(most, _LAST_STEPS))
    return data, better._replace(steps=found.steps + better.steps)


def _first_errors(
    static: Static, data: Data, points: list[np.ndarray], known: bool, begun: np.ndarray | None
) -> list[tuple[float, Data, Unknowns, Evaluation]]:
    """Starting points with Σ r², the unknowns and the model at each, best first.

    Initial states as they were read; where the parameters are `known` nearly, fitted first: a start read off a few
    samples is wrong by many noise floors, which a search mends by moving parameters away from where they belong. Near a
    hilltop of the spring it may have no bound at all, so that those that were `begun` with before are taken instead.
    """
    judged = []
    for point in points:
        there = at_values(data, static, point)
        unknowns = begin(there, static) if begun is None else begin_at(there, static, begun)
        if known and static.starts_free:
            unknowns, found = fit_starts(static, there, unknowns, _ROUNDS, _NEAR)
        else:
            found = evaluate(static, there, unknowns)
        judged.append((float(found.residuals @ found.residuals), there, unknowns, found))
    return sorted(judged, key=lambda start: start[0])


def _off_zero(
    model: Model, start: tuple[float, Data, Unknowns, Evaluation], static: Static, scales: DataScales
) -> list[np.ndarray]:
    """Starts beside one at which amplitudes have no slope that would lead a search away from zero: an even force does
    nothing to a fundamental there, whichever its sign."""
    _, data, _, found = start
    sizes = np.array([small_size(model.parameters[i].unit, scales, model.linear.mass) for i in static.free])
    per_unit = np.linalg.norm(found.by_x, axis=1) / np.where(data.scale == 0, 1.0, data.scale)
    flat = [i for i, size, slope in zip(static.free, sizes, per_unit, strict=True)
            if found.values[i] == 0 and model.parameters[i].kind == "amplitude" and size * slope < _SEEN]  # fmt: skip
    points = []
    for sign in (1.0, -1.0) if flat else ():
        point = found.values.copy()
        point[flat] = [sign * sizes[static.free.index(i)] for i in flat]
        points.append(point)
    return points


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
