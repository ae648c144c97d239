"""From a model and records to the arrays that the compiled code works on."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..campaign.campaign import Campaign
from ..campaign.record import Trace
from ..model import FREQUENCY, Model, ModelParameter
from ..response import Equation, Tape, at_rest, divided, lay_out
from .coordinates import to_coordinates
from .curves import Curves, lay_curves
from .linear.guess import DataScales, LinearGuess
from .passes import Passes, lay_passes
from .problem import Data, Static, Unknowns
from .start_scale import size_of_hidden
from .zeros import lay_zeros

_TIED_FOR = 0.25  # of a period of the resonance: displacement and velocity at the start, two numbers, need no more
_ON = 0.1  # of a limit: data scales of other records of the same device differ by that


def assemble(
    model: Model,
    campaign: Campaign,
    records: Sequence[Trace],
    tape: Tape,
    values: np.ndarray,
    scales: DataScales | None = None,
    held: bool = False,
    curves: Curves | None = None,
    passes: Passes | None = None,
) -> tuple[Static, Data]:
    """The arrays of a fit to the records on a tape, to curves and to passes, whose unknowns are the model's fitted
    parameters, at `values` (m,) SI; if `held`, only the initial states."""
    parameters = model.parameters
    fitted = [i for i, p in enumerate(parameters) if p.fitted]
    free = () if held else tuple(fitted)
    bounds = np.array([bounds_of(parameters[i], float(values[i]), scales) for i in free]).reshape(-1, 2)
    priors = [campaign.priors.get(parameters[i].name) for i in free]
    values, equation = np.asarray(values, float), Equation(model)
    frequency = float(values[FREQUENCY])
    moving = any(record.start != "rest" for record in records)
    states = 2 + len(equation.history_units) * moving
    swings = equation.swings(values)
    data = Data(
        tape,
        np.concatenate([np.zeros(0), *(record.response for record in records)]),
        np.concatenate([np.zeros(0), *(weight_of(record, frequency) for record in records)]),
        np.array([start_scale(record, frequency, equation, swings)[:states] for record in records]).reshape(-1, states),
        values,
        bounds[:, 0],
        bounds[:, 1],
        np.ones(len(free)),
        np.zeros(len(free)),
        np.array([0.0 if p is None else p.mean for p in priors]),
        np.array([0.0 if p is None else 1.0 / p.deviation for p in priors]),
        curves,
        passes,
        zeros=lay_zeros(records),
    )
    moving = bool(np.any(data.start_scale))
    static = Static(equation, free, moving, len(fitted) + states * moving)
    return static, at_values(data, static, values)


def assemble_fit(
    model: Model,
    campaign: Campaign,
    guess: LinearGuess,
    scales: DataScales,
    base: np.ndarray,
    values: np.ndarray | None = None,
    substeps: Sequence[int] | None = None,
    compared: bool = False,
) -> tuple[Static, Data]:
    """The arrays of a fit to the records of a campaign that are not held out, at `values` (m,) SI, else at `base`.

    Guess and base, where a search starts, say in which steps the solver goes, if not so many `substeps` per sample of
    each record are known; `compared`, whether a model is only compared with others, and no number of it is reported.
    """
    records, sweeps = campaign.fitted, campaign.fitted_sweeps
    slow, fast = [s for s in sweeps if not s.fast], [s for s in sweeps if s.fast]
    given = None if substeps is None else divided(records, substeps)
    tape = given or tape_of(model, campaign, guess, base, compared)
    curves = lay_curves(slow, model) if slow else None
    passes = lay_passes(fast, model) if fast else None
    at = base if values is None else values
    return assemble(model, campaign, records, tape, at, scales, curves=curves, passes=passes)


def tape_of(model: Model, campaign: Campaign, guess: LinearGuess, base: np.ndarray, compared: bool = False) -> Tape:
    """The records of a campaign that are not held out; arguments as of `assemble_fit`."""
    frequency = max(guess.frequency, float(base[FREQUENCY]))
    return lay_out(campaign.fitted, frequency, guess.quality, model, compared)


def weight_of(record: Trace, frequency: float) -> np.ndarray:
    """1/σ of the samples that count, (n,).

    Of skipped ones the first hold the initial state: without them nothing does, and a start that is free runs away to
    where it mimics a little of what the model lacks. They weigh as much as any sample, for what a wrong model gains by
    such a start grows with its misfit in noise floors too.
    """
    index = np.arange(len(record.time))
    first = index < max(round(_TIED_FOR / (frequency * record.step)), 5)
    counted = (index >= record.skip) | (first if record.start != "rest" else False)
    return (counted if record.masked is None else counted & ~record.masked) / record.noise.sigma


def start_scale(record: Trace, frequency: float, equation: Equation, swings: np.ndarray) -> np.ndarray:
    """Typical displacement, velocity and hidden states of an equation of motion, in their units, of a record that does
    not start at rest, else zero; `swings` of the hidden states. A reading of acceleration, in m/s², is as large as ω²
    displacements."""
    omega = 2 * np.pi * frequency
    amplitude = (float(np.max(np.abs(record.response))) or 1.0) / omega**record.order
    units, volts = equation.history_units_of(record.order), float(np.max(np.abs(record.drive))) or 1.0
    hidden = size_of_hidden(units, amplitude, volts, omega) * swings
    return (record.start != "rest") * np.array([amplitude, amplitude * omega, *hidden])


def bounds_of(parameter: ModelParameter, value: float, scales: DataScales | None) -> tuple[float, float]:
    """Lower and upper bound of a parameter (SI) in a fit that starts from `value`."""
    if not parameter.positive:
        return -np.inf, np.inf
    if parameter.limits is None or scales is None:
        return 0.0, np.inf
    unit = getattr(scales, parameter.limits_scale)
    # A value that the user gave outside the usual limits moves them; one that an earlier fit left on a limit does not.
    low, high = parameter.limits[0] * unit, parameter.limits[1] * unit
    return (low if value > low * (1 - _ON) else value / 3), (high if value < high * (1 + _ON) else value * 3)


def at_values(data: Data, static: Static, values: np.ndarray) -> Data:
    """The same fit with x = 0 at `values`."""
    chosen = values[list(static.free)]
    lower, upper = np.asarray(data.lower), np.asarray(data.upper)
    anchor = to_coordinates(chosen, lower, upper)
    scale = np.where(np.isfinite(lower), 1.0, np.where(chosen == 0, 1.0, np.abs(chosen)))
    return data._replace(template=values, anchor=anchor, scale=scale)


def begin(data: Data, static: Static) -> Unknowns:
    """Unknowns to start from: x = 0, initial states read off the first samples, above what the sensor shows at rest.

    A laser reads its distance, tens of times the motion: a stage that began there would leave the well of its spring.
    """
    omega = 2 * np.pi * float(data.template[FREQUENCY])
    zero = at_rest(static.equation, data.template)
    starts = [_measured_start(data.response[own] - zero, lane.step * span.substeps, int(lane.order), omega)
              for own, lane, span in zip(data.tape.slices, data.tape.lanes, data.tape.spans, strict=True)]  # fmt: skip
    found = np.zeros_like(data.start_scale)
    found[:, :2] = np.array(starts).reshape(-1, 2)
    return begin_at(data, static, found)


def begin_at(data: Data, static: Static, begun: np.ndarray) -> Unknowns:
    """The same with initial states (records, s) SI that are known."""
    scale = np.where(data.start_scale > 0, data.start_scale, 1.0)
    return Unknowns(np.zeros(len(static.free)), np.where(data.start_scale > 0, begun / scale, 0.0))


def _measured_start(response: np.ndarray, step: float, order: int, omega: float) -> np.ndarray:
    """Displacement and velocity read off the first samples; where a derivative of the displacement of some `order` was
    measured, those of a free motion that begins so."""
    few = min(5, len(response))
    line = np.polynomial.polynomial.polyfit(np.arange(few), response[:few], min(2, few - 1))
    at, rate = float(line[0]), float(line[1]) / step
    if order == 1:
        return np.array([-rate / omega**2, at])
    return np.array([at, rate]) / (-(omega**2) if order else 1.0)
