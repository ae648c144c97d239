"""A fit as the numbers of `run.json`, format 1."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..campaign.record import Record, Trace
from ..fit.curve_reading import CurveReading, Jump, RunReading
from ..fit.judge import RecordScore, Score
from ..fit.result import Estimate, Fit
from ..units import plain_micro
from .words.linear import linear_dict
from .words.own_numbers import own_numbers_dict
from .words.quantity import display_unit, finite
from .words.tables import combination_sentences, flag_words


def run_dict(fit: Fit) -> dict[str, Any]:
    """A fit as plain numbers, strings and lists, ready for `json.dumps(..., allow_nan=False)`.

    Values of parameters are SI (of an oscillator: in the units of its columns); errors of records are in the
    record's own unit, totals in that of the first record.
    """
    first, curves = fit.campaign.records[0], iter(fit.curves)
    return {
        "format": 1,
        "effects": list(fit.model.names),
        "converged": bool(fit.converged),
        "sigma": fit.sigma,
        "linear": linear_dict(fit),
        "parameters": [_parameter(e, fit) for e in fit.estimates],
        "undetermined": list(combination_sentences(fit)),
        "fitted": _score(fit.fitted, first),
        "holdout": None if fit.holdout is None else _score(fit.holdout, first),
        "records": [
            _record(score, record) if isinstance(record, Trace) else _sweep(score, next(curves), fit)
            for score, record in zip(fit.scores, fit.campaign.records, strict=True)
        ],
        **({"left_out": [record.name for record, _ in fit.campaign.left_out]} if fit.campaign.left_out else {}),
        **({"own_numbers": own_numbers_dict(fit)} if fit.campaign.heldout_sweeps else {}),
    }


def _parameter(estimate: Estimate, fit: Fit) -> dict[str, Any]:
    entry = {
        "name": estimate.name,
        "value": finite(estimate.value),
        "standard_error": None if estimate.standard_error is None else finite(estimate.standard_error),
        "unit": display_unit(estimate.unit, fit.model.device, plain=True),
        "flags": list(estimate.flags),
    }
    if entry["standard_error"] is None:
        entry["reason"] = flag_words(estimate.flags) or "its covariance is singular"
    return entry


def _score(score: Score | RecordScore, record: Record) -> dict[str, Any]:
    channel = record.response_channel
    return {
        "n": int(score.n),
        "rmse": finite(score.rmse / channel.factor),
        "unit": plain_micro(channel.unit),
        "noise_rmse": finite(score.noise_rmse / channel.factor),
        "error_over_noise": finite(score.error_over_noise),
        "error_over_signal": finite(score.error_over_signal),
    }


def _record(score: RecordScore, record: Record) -> dict[str, Any]:
    return {"file": score.name, "holdout": bool(score.holdout), **_score(score, record)}


def _sweep(score: RecordScore, curve: CurveReading, fit: Fit) -> dict[str, Any]:
    factor = curve.sweep.response_channel.factor
    return {
        **_record(score, curve.sweep),
        "kind": "sweep",
        "peak": finite(float(np.max(curve.sweep.amplitude)) / factor),
        "apart": int(np.count_nonzero(curve.apart)),
        "levels": [_level(run, curve, fit) for run in curve.runs],
    }


def _level(run: RunReading, curve: CurveReading, fit: Fit) -> dict[str, Any]:
    sweep, factor = curve.sweep, curve.sweep.response_channel.factor
    counted = ~run.apart & np.isfinite(run.reading)
    difference = (sweep.amplitude[run.run.rows] - run.reading)[counted]
    return {
        "drive": finite(run.run.level / sweep.drive_channel.factor),
        "direction": "up" if run.run.up else "down",
        "n": int(np.count_nonzero(counted)),
        "rmse": finite(float(np.sqrt(np.mean(difference**2))) / factor) if np.any(counted) else None,
        "jump": None if run.jump is None else jump_dict(run.jump, fit),
    }


def jump_dict(jump: Jump, fit: Fit) -> dict[str, Any]:
    """A jump as measured and as the model has it, Hz."""
    return {"measured": jump.measured, "model": jump.model, "standard_error": jump_error(jump, fit), "unit": "Hz"}


def jump_error(jump: Jump, fit: Fit) -> float | None:
    """Standard error of the model's jump, Hz; None where it has none."""
    if jump.slope is None:
        return None
    slope = jump.slope[list(fit.free)]
    return finite(float(np.sqrt(max(slope @ fit.covariance @ slope, 0.0))))
