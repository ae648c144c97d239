"""How finely the solver divides each record."""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import lru_cache

import numpy as np

from ..campaign.record import Trace
from ..model import ABOVE_THE_DRIVE, Model
from .lane import ALLOWED, lane_of
from .tape import Tape, lay

_UNSEEN = 0.03  # of the noise, by which a motion may miss: χ² is then a thousandth too large at the most
_SHARPEST = 250  # steps in a period, along a path, with which dry friction is told by its score


def lay_out(records: Sequence[Trace], frequency: float, quality: float, model: Model, compared: bool = False) -> Tape:
    """Records on a tape, with a solver step small enough for their noise floors and for the sharpest effect.

    **Arguments:** `frequency` (Hz) and `quality` of the resonance, roughly; `compared` as of `steps_of`.
    """
    finest, form = model.coarsest, model.form
    return divided(records, [steps_of(r, frequency, quality, finest, form, compared) for r in records])


def lay_path(records: Sequence[Trace], frequency: float, quality: float, model: Model, tape: Tape) -> Tape:
    """Records on a tape along whose path derivatives are taken, and effects that the model lacks; `tape`: the fit's.

    No number is reported of these, so that steps which the sharpest effect needs do where those of the fit are shorter.
    The kinks of the model itself are followed in steps that are short everywhere only, and a memory may be faster than
    the motion.
    """
    form, own = model.form, [span.substeps for span in tape.spans]
    if model.coarsest < model.steps_per_period or any(effect.hidden_units for effect in model.effects):
        needed = [steps_of(r, frequency, quality, model.steps_per_period, form) for r in records]
        return divided(records, [max(pair) for pair in zip(needed, own, strict=True)])
    enough = [steps_of(r, frequency, quality, max(model.steps_per_period, _SHARPEST), form, True) for r in records]
    return divided(records, [min(pair) for pair in zip(enough, own, strict=True)])


def divided(records: Sequence[Trace], substeps: Sequence[int], allowed: float = ALLOWED) -> Tape:
    """Records on a tape, with so many solver steps per sample of each; `allowed` as of `lane_of`."""
    return _laid(tuple(records), tuple(substeps), allowed)


@lru_cache(maxsize=6)  # the models that are compared on some records lie on the same tape
def _laid(records: tuple[Trace, ...], substeps: tuple[int, ...], allowed: float) -> Tape:
    return lay([lane_of(record, each, allowed) for record, each in zip(records, substeps, strict=True)], substeps)


def steps_of(
    record: Trace, frequency: float, quality: float, finest: int, form: str = "oscillator", compared: bool = False
) -> int:
    """Steps per sample for which the method's error moves the natural frequency by less than a tenth of its error bar;
    `finest` of them in a period of the resonance at the least.

    The phase error of Runge–Kutta steps is (ωh)⁴/120 per radian. It always has the same sign, so that samples do not
    average it as they do the noise: near resonance ln ω is known to σ/(2Q √n rms), or to σ/(ωT √n rms) by a record that
    is over, after T, before the motion has forgotten its beginning; a tenth of that is allowed.
    (With σ/10 instead of σ/(10 √n) 400 simulated campaigns returned frequencies 0.18 error bars too high.)
    In an excerpt no frequency is reported: σ/10 is fine, and so is half of the steps that sharp effects need. Nor is
    one of a model that is only `compared` with others, by residuals which another frequency then makes up for.
    An overdamped motion has a decay of rate ω/Q, of which a step may hold two times: it has no bound beyond 2.8.
    The edges of a drive that is held are a filter 1 − (ωh)²/12. A gain takes up a part, and is then as wrong; what is
    left comes after every edge alike, and is seen where there are many.
    Of a resonance that stands for none, far above what is driven, nothing is asked: its steps need a bound only.
    """
    signal = float(np.std(record.response)) or 1.0
    share = 0.1 / (1.0 if record.excerpt else math.sqrt(len(record.time)))
    if compared:
        share = max(share, _UNSEEN)
    allowed = share * min(max(record.noise.sigma / signal, 1e-4), 0.1)
    omega = 2 * math.pi * frequency
    remembered = max(2 * quality, 2.0)  # radians
    if record.start != "steady":  # what repeats itself has gone on for ever
        remembered = min(remembered, max(omega * (record.time[-1] - record.time[0]), 2.0))
    largest = (120 * allowed / remembered) ** 0.25
    slower = 1.0  # than the resonance, what moves
    if form == "quasi-static":
        largest, slower = 0.5, ABOVE_THE_DRIVE
    if finest:
        largest = min(largest, 2 * math.pi / finest * slower * (2 if record.excerpt else 1))
    if record.edge is not None:
        largest = min(largest, math.sqrt(12 * _UNSEEN * min(record.noise.sigma / signal, 0.1)) * slower)
    if quality < 0.5:
        largest = min(largest, 2.0 * quality)
    return int(np.clip(math.ceil(omega * record.step / largest - 0.05), 1, 32))
