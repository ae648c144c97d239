"""A run on disk: names, numbers and versions from which the Fit is rebuilt. Code is never stored.

run.json       what was fitted, with which result, from which files, by which versions
report.html    the same for people; figures/ beside it
lineage.json   every ancestor of the run: what was added or removed, errors before and after
parts.json     what other commands added to the page
"""

from __future__ import annotations

import json
import math
import os
import re
from collections.abc import Mapping, Sequence
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np

from ..campaign import Campaign
from ..campaign.tables.opening import MOST_DATA, exists, read_bytes
from ..errors import UserError
from ..fit import Fit
from ..model import Model
from ..pulse import Report
from ..threads import one_thread
from .figures.picture import draw, drawn_as_before
from .html import Section, write_report
from .new_folder import OWN, link_or_copy, new_folder, write_whole
from .parts import FILE as PARTS
from .parts import parts_dict, parts_of
from .run_json import run_dict
from .run_origin import origin
from .run_state import rebuild, restore, state, versions
from .story import staircase_section

FORMAT = 1
_LONGEST_NAME = 255  # bytes, on every file system in use
PathLike = str | os.PathLike[str]


@one_thread
def write_run(
    fit: Fit,
    folder: PathLike,
    *,
    force: bool = False,
    command: str = "",
    options: Mapping[str, Any] | None = None,
    lineage: Sequence[Mapping[str, Any]] = (),
    documents: Mapping[str, Mapping[str, Any]] | None = None,
    report: Report = lambda _: None,
    page: bool = True,
) -> Path:
    """Write the run folder of a fit; it appears complete or not at all.

    **Arguments:** `force`: replace a folder that exists; `command`: the command line, for the record; `options`: how
    the fit was made (seed, starts, …); `lineage`: the run's ancestors, oldest first; `documents`: further JSON files
    by name ("diagnosis.json", and "parts.json" for what the report shows beside the fit); `page`: whether the report is
    drawn.

    **Raises:** UserError if the folder exists and `force` is not set.
    """
    target = Path(folder)
    check_target(target, force)
    document = {
        **run_dict(fit),
        "campaign": origin(fit.campaign, fit.model, target),
        "versions": versions(),
        "command": command,
        "options": dict(options or {}),
        "state": state(fit),
    }
    with new_folder(target) as temporary:
        write_json(temporary / "run.json", document)
        write_json(temporary / "lineage.json", list(lineage))
        for name, content in (documents or {}).items():
            write_json(temporary / name, content)
        if not page:
            return target
        report("writing the report")
        _draw_page(fit, temporary)
        check_target(target, force)
    return target


def renew_report(fit: Fit, folder: PathLike, **parts: Sequence[Section]) -> Path:
    """Write report.html and figures/ of a run anew, with further `parts`; whoever looks finds the old or the new."""
    target = Path(folder)
    with new_folder(target) as temporary:
        for entry in target.iterdir():
            if entry.name in OWN - {"report.html", "figures"}:
                link_or_copy(entry, temporary / entry.name)
        if parts:
            write_json(temporary / PARTS, parts_dict({**_parts(temporary), **parts}))
        with drawn_as_before(target / "figures"):
            _draw_page(fit, temporary)
    return target / "report.html"


def _draw_page(fit: Fit, folder: Path) -> None:
    """The page and figures of a run from what its folder holds, and its fit."""
    lineage, parts = read_lineage(folder), _parts(folder)
    sections = [section for own in parts.values() for section in own]
    history = [staircase_section(lineage)] if lineage else []
    command = read_run(folder).get("command")
    extra = {"command": command} if command else {}
    write_report(fit, folder, {**extra, "sections": [*history, *sections]})
    for name, own in parts.items():
        for k, picture in enumerate([picture for section in own for picture in section.pictures], 1):
            picture.write(folder / "figures", name if k == 1 else f"{name}_{k}")
    if exists(folder / "compare.json"):  # `ident compare … -o RUN`
        from .compare_view import compare_figure  # not needed by a fit

        draw("", compare_figure(read_json(folder / "compare.json"))).write(folder, "compare")


def lacking_formats(folder: PathLike) -> tuple[str, ...]:
    """The parts of a run's page whose pictures do not have the formats that are asked for: those of a diagnosis, and
    all of earlier versions, are kept as PNG alone."""
    parts = _parts(Path(folder))
    return tuple(n for n, own in parts.items() if any(p.lacks for section in own for p in section.pictures))


