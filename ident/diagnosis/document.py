"""A discovery as the JSON that other programs read: diagnosis.json and lineage.json."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from ..fit import Fit
from ..fit.judge import Score
from .answer import Diagnosis
from .search.steps import Discovery, Step, Walked

FORMAT = 1
_LISTED = 12  # candidates of the ranking worth a reader's time


def diagnosis_dict(diagnosis: Diagnosis) -> dict[str, Any]:
    """`diagnosis.json`: verdict, start, steps, final, ranking, and what the library lacks."""
    found = diagnosis.discovery
    document = {
        "format": FORMAT,
        "finished": True,
        "verdict": found.verdict,
        "start": _state(found.start),
        "steps": [_step(step) for step in found.steps],
        "final": _state(found.final),
        "ranking": [_ranked(found, candidate) for candidate in found.ranking[:_LISTED]],
        "next_experiments": [
            {"record": e.record, "separates": list(e.separates), "expected_delta_chi2": e.expected_delta_chi2}
            for e in diagnosis.next_experiments
        ],
        "records": [suspect.as_json() for suspect in diagnosis.suspects],
        "summary": diagnosis.summary,
    }
    if found.shorter:
        document["shorter"] = found.shorter  # one law that says more than the steps, with fewer numbers
    if diagnosis.unknown is not None:
        document["unknown"] = diagnosis.unknown.as_json()
    return document


def unfinished_dict(walked: Walked) -> dict[str, Any]:
    """`diagnosis.json` of a walk that has not ended: the steps so far. What it would have questioned is open."""
    return {
        "format": FORMAT,
        "finished": False,
        "verdict": "ambiguous",
        "start": _state(walked.start),
        "steps": [_step(step) for step in walked.steps],
        "final": _state(walked.final),
        "ranking": [],
        "next_experiments": [],
        "records": [],
        "summary": "The walk was stopped before its end: effects may be missing, and those named were not questioned.",
    }


def lineage_of(start: Fit, steps: Sequence[Step]) -> list[dict[str, Any]]:
    """One entry per step, for lineage.json and the staircase."""
    parents = ["the first fit", *(f"step {k}" for k in range(1, len(steps)))]
    before = [start, *(step.fit for step in steps)]
    return [
        lineage_entry(was, step.fit, parent, added=step.added, removed=_gone(was, step.fit))
        for was, step, parent in zip(before, steps, parents, strict=False)
    ]


def _gone(before: Fit, after: Fit) -> str | None:
    """What a step has made needless in the linear part: a constant, or a mode."""
    return next((name for name in before.model.names if name not in after.model.names), None)


def lineage_entry(
    before: Fit, after: Fit, parent: str, *, added: str | None = None, removed: str | None = None
) -> dict:
    """What lineage.json keeps of one step: what changed, the errors, and the parameters that moved with it."""
    moved = {
        e.name: {"before": e.value, "after": after.value(e.name), "unit": e.unit, "standard_error": e.standard_error}
        for e in before.estimates
        if e.fitted and e.name in {p.name for p in after.model.parameters}
    }
    return {
        "parent": parent,
        "added": added,
        "removed": removed,
        "effects": list(after.model.names),
        "before": _both_errors(before),
        "after": _both_errors(after),
        "parameters": moved,
    }


def _step(step: Step) -> dict[str, Any]:
    return {
        "added": step.added,
        "predicted_gain": step.predicted_gain,
        "confirmed_gain": step.confirmed_gain,
        **_errors(step.fit),
        "tie_set": list(step.tie_set),
        "role": step.role,
        "rivals": [
            {"effect": r.name, "predicted_gain": r.predicted_gain, "confirmed_gain": r.confirmed_gain}
            for r in step.rivals
        ],
    }


def _ranked(found: Discovery, candidate: Any) -> dict[str, Any]:
    amplitude = next(iter(candidate.errors), None)
    return {
        "effect": candidate.name,
        "predicted_gain": candidate.predicted_gain,
        "confirmed_gain": found.confirmed.get(candidate.name),
        "size": None if amplitude is None else candidate.values[amplitude],
        "size_error": None if amplitude is None else candidate.errors[amplitude],
        "parameter": amplitude,
        "p_value": candidate.p_value,
    }


def _state(fitted: Fit) -> dict[str, Any]:
    return {"effects": list(fitted.model.names), **_errors(fitted)}


def _errors(fitted: Fit) -> dict[str, Any]:
    heldout = fitted.holdout
    return {
        "error_over_noise": fitted.fitted.error_over_noise,
        "holdout_error_over_noise": None if heldout is None else heldout.error_over_noise,
        "error_over_signal": fitted.fitted.error_over_signal,
        "holdout_error_over_signal": None if heldout is None else heldout.error_over_signal,
    }


def _both_errors(fitted: Fit) -> dict[str, Any]:
    """Error over noise, over the signal, and rms error (SI), on fitted and on held-out records."""
    return {"fitted": _score(fitted.fitted), "holdout": _score(fitted.holdout)}


def _score(found: Score | None) -> dict[str, float] | None:
    names = ("rmse", "error_over_noise", "error_over_signal")
    return None if found is None else {name: getattr(found, name) for name in names}
