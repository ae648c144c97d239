"""The reading of a model with given parameters: what it says the sensor should have shown."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from ..campaign.campaign import Campaign
from ..campaign.record import Trace
from ..model import FREQUENCY, QUALITY, Model
from ..response import lay_out
from .assemble import assemble, begin
from .coordinates import slopes
from .fit_starts import fit_starts_of_others
from .on_orbits import on_orbits
from .problem import evaluate, motions
from .uncertainty import told_by_start

_ENOUGH = 1e-3  # of the cost: initial states of records that are only compared need no more


def read(model: Model, values: np.ndarray, records: Sequence[Trace], compared: bool = False) -> list[np.ndarray]:
    """Readings of a model with given parameters; unknown initial states, and zeros of the records' own, are fitted, as
    well as it takes if it is only `compared` with others."""
    return [motion + zero for motion, zero in read_and_zeros(model, values, records, compared)]


def read_and_zeros(
    model: Model, values: np.ndarray, records: Sequence[Trace], compared: bool = False
) -> list[tuple[np.ndarray, np.ndarray]]:
    """As `read`, of each record the motion and the zero of its own beside the one by which it is read."""
    tape = lay_out(records, float(values[FREQUENCY]), float(values[QUALITY]), model, compared)
    campaign = Campaign("", tuple(records), model.device)
    static, data = assemble(model, campaign, records, tape, values, held=True)
    unknowns = begin(data, static)
    if static.starts_free:
        unknowns, found = fit_starts_of_others(static, data, unknowns, _ENOUGH if compared else 0.0)
        static, data, unknowns = on_orbits(static, data, records, unknowns)
        motion = motions(static, data, unknowns) if data.steady else found.response.readings
    else:
        motion = motions(static, data, unknowns)
    zero = data.zeros_beside(motion)  # a number, also beside a motion without bound
    return [(motion[own], zero[own]) for own in tape.slices]


def read_with_slopes(model: Model, values: np.ndarray, record: Trace) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Reading (n,) of a model with given parameters, and how it changes, of a record read by the zero that it has.

    **Returns:** the reading; its derivatives by the fitted parameters, (n, p), with an unknown initial state fitted
    anew; what such a state may add to it, (n, q) orthonormal, q = 0 if none is unknown.
    """
    record = replace(record, floats=False)
    tape = lay_out([record], float(values[FREQUENCY]), float(values[QUALITY]), model)
    campaign = Campaign("", (record,), model.device)
    static, data = assemble(model, campaign, [record], tape, values)
    unknowns = begin(data, static)
    if static.starts_free:
        held = assemble(model, campaign, [record], tape, values, held=True)
        unknowns = unknowns._replace(starts=fit_starts_of_others(*held, begin(held[1], held[0]))[0].starts)
        static, data, unknowns = on_orbits(static, data, [record], unknowns)
    found = evaluate(static, data._replace(weight=np.ones(len(record.time))), unknowns)
    unit = slopes(values[list(static.free)], data.lower, data.upper) * data.scale
    (own,) = tape.slices
    by_value = (found.by_x[:, own] / unit[:, None]).T
    basis = told_by_start(found.by_start[:, own] / record.noise.sigma)
    return found.readings[own], by_value - basis @ (basis.T @ by_value), basis
