"""`--resume`: whether the run that is there can go on."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from ..errors import UserError

if TYPE_CHECKING:
    from ..campaign import Campaign


def check_resumed(folder: Path, campaign: Campaign, effects: Sequence[str] | None) -> None:
    """**Raises:** UserError if the folder holds no run of this campaign, or if the run is asked for other effects."""
    from ..campaign.tables.opening import exists
    from ..report.run_folder import read_run

    if not exists(folder / "run.json"):
        raise UserError("there is no run here that could go on", where=str(folder), do="leave --resume out")
    files = read_run(folder)["campaign"]["files"]
    if {(folder / file).resolve() for file in files} != {path.resolve() for path in campaign.files}:
        do = "name the campaign that it was made of, or its own folder with -o"
        raise UserError("this run is of another campaign", where=str(folder), do=do)
    if effects is not None:
        raise UserError("a run that goes on keeps its effects", where="--effects", do="leave --effects or --resume out")
