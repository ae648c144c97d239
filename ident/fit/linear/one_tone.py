"""One steady sine: amplitude and phase are two numbers, and a linear oscillator has three.

Any quality factor then fits, with a resonance and a gain to go with it. Left free, it does not stay undetermined: a
missing effect drags it along the line to where slow exponentials or a stiff resonance mimic a little of the misfit.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from ...campaign.drive import drive_frequency
from ...campaign.record import Trace
from ...model import FREQUENCY, QUALITY, Model

_SAME = 2e-3  # relative difference of frequencies that count as one
_STEADY = 0.01  # change of the fundamental from the first half of a record to the second


def hold_quality(model: Model, records: Sequence[Trace]) -> Model:
    """The model with its quality factor `undetermined`, if steady sines of one frequency are all there is to determine
    it, and free else."""
    steady = _one_frequency(records) and all(map(_steady, records))
    return _held(model) if steady else with_quality(model)


def with_quality(model: Model) -> Model:
    """The model with a quality factor that is fitted."""
    return replace(model, undetermined=model.undetermined - {_quality_of(model)})


def _quality_of(model: Model) -> str:
    return f"{model.linear.prefix}.quality"


def gain_of(model: Model) -> str:
    """Full name of the drive's gain."""
    return f"{model.linear.prefix}.{model.linear.gain_name}"


def hold_gain(model: Model, records: Sequence[Trace]) -> Model:
    """The model without a drive, its gain `undetermined` at zero, if none of the records has one that changes.

    A further mode then keeps the travel that it starts with, in units of which its history is fitted.
    """
    name = gain_of(model)
    gains = {f"{effect.name}.{gain}" for effect in model.effects for gain in effect.gains}
    if any(record.driven for record in records):
        return replace(model, undetermined=model.undetermined - {name} - gains)
    if name in model.freed | model.held:
        return model
    start = (*((known, value) for known, value in model.start if known != name), (name, 0.0))
    return replace(model, start=start, undetermined=model.undetermined | {name} | (gains - model.freed - model.held))


def hold_dragged(model: Model, values: np.ndarray, records: Sequence[Trace]) -> Model:
    """The model with its quality factor `undetermined`, if with these values (SI) a motion begun before the records, at
    the one frequency that they have, would outlast them all: what changed within them then was no ringing down.

    For models that do not describe the records: one that does may have found a sharp resonance.
    """
    frequency, quality = float(values[FREQUENCY]), float(values[QUALITY])
    lasts = quality / (np.pi * frequency)
    begun = all(record.start != "rest" for record in records)
    outlasts = begun and _one_frequency(records) and all(lasts > record.time[-1] - record.time[0] for record in records)
    return _held(model) if outlasts else model


def _held(model: Model) -> Model:
    name = _quality_of(model)
    return model if name in model.freed | model.held else replace(model, undetermined=model.undetermined | {name})


def _one_frequency(records: Sequence[Trace]) -> bool:
    frequencies = [drive_frequency(record) for record in records]
    return max(frequencies, default=0.0) < (1 + _SAME) * min(frequencies, default=0.0)


def _steady(record: Trace) -> bool:
    """Whether drive and response are one periodic motion from beginning to end, the drive a sine."""
    if record.start == "rest" or record.period is None:
        return False
    omega = drive_frequency(record) * record.step
    half = int(len(record.time) // 2 // (2 * np.pi / omega) * (2 * np.pi / omega))
    if half < 2 * record.period:
        return False
    turn = np.exp(-1j * omega * np.arange(len(record.time)))
    lines = lambda x: np.array([np.mean((x * turn)[:half]), np.mean((x * turn)[-half:])])
    driven, answer = lines(record.drive - np.mean(record.drive)), lines(record.response - np.mean(record.response))
    pure = 2 * abs(driven[0]) ** 2 > 0.98 * np.var(record.drive)
    return bool(pure and abs(answer[1] - answer[0]) < _STEADY * abs(answer[0]))
