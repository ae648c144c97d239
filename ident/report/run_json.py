"""A fit as the numbers of `run.json`, format 1."""

from __future__ import annotations

import math
from typing import Any

from ..campaign.record import Trace
from ..fit.judge import RecordScore, Score
from ..fit.result import Estimate, Fit
from .linear_words import linear_dict
from .quantity import display_unit
from .tables import combination_sentences, flag_words


def run_dict(fit: Fit) -> dict[str, Any]:
    """A fit as plain numbers, strings and lists, ready for `json.dumps(..., allow_nan=False)`.

    Values of parameters are SI (of an oscillator: in the units of its columns); errors of records are in the
    record's own unit, totals in that of the first record.
    """
    traces = fit.campaign.traces
    first = traces[0]
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
        "records": [_record(score, trace) for score, trace in zip(fit.scores, traces, strict=True)],
    }


def _parameter(estimate: Estimate, fit: Fit) -> dict[str, Any]:
    entry = {
        "name": estimate.name,
        "value": _number(estimate.value),
        "standard_error": None if estimate.standard_error is None else _number(estimate.standard_error),
        "unit": display_unit(estimate.unit, fit.model.device, plain=True),
        "flags": list(estimate.flags),
    }
    if entry["standard_error"] is None:
        entry["reason"] = flag_words(estimate.flags) or "its covariance is singular"
    return entry


def _score(score: Score | RecordScore, record: Trace) -> dict[str, Any]:
    channel = record.response_channel
    return {
        "n": int(score.n),
        "rmse": _number(score.rmse / channel.factor),
        "unit": channel.unit.replace("µ", "u").replace("μ", "u"),
        "noise_rmse": _number(score.noise_rmse / channel.factor),
        "error_over_noise": _number(score.error_over_noise),
        "error_over_signal": _number(score.error_over_signal),
    }


def _record(score: RecordScore, record: Trace) -> dict[str, Any]:
    return {"file": score.name, "holdout": bool(score.holdout), **_score(score, record)}


def _number(value: float) -> float | None:
    return float(value) if math.isfinite(value) else None
