"""`fit(model, campaign)` is a Fit: parameters with honest uncertainties, and the model's reading of every record."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Callable, Literal, NamedTuple, Sequence

import numpy as np

from ..campaign.campaign import Campaign
from ..campaign.record import Trace
from ..errors import UserError
from ..model import Model, ModelParameter
from ..response import Equation, Group, make_groups
from ..response.groups import Layout
from . import solve
from .guess import DataScales, LinearGuess, data_scales, guess_linear
from .identifiability import Combination, identifiability
from .judge import RecordScore, Score, combine, score_record
from .problem import Blocks, Data, Static, Unknowns, physical
from .starts import base_values, random_points, starting_points
from .uncertainty import Covariance, Linearisation, covariance, linearise

SigmaChoice = Literal["known", "scaled", "fitted"]
Report = Callable[[str], None]
_TRUSTED = 1.1  # error over noise floor above which error bars are said to be untrustworthy
_KEPT_STARTS = 4  # of the grid, the ones whose first error is smallest


class Start(NamedTuple):
    """One start of a fit: the error over noise where it began and ended, steps taken, whether it converged."""

    begin: float
    end: float
    steps: int
    converged: bool


class Estimate(NamedTuple):
    """One parameter as reported; `standard_error` is None where none can be given, and `flags` say why."""

    name: str
    value: float
    standard_error: float | None
    unit: str
    fitted: bool
    flags: tuple[str, ...]


@dataclass(frozen=True, eq=False)
class Fit:
    """A model fitted to a campaign; a value, changed only by fitting again.

    **Arguments:**

    - `values`: (m,) SI, in the order of `model.parameters`; `estimates`: the same with uncertainties and flags.
    - `free`: positions of the fitted parameters; `covariance`: (p, p) of their physical values.
    - `combinations`: what is determined of the parameters that are not determined one by one.
    - `readings`: model reading of each trace of the campaign, in the campaign's order, m.
    - `starts`: every start and where it ended; `sigma`: which standard deviation the error bars stand on.
    - `step_error`: largest discretisation error of any fitted record, in units of its noise floor.
    - `linear`: the fit as a linear regression, for diagnosis.
    """

    model: Model
    campaign: Campaign
    values: np.ndarray
    estimates: tuple[Estimate, ...]
    free: tuple[int, ...]
    covariance: np.ndarray
    combinations: tuple[Combination, ...]
    readings: tuple[np.ndarray, ...]
    scores: tuple[RecordScore, ...]
    starts: tuple[Start, ...]
    sigma: SigmaChoice
    converged: bool
    step_error: float
    scales: DataScales
    spectrum: Covariance
    linear: Linearisation

    @property
    def fitted(self) -> Score:
        score = combine([s for s in self.scores if not s.holdout])
        assert score is not None  # a fit has at least one fitted record
        return score

    @property
    def holdout(self) -> Score | None:
        return combine([s for s in self.scores if s.holdout])

    @property
    def trusted(self) -> bool:
        """Whether the model describes the records well enough for its error bars to mean anything."""
        return self.converged and self.fitted.error_over_noise <= _TRUSTED

    def value(self, name: str) -> float:
        """Value of one parameter by its full name, SI."""
        return float(self.values[[p.name for p in self.model.parameters].index(name)])

    def predict(self, record: Trace) -> np.ndarray:
        """Reading of the fitted model for any record, (n,) m; the initial state is fitted unless it starts at rest."""
        return read(self.model, self.values, [record])[0]


def fit(
    model: Model,
    campaign: Campaign,
    *,
    sigma: SigmaChoice = "known",
    robust: bool = False,
    starts: int = 0,
    spread: float = 0.3,
    seed: int = 0,
    initial: np.ndarray | None = None,
    report: Report = lambda _: None,
) -> Fit:
    """Fit a model to the traces of a campaign that are not held out.

    Minimises Σ ((measured − model)/σ)² over the fitted parameters and the initial states of the records that do not
    start at rest, from the records' own linear guess, from the effects' grids, and from `starts` random points within
    ±`spread` of the best; or from `initial` (SI, all parameters) alone.

    **Arguments:** `sigma`: "known" (noise floors as given or estimated), "scaled" (error bars times the error over
    noise), "fitted" (each record's own residual); `robust`: large residuals count linearly; `report`: called with
    progress in words.

    **Raises:** UserError if there is nothing to fit.
    """
    records = campaign.fitted
    if not records:
        what = "the campaign has sweeps only, and fitting needs" if campaign.sweeps else "the campaign has no"
        raise UserError(f"{what} at least one trace that is not held out", do="add a record with holdout = false")
    report("reading the resonance off the records")
    guess, scales = _first_look(model, records)
    base = base_values(model, guess, scales) if initial is None else np.asarray(initial, float)
    frequency = _reference_frequency(model, guess, base)
    groups, layout = make_groups(records, frequency, guess.quality)
    static, data = assemble(model, campaign, groups, layout, base, robust)
    report(f"compiling the model ({len(static.free)} parameters, {len(records)} records)")
    points = [base] if initial is not None else starting_points(model, base, scales)
    if initial is None and starts:
        points = [base, *random_points(model, base, starts, spread, seed)]
    candidates = _first_errors(static, data, points)[: None if starts else _KEPT_STARTS]
    solutions = []
    for number, (begin, point) in enumerate(candidates, 1):
        report(f"least squares, start {number} of {len(candidates)}")
        solutions.append((begin, *solve.least_squares(static, _at(data, static, point), _begin(groups, static))))
    _, data, best = min(solutions, key=lambda s: s[2].cost if np.isfinite(s[2].cost) else np.inf)
    samples = sum(int(np.count_nonzero(group.weight)) for group in groups)
    per_sample = lambda cost: float(np.sqrt(cost / samples))
    table = tuple(Start(begin, per_sample(s.cost), s.steps, s.converged) for begin, _, s in solutions)
    if sigma == "fitted":
        campaign = _with_residual_noise(campaign, solve.evaluate(static, data, best.unknowns), layout)
        values = np.asarray(physical(static, data, best.unknowns.x))
        again = fit(model, campaign, robust=robust, initial=values, report=report)
        return replace(again, sigma="fitted", starts=table)
    report("uncertainties")
    return finish(model, campaign, static, data, best.unknowns, layout, table, sigma, scales, best.converged)


def _first_look(model: Model, records: Sequence[Trace]) -> tuple[LinearGuess, DataScales]:
    guess = guess_linear(records, model.linear.nominal_frequency)
    return guess, data_scales(records, guess.frequency)


def _reference_frequency(model: Model, guess: LinearGuess, base: np.ndarray) -> float:
    return float(max(guess.frequency, base[0]))


def assemble(
    model: Model, campaign: Campaign, groups: tuple[Group, ...], layout: Layout, values: np.ndarray, robust: bool = False
) -> tuple[Static, Data]:
    """The arrays of a fit whose unknowns are the model's fitted parameters, at `values` (m,) SI."""
    parameters = model.parameters
    free = tuple(i for i, p in enumerate(parameters) if p.fitted)
    positive = np.array([parameters[i].positive for i in free])
    priors = [campaign.priors.get(parameters[i].name) for i in free]
    data = Data(
        groups,
        np.asarray(values, float),
        positive,
        np.ones(len(free)),
        np.zeros(len(free)),
        np.array([0.0 if p is None else p.mean for p in priors]),
        np.array([0.0 if p is None else 1.0 / p.deviation for p in priors]),
    )
    static = Static(Equation(model), layout.substeps, free, robust)
    return static, _at(data, static, np.asarray(values, float))


def _at(data: Data, static: Static, values: np.ndarray) -> Data:
    """The same fit with x = 0 at `values`."""
    chosen = values[list(static.free)]
    anchor = np.where(data.positive, np.log(np.where(data.positive, np.maximum(chosen, 1e-300), 1.0)), chosen)
    scale = np.where(data.positive, 1.0, np.where(chosen == 0, 1.0, np.abs(chosen)))
    return data._replace(template=values, anchor=anchor, scale=scale)


def _begin(groups: tuple[Group, ...], static: Static) -> Unknowns:
    return Unknowns(np.zeros(len(static.free)), tuple(_measured_start(group) for group in groups))


def _measured_start(group: Group) -> np.ndarray:
    """Displacement and velocity read off the first samples, in units of the group's scale."""
    stride = max(1, round((group.lanes.voltage.shape[1] - 1) / 2 / (group.response.shape[1] - 1)))
    step = np.asarray(group.lanes.step) * stride
    few = min(5, group.response.shape[1])
    line = np.polynomial.polynomial.polyfit(np.arange(few), group.response[:, :few].T, min(2, few - 1))
    start = np.stack([line[0], line[1] / step], axis=1)
    return start / group.start_scale * group.free


def _first_errors(static: Static, data: Data, points: list[np.ndarray]) -> list[tuple[float, np.ndarray]]:
    """Starting points with the error over noise at each, best first; the initial states are fitted for the judgement."""
    judged = []
    for point in points:
        unknowns = _begin(data.groups, static)
        found = solve.evaluate(static, _at(data, static, point), unknowns)
        n, cost = 0, 0.0
        for residual, group in zip(found.residuals, data.groups, strict=True):
            n += int(np.count_nonzero(group.weight))
            cost += float(np.sum(np.asarray(residual) ** 2))
        judged.append((float(np.sqrt(cost / n)), point))
    return sorted(judged, key=lambda pair: pair[0])


def _with_residual_noise(campaign: Campaign, found: Blocks, layout: Layout) -> Campaign:
    records, places = list(campaign.records), iter(layout.places)
    for i, record in enumerate(records):
        if isinstance(record, Trace) and not record.holdout:
            group, lane, n = next(places)
            residual = np.asarray(found.residuals[group][lane, record.skip : n]) * record.noise.sigma
            noise = replace(record.noise, sigma=float(np.std(residual)), method="residual of the fit")
            records[i] = replace(record, noise=noise)
    return replace(campaign, records=tuple(records))


def finish(
    model: Model,
    campaign: Campaign,
    static: Static,
    data: Data,
    unknowns: Unknowns,
    layout: Layout,
    starts: tuple[Start, ...],
    sigma: SigmaChoice,
    scales: DataScales,
    converged: bool,
) -> Fit:
    """Uncertainties, identifiability and readings at a solution."""
    records = campaign.fitted
    found = solve.evaluate(static, data, unknowns)
    values = np.asarray(physical(static, data, unknowns.x))
    free, parameters = list(static.free), model.parameters
    linear = linearise(found, layout, records)
    stretch = np.where(data.positive, values[free], 1.0)  # d p / d coordinate
    linear = Linearisation(
        linear.jacobian / np.asarray(data.scale),
        linear.residual,
        linear.spread / np.outer(data.scale, data.scale),
    )
    spectrum = covariance(linear, np.asarray(data.prior_weight) * stretch)
    judged = identifiability([parameters[i] for i in free], values[free], np.asarray(data.positive), spectrum)
    inside = [
        np.asarray(found.residuals[g][lane, :n]) * record.noise.sigma + record.response
        if record.skip == 0
        else None
        for record, (g, lane, n) in zip(records, layout.places, strict=True)
    ]  # fmt: skip
    readings = _all_readings(model, campaign, values, inside)
    scores = tuple(score_record(record, r) for record, r in zip(campaign.traces, readings, strict=True))
    excess = combine([s for s in scores if not s.holdout])
    factor = excess.error_over_noise**2 if sigma == "scaled" and excess is not None else 1.0
    matrix = factor * spectrum.matrix * np.outer(stretch, stretch)
    estimates = _estimates(parameters, values, free, matrix, judged.determined, np.asarray(data.positive))
    return Fit(
        model, campaign, values, estimates, static.free, matrix, judged.combinations, readings, scores, starts, sigma,
        converged, _step_error(model, campaign, values, unknowns, layout, scales), scales, spectrum, linear,
    )  # fmt: skip


def _all_readings(
    model: Model, campaign: Campaign, values: np.ndarray, inside: list[np.ndarray | None]
) -> tuple[np.ndarray, ...]:
    known = iter(inside)
    readings = [None if record.holdout else next(known) for record in campaign.traces]
    missing = [record for record, reading in zip(campaign.traces, readings, strict=True) if reading is None]
    filled = iter(read(model, values, missing) if missing else [])
    return tuple(next(filled) if reading is None else reading for reading in readings)


def read(model: Model, values: np.ndarray, records: Sequence[Trace], refine: int = 1) -> list[np.ndarray]:
    """Readings of a model with given parameters; initial states of records that do not start at rest are fitted."""
    groups, layout = make_groups(records, float(values[0]), float(values[1]), refine)
    held = replace(model, held=frozenset(p.name for p in model.parameters), freed=frozenset())
    static, data = assemble(held, Campaign("", tuple(records), model.device), groups, layout, values)
    unknowns = _begin(groups, static)
    if any(record.start != "rest" for record in records):
        unknowns = _fit_starts(static, data, unknowns)
    paths = solve.readings(static, data, unknowns)
    return [np.asarray(paths[g][lane, :n]) for g, lane, n in layout.places]


def _fit_starts(static: Static, data: Data, unknowns: Unknowns, rounds: int = 6) -> Unknowns:
    """Gauss–Newton on the initial states alone; they enter almost linearly."""
    for _ in range(rounds):
        found = solve.evaluate(static, data, unknowns)
        moved = []
        for residual, slope, group, now in zip(
            found.residuals, found.by_start, data.groups, unknowns.starts, strict=True
        ):
            slope, residual = np.asarray(slope), np.asarray(residual)
            gram = np.einsum("kln,mln->lkm", slope, slope) + 1e-12 * np.eye(2)
            step = np.linalg.solve(gram, np.einsum("kln,ln->lk", slope, residual)[..., None])[..., 0]
            moved.append(np.asarray(now) - step * group.free)
        unknowns = Unknowns(unknowns.x, tuple(moved))
    return unknowns


def _step_error(
    model: Model, campaign: Campaign, values: np.ndarray, unknowns: Unknowns, layout: Layout, scales: DataScales
) -> float:
    """Largest change of any reading when the solver step is halved, in noise floors."""
    records = campaign.fitted
    paths = []
    for refine in (1, 2):
        groups, places = make_groups(records, 1.0 / scales.period, float(values[1]), refine)
        held = replace(model, held=frozenset(p.name for p in model.parameters), freed=frozenset())
        static, data = assemble(held, campaign, groups, places, values)
        found = solve.readings(static, data, Unknowns(np.zeros(0), unknowns.starts))
        paths.append([np.asarray(found[g][lane, :n]) for g, lane, n in layout.places])
    return max(
        float(np.max(np.abs(fine - coarse))) / record.noise.sigma
        for record, coarse, fine in zip(records, *paths, strict=True)
    )


def _estimates(
    parameters: Sequence[ModelParameter],
    values: np.ndarray,
    free: list[int],
    matrix: np.ndarray,
    determined: np.ndarray,
    positive: np.ndarray,
) -> tuple[Estimate, ...]:
    estimates = []
    for i, parameter in enumerate(parameters):
        value = float(values[i])
        if i not in free:
            estimates.append(Estimate(parameter.name, value, None, parameter.unit, False, ("held",)))
            continue
        k = free.index(i)
        error = float(np.sqrt(max(matrix[k, k], 0.0)))
        flags: tuple[str, ...] = ()
        if not determined[k]:
            flags = ("undetermined",)
        elif positive[k] and error > 3 * abs(value):
            flags = ("at-bound",)
        elif error > abs(value):
            flags = ("not-significant",)
        shown = error if determined[k] and np.isfinite(error) and error > 0 else None
        estimates.append(Estimate(parameter.name, value, shown, parameter.unit, True, flags))
    return tuple(estimates)
