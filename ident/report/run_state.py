"""The part of a run that rebuilds it: values with all digits, settings by name, the files it came from."""

from __future__ import annotations

import math
import platform
from collections.abc import Sequence
from dataclasses import asdict, replace
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any

import numpy as np

from ..campaign import Campaign, NoiseFloor
from ..campaign.apart import TOLD, read_apart, signal_of
from ..campaign.noise.hum import HUMS, SURROUNDINGS
from ..campaign.quality.suspect import Suspect, set_aside
from ..campaign.record import Sweep, Trace
from ..effects.registry import Registry, built_in, find, registry
from ..errors import UserError
from ..fit import Fit
from ..fit.rebuild import fit_at
from ..fit.result import Start
from ..model import Model, linear_part, told_of
from .run_origin import campaign_of

_PACKAGES = ("ident", "jax", "numpy", "optimistix", "pandas", "scipy")


def versions() -> dict[str, str]:
    """Python and the packages on which the numbers depend."""
    found = {"python": platform.python_version()}
    for name in _PACKAGES:
        try:
            found[name] = version(name)
        except PackageNotFoundError:  # run from a source tree that was not installed
            found[name] = "unknown"
    return found


def state(fit: Fit) -> dict[str, Any]:
    """Names and numbers from which the same Fit is made again."""
    model = fit.model
    return {
        "values": {p.name: float(v) for p, v in zip(model.parameters, fit.values, strict=True)},
        "settings": {effect.name: dict(effect.settings) for effect in model.effects},
        "start": dict(model.start),
        "held": sorted(model.held),
        "freed": sorted(model.freed),
        "undetermined": sorted(model.undetermined),
        "form": model.form,
        "weighed": model.weighed,
        "starts": [list(start) for start in fit.starts],
        "substeps": [span.substeps for span in fit.solved.data.tape.spans],
        # Plays never forget how a record began: sought anew, their initial states may end elsewhere.
        "initial_states": fit.solved.found.starts.tolist(),
        # An estimate, and with sigma = "fitted" a result: another version might find another.
        "noise": [asdict(record.noise) for record in fit.campaign.records],
        # What of a trace was estimated: how it differs from the others, and where a drive that is held changes.
        "traces": [[trace.own, trace.edge, *_zero_told(trace)] for trace in fit.campaign.traces],
        "left_out": [asdict(suspect) for _, suspect in fit.campaign.left_out],
        "stronger": [None if s.stronger is None else s.stronger.tolist() for s in fit.campaign.sweeps],
    }


def _zero_told(trace: Trace) -> list[bool]:
    """Of a zero of a record's own whether it is fitted with every model."""
    return [trace.floats] if trace.own is not None and TOLD[trace.own[0]].of_zero else []


def restore(document: dict[str, Any], folder: Path) -> tuple[Model, Campaign, np.ndarray]:
    """Model, campaign and parameter values (m,) SI of a `run.json`, from the campaign's files and the names in it."""
    campaign = restore_campaign(document, folder)
    model, values = _model(document, campaign, folder)
    return model, campaign, values


def restore_campaign(document: dict[str, Any], folder: Path) -> Campaign:
    """The campaign of a `run.json`, with the effect files and noise floors of then; what it depends on is the same."""
    kept, campaign = document["state"], campaign_of(document, folder)
    campaign = set_aside(campaign, [Suspect(**one) for one in kept.get("left_out", ())])
    floors = [_floor(told) for told in kept["noise"]]
    records = [replace(record, noise=noise) for record, noise in zip(campaign.records, floors, strict=True)]
    estimates, stronger = iter(kept.get("traces", ())), iter(kept.get("stronger", ()))
    for i, record in enumerate(records):
        if isinstance(record, Sweep) and (drives := next(stronger, None)) is not None:
            records[i] = replace(record, stronger=np.array(drives))
        if isinstance(record, Trace) and (told := next(estimates, None)) is not None:
            records[i] = as_it_was(record, told)
    return replace(campaign, records=tuple(records))


