"""A run on disk: names, numbers and versions from which the Fit is rebuilt. Code is never stored.

run.json       what was fitted, with which result, from which files, by which versions
report.html    the same for people; figures/ beside it
lineage.json   every ancestor of the run: what was added or removed, errors before and after
"""

from __future__ import annotations

import json
import math
import os
import shutil
import tempfile
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np

from ..campaign import Campaign
from ..errors import UserError
from ..fit import Fit
from ..model import Model
from .html import write_report
from .run_json import run_dict
from .run_state import origin, rebuild, restore, state, versions

FORMAT = 1
PathLike = str | os.PathLike[str]


def write_run(
    fit: Fit,
    folder: PathLike,
    *,
    force: bool = False,
    command: str = "",
    options: Mapping[str, Any] | None = None,
    lineage: Sequence[Mapping[str, Any]] = (),
    documents: Mapping[str, Mapping[str, Any]] | None = None,
    extra: Mapping[str, Any] | None = None,
    report: Callable[[str], None] = lambda _: None,
    page: bool = True,
) -> Path:
    """Write the run folder of a fit; it appears complete or not at all.

    **Arguments:** `force`: replace a folder that exists; `command`: the command line, for the record; `options`: how
    the fit was made (seed, starts, …); `lineage`: the run's ancestors, oldest first; `documents`: further JSON files
    by name ("diagnosis.json"); `extra`: what the report shows beside the fit; `page`: whether the report is drawn.

    **Raises:** UserError if the folder exists and `force` is not set.
    """
    target = Path(folder)
    check_target(target, force)
    document = {
        **run_dict(fit),
        "campaign": origin(fit.campaign, target),
        "versions": versions(),
        "command": command,
        "options": dict(options or {}),
        "state": state(fit),
    }
    with _new_folder(target, force) as temporary:
        write_json(temporary / "run.json", document)
        write_json(temporary / "lineage.json", list(lineage))
        for name, content in (documents or {}).items():
            write_json(temporary / name, content)
        if not page:
            return target
        report("writing the report")
        write_report(fit, temporary, {"command": command, **(extra or {})} if command else extra)
    return target


def read_run(folder: PathLike) -> dict[str, Any]:
    """What `run.json` of a run folder holds. **Raises:** UserError if there is none, or none that can be read."""
    path = Path(folder) / "run.json"
    if not path.is_file():
        do = "name the folder that `ident fit … -o FOLDER` wrote"
        raise UserError("this is no run folder: it has no run.json", where=str(folder), do=do)
    document = _read_json(path)
    if not isinstance(document, dict) or document.get("format") != FORMAT or "state" not in document:
        what = f"run.json is not of the format {FORMAT} that this version reads"
        raise UserError(what, where=str(path), do="fit the campaign again")
    return document


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
    return _read_json(path) if path.is_file() else []


def write_json(path: Path, document: Any) -> None:
    """Write a JSON file whole or not at all."""
    beside = path.with_name(path.name + ".part")
    beside.write_text(json_text(document), encoding="utf-8")
    beside.replace(path)


def json_text(document: Any) -> str:
    """A document as JSON; a number that is not finite becomes null."""
    return json.dumps(_plain(document), indent=1, ensure_ascii=False, allow_nan=False) + "\n"


def check_target(target: Path, force: bool) -> None:
    """Whether a run may be written there; asked before a fit, so that no work is lost."""
    if target.exists() and not (target.is_dir() and not any(target.iterdir())):
        if not force:
            raise UserError(
                "this exists already", where=str(target), do="choose another name, or --force to replace it"
            )
        if not target.is_dir() or not (target / "run.json").is_file():
            what = "this is not a run folder, so it is not replaced even with --force"
            raise UserError(what, where=str(target), do="choose another name")


def _read_json(path: Path) -> Any:
    try:
        return json.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError) as error:
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


@contextmanager
def _new_folder(target: Path, force: bool) -> Iterator[Path]:
    """A folder that takes its final name only if all goes well; what was there goes last."""
    try:
        target.parent.mkdir(parents=True, exist_ok=True)
        temporary = Path(tempfile.mkdtemp(prefix=f".{target.name}-", dir=target.parent))
    except OSError as error:
        raise UserError(error.strerror or "cannot be written", where=str(target), do="choose another folder") from None
    try:
        temporary.chmod(0o777 & ~_mask())
        yield temporary
        check_target(target, force)
        old = temporary.with_name(temporary.name + "-old")
        if target.exists():
            target.rename(old)
        temporary.rename(target)
        shutil.rmtree(old, ignore_errors=True)
    finally:
        shutil.rmtree(temporary, ignore_errors=True)


def _mask() -> int:
    mask = os.umask(0)
    os.umask(mask)
    return mask
