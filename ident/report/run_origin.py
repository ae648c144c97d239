"""Where a run came from, and whether that is still the same: the data, what the campaign says of them, and its effects.

What the run does not depend on may change: comments and the order of things, the effects to start with, settings and
files of effects that it does not have.
"""

from __future__ import annotations

import inspect
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from types import FunctionType
from typing import Any

from ..campaign import Campaign, read_campaign
from ..campaign.said import fingerprint
from ..campaign.tables.opening import exists, read_bytes, seen_from
from ..campaign.trust import checksum
from ..effects.effect import AbstractEffect
from ..errors import UserError
from ..model import Model, linear_part

_AGAIN = "fit the campaign again"


def origin(campaign: Campaign, model: Model, folder: Path) -> dict[str, Any]:
    """Where the data came from: files relative to the run folder, the checksums of all that was read, and what the
    campaign file says that decides the result."""
    sums = {seen_from(folder, path): checksum(read_bytes(path, str(path))) for path in campaign.effect_files}
    own = {path.resolve() for path in map(_file_of, map(type, model.effects)) if path is not None}
    told: dict[str, Any] = {
        "title": campaign.title,
        "files": [seen_from(folder, path) for path in campaign.files],
        "effect_files": [seen_from(folder, path) for path in campaign.effect_files],
        "checksums": dict(campaign.checksums),
        "effect_checksums": sums,
        "effects_from": [seen_from(folder, path) for path in campaign.effect_files if path.resolve() in own],
    }
    if campaign.said is not None:
        said = campaign.said
        told["said"] = {
            "records": [list(one) for one in said.records],
            "device": said.device,
            "model": said.model,
            "data": list(said.data),
            "settings": _settings(campaign, [*model.names, model.linear.prefix]),
        }
    return told


def _file_of(effect: type[AbstractEffect]) -> Path | None:
    """The file in which an effect is written, as far as one of its methods tells."""
    functions = [f for c in effect.__mro__ if c is not AbstractEffect for f in vars(c).values()]
    method = next((f for f in functions if isinstance(f, FunctionType)), None)
    return None if method is None else Path(inspect.unwrap(method).__code__.co_filename)


def _settings(campaign: Campaign, owners: Sequence[str]) -> dict[str, str]:
    """A fingerprint of what the campaign sets of each of these."""
    return {owner: fingerprint(campaign.settings[owner]) for owner in owners if campaign.settings.get(owner)}


def campaign_of(document: Mapping[str, Any], folder: Path) -> Campaign:
    """The campaign of a `run.json`, with its records in their order of then and its effect files.

    **Raises:** UserError, naming the file, if anything has changed on which the run depends.
    """
    told = document["campaign"]
    if not told["files"]:
        what = "this run was fitted to data in memory, which no file holds"
        raise UserError(what, where=str(folder), do="fit them again, from files if the run is to be read back")
    campaign = read_campaign([folder / file for file in told["files"]])
    said = told.get("said")
    if (
        said is None or campaign.said is None
    ):  # of data files alone, or written by a version that compared the campaign file byte by byte
        _compare(told["checksums"], campaign.checksums)
    else:
        _compare(_only(said["data"], told["checksums"]), _only(campaign.said.data, campaign.checksums))
        campaign = _as_said(said, campaign, document["effects"])
    return replace(campaign, effect_files=(*campaign.effect_files, *_effect_files(told, campaign, folder)))


def _only(names: Sequence[str], sums: Mapping[str, str]) -> dict[str, str]:
    return {name: sums[name] for name in names}


def _compare(then: Mapping[str, str], now: Mapping[str, str]) -> None:
    """**Raises:** UserError if a file has changed, is no longer there, or was added."""
    for file, told_sum in then.items():
        if now.get(file) != told_sum:
            word = "has changed since this run" if file in now else "is no longer part of the campaign"
            raise UserError(f"{word}, so its result no longer stands", where=file, do=_AGAIN)
    for file in now:
        if file not in then:
            raise UserError("was added to the campaign since this run", where=file, do=_AGAIN)


def _as_said(said: Mapping[str, Any], campaign: Campaign, effects: Sequence[str]) -> Campaign:
    """The campaign with its records in the order of the run. **Raises:** UserError if its file says something else."""
    assert campaign.said is not None and campaign.path is not None
    now, then = campaign.said, tuple((name, sum_) for name, sum_ in said["records"])
    other = next(iter(Counter(then) - Counter(now.records)), None) or next(
        iter(Counter(now.records) - Counter(then)), None
    )
    settings = _settings(campaign, [*effects, linear_part(campaign.device).prefix])
    owners = [name for name in {**settings, **said["settings"]} if settings.get(name) != said["settings"].get(name)]
    changed = [f"what it says of {other[0]}"] if other else []
    changed += ["its device"] if said["device"] != now.device else []
    changed += ["what its [model] says of the linear part"] if said["model"] != now.model else []
    changed += [f"its [effect.{name}]" for name in owners]
    if changed:
        what = f"{changed[0]} has changed since this run, so its result no longer stands"
        raise UserError(what, where=campaign.path.name, do=_AGAIN)
    places = sorted(range(len(then)), key=lambda k: now.records[k])  # equal ones stay in order, here and there
    order = dict(zip(sorted(range(len(then)), key=lambda k: then[k]), places, strict=True))
    records = tuple(campaign.records[order[k]] for k in range(len(then)))
    return replace(campaign, records=records, said=replace(now, records=then))


def _effect_files(told: Mapping[str, Any], campaign: Campaign, folder: Path) -> tuple[Path, ...]:
    """Effect files of the run that its campaign does not name. **Raises:** UserError if one it needs has changed."""
    needed = told.get("effects_from", list(told.get("effect_checksums", {})))
    for file in needed:
        if checksum(read_bytes(folder / file, str(folder / file))) != told["effect_checksums"][file]:
            what, do = "has changed since this run, so it is not run", f"restore it, or {_AGAIN}"
            raise UserError(what, where=str(folder / file), do=do)
    named = {path.resolve() for path in campaign.effect_files}
    there = [folder / file for file in told.get("effect_files", ()) if file in needed or exists(folder / file)]
    return tuple(path.resolve() for path in there if path.resolve() not in named)