def _floor(told: dict[str, Any]) -> NoiseFloor:
    """A noise floor of a run; of its lines those of older versions tell in their words only."""
    lines = told.get("lines", [line for line in (HUMS, SURROUNDINGS) if line in told["method"]])
    heard = tuple((nominal, hz) for nominal, hz in told.get("heard", ()))
    return NoiseFloor(**{**told, "ar": tuple(told["ar"]), "lines": tuple(lines), "heard": heard})


def as_it_was(record: Trace, told: Sequence[Any]) -> Trace:
    """A trace with the noise floor of a run, read as the run had read it: `told` of it in its state."""
    own, edge, *floats = told
    in_signals = own is not None and TOLD[own[0]].of_zero and not floats  # as an older version counted a zero
    unit = signal_of(record) if in_signals else 1.0
    read_so = record if own is None else read_apart(record, own[0], [unit * size for size in own[1]])
    return replace(read_so, noise=record.noise, edge=edge, floats=any(floats))  # both are kept as they were after that


def _model(document: dict[str, Any], campaign: Campaign, folder: Path) -> tuple[Model, np.ndarray]:
    kept = document["state"]
    names = document["effects"]
    # Files with other effects may have come since, which nobody has trusted yet.
    known = built_in() if {*names} <= {*built_in()} else registry(campaign.effect_files)
    effects = tuple(find(name, known)(campaign.device, kept["settings"].get(name)) for name in names)
    start, held, freed = _told(kept, campaign, known, {*names, linear_part(campaign.device).prefix})
    model = Model(campaign.device, effects, start, held, freed, frozenset(kept.get("undetermined", ())),
                  kept.get("form", "oscillator"), kept.get("weighed", False))  # fmt: skip
    missing = [p.name for p in model.parameters if p.name not in kept["values"] and (p.fitted or p.value)]
    if missing:
        what = f"the run knows nothing of {missing[0]}, which its effect has today"
        raise UserError(what, where=str(folder / "run.json"), do="fit the campaign again")
    values = [kept["values"].get(p.name, p.value) for p in model.parameters]  # of its usual law, what refines it later
    return model, np.array([np.nan if v is None else v for v in values])


def _told(
    kept: dict[str, Any], campaign: Campaign, known: Registry, own: set[str]
) -> tuple[tuple[tuple[str, float], ...], frozenset[str], frozenset[str]]:
    """Starting values, held and freed parameters: of the run's own effects those of then, of others what the campaign
    says today, for they wait until they are added."""
    of_run = lambda full: full.rpartition(".")[0] in own
    start, held, freed = told_of(campaign, known)
    return (
        (
            *((name, x) for name, x in kept["start"].items() if of_run(name)),
            *(one for one in start if not of_run(one[0])),
        ),
        frozenset([*filter(of_run, kept["held"]), *(name for name in held if not of_run(name))]),
        frozenset([*filter(of_run, kept["freed"]), *(name for name in freed if not of_run(name))]),
    )


def rebuild(document: dict[str, Any], folder: Path) -> Fit:
    """The Fit of a `run.json`, without fitting again."""
    return rebuild_in(restore_campaign(document, folder), document, folder)


def rebuild_in(campaign: Campaign, document: dict[str, Any], folder: Path) -> Fit:
    """The Fit of a `run.json` in a campaign that was restored already."""
    model, values = _model(document, campaign, folder)
    kept = document["state"]
    starts = [Start(_number(a), _number(b), steps, ok) for a, b, steps, ok in kept["starts"]]
    begun = kept.get("initial_states")
    return fit_at(
        model, campaign, values, sigma=document["sigma"], starts=starts, converged=document["converged"],
        substeps=kept.get("substeps"), begun=None if begun is None else np.array(begun, float),
    )  # fmt: skip


def _number(told: float | None) -> float:
    """JSON has no infinity: where a start could not be solved, it says null."""
    return math.inf if told is None else float(told)