def _parts(folder: Path) -> dict[str, list[Section]]:
    path = folder / PARTS
    return parts_of(read_json(path)) if exists(path) else {}


def read_run(folder: PathLike) -> dict[str, Any]:
    """What `run.json` of a run folder holds. **Raises:** UserError if there is none, or none that can be read."""
    path = Path(folder) / "run.json"
    if not exists(path):
        do = "name the folder that `ident fit … -o FOLDER` wrote"
        raise UserError("this is no run folder: it has no run.json", where=str(folder), do=do)
    document = read_json(path)
    if not isinstance(document, dict) or document.get("format") != FORMAT or "state" not in document:
        what = f"run.json is not of the format {FORMAT} that this version reads"
        raise UserError(what, where=str(path), do="fit the campaign again")
    return document


@one_thread
def load_run(folder: PathLike) -> Fit:
    """The Fit that a run folder holds, rebuilt from the campaign's files without fitting again.

    **Raises:** UserError, naming the file, if the data or the campaign have changed since.
    """
    return rebuild(read_run(folder), Path(folder))


def load_state(folder: PathLike) -> tuple[Model, Campaign, np.ndarray]:
    """Model, campaign and parameter values (m,) SI of a run folder: enough to simulate, quicker than the whole Fit."""
    return restore(read_run(folder), Path(folder))


def read_lineage(folder: PathLike) -> list[dict[str, Any]]:
    """The ancestors of a run, oldest first."""
    path = Path(folder) / "lineage.json"
    return read_json(path) if exists(path) else []


def write_json(path: Path, document: Any) -> None:
    """Write a JSON file whole or not at all."""
    write_whole(path, json_text(document))


def json_text(document: Any) -> str:
    """A document as JSON; a number that is not finite becomes null."""
    text = json.dumps(_plain(document), indent=1, ensure_ascii=False, allow_nan=False) + "\n"
    return re.sub(r"[\x7f-\x9f\u200b-\u200f\u2028-\u202e\u2066-\u2069\ud800-\udfff]", _escaped, text)


def _escaped(found: re.Match[str]) -> str:
    """What would steer a terminal, or is no text at all, in the writing of JSON."""
    return f"\\u{ord(found[0]):04x}"


def check_target(target: Path, force: bool) -> None:
    """Whether a run may be written there; asked before a fit, so that no work is lost."""
    if len(os.fsencode(target.name)) > _LONGEST_NAME:
        raise UserError("this name is too long", where=f"{target.name[:40]}…", do="choose a shorter one")
    if not target.name or not _can_write(target.parent):
        raise UserError("nothing can be written there", where=str(target), do="choose another folder")
    if target.exists() and not (target.is_dir() and not any(target.iterdir())):
        if not force:
            raise UserError(
                "this exists already", where=str(target), do="choose another name, or --force to replace it"
            )
        if not target.is_dir() or not (target / "run.json").is_file():
            what = "this is not a run folder, so it is not replaced even with --force"
            raise UserError(what, where=str(target), do="choose another name")


def _can_write(folder: Path) -> bool:
    """Whether a folder, or the nearest one above it that is there, takes new entries."""
    while not exists(folder):
        folder = folder.parent
    if not folder.is_dir() or not os.access(folder, os.W_OK | os.X_OK):
        return False
    try:
        with TemporaryDirectory(prefix=".ident-", dir=folder):  # rights do not tell it of /proc, or of what is full
            return True
    except OSError:
        return False


def read_json(path: Path) -> Any:
    """What a JSON file of a run folder holds. **Raises:** UserError if it cannot be read."""
    try:
        return json.loads(read_bytes(path, str(path), MOST_DATA).decode("utf-8"))
    except (OSError, ValueError, RecursionError) as error:
        raise UserError(f"cannot be read: {error}", where=str(path), do="fit the campaign again") from None


def _plain(value: Any) -> Any:
    if isinstance(value, Mapping):
        return {str(key): _plain(one) for key, one in value.items()}
    if isinstance(value, np.ndarray):
        return _plain(value.tolist())
    if isinstance(value, (list, tuple, set, frozenset)):
        return [_plain(one) for one in value]
    if isinstance(value, np.generic):
        return _plain(value.item())
    return None if isinstance(value, float) and not math.isfinite(value) else value
