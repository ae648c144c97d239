"""walk.json: a walk that has not ended, with the numbers from which it goes on. Its end leaves none."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from ..campaign.tables.opening import exists
from ..diagnosis.search.rivals import Rival
from ..diagnosis.search.steps import Step, Walked
from ..errors import UserError
from ..fit import Fit
from ..pulse import Report
from .run_folder import read_json, read_run
from .run_state import rebuild_in, restore_campaign, state

FILE = "walk.json"
_FORMAT = 1
_OWN = ("added", "predicted_gain", "confirmed_gain", "tie_set", "role", "reasons", "partner")


def walk_dict(walked: Walked) -> dict[str, Any]:
    """`walk.json` of the walk so far."""
    return {
        "format": _FORMAT,
        "start": _kept(walked.start),
        "steps": [_step_dict(step) for step in walked.steps],
        "gains": dict(walked.gains),
    }


def read_walk(folder: Path, report: Report = lambda _: None) -> Walked:
    """The walk that a run folder holds; nothing is fitted again.

    **Raises:** UserError if it has ended or none was begun there, or if its files have changed.
    """
    run, path = read_run(folder), folder / FILE
    if not exists(path):
        raise UserError("there is no walk here that could go on", where=str(folder), do="leave --resume out")
    told = read_json(path)
    if not isinstance(told, dict) or told.get("format") != _FORMAT:
        what = f"{FILE} is not of the format {_FORMAT} that this version reads"
        raise UserError(what, where=str(path), do="leave --resume out, and begin again with --force")
    report("reading the walk")
    campaign = restore_campaign(run, folder)
    fit = lambda kept: rebuild_in(campaign, kept, folder)
    return Walked(fit(told["start"]), tuple(_step(one, fit(one["fit"])) for one in told["steps"]), told["gains"])


def _kept(fit: Fit) -> dict[str, Any]:
    return {"effects": list(fit.model.names), "sigma": fit.sigma, "converged": fit.converged, "state": state(fit)}


def _step_dict(step: Step) -> dict[str, Any]:
    own = {name: getattr(step, name) for name in _OWN}
    return own | {"rivals": [list(rival) for rival in step.rivals], "fit": _kept(step.fit)}


def _step(told: dict[str, Any], fit: Fit) -> Step:
    known: dict[str, Any] = {name: told[name] for name in _OWN}
    rivals = tuple(Rival(*rival) for rival in told.get("rivals", ()))  # earlier versions kept none
    known |= {"tie_set": tuple(told["tie_set"]), "reasons": tuple(told["reasons"]), "rivals": rivals}
    return Step(**known, fit=fit)
