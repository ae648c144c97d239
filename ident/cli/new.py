"""`ident new`: a campaign from your files, or a starter campaign with an example effect file."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import click

from .options import columns_option, force_option
from .output import progress, say, say_json


@click.command("new", short_help="Write a campaign from your files, or one to start from.")
@click.argument("folder", metavar="FOLDER")
@click.argument("files", nargs=-1, metavar="[FILE…]")
@columns_option
@force_option
@click.option("--json", "as_json", is_flag=True, help="Print the files that were written as JSON.")
def command(folder: str, files: tuple[str, ...], columns: dict[str, str | int], force: bool, as_json: bool) -> None:
    """Write a campaign into FOLDER. With FILES: the campaign.toml that describes them, whatever instrument wrote them:
    columns found, settings guessed, one record held out, every doubt as a comment. The files stay where they are.

    Without FILES, a campaign to start from: campaign.toml with comments, two small records, and my_effect.py, an effect
    of your own that explains them.

    \b
    Example:
      ident new mine measured/*.csv
      ident new mine scope.csv --columns time=TIME,drive=CH1,response=CH2
      ident new mine
    """
    from ..campaign.tables.opening import exists
    from ..errors import UserError

    target = Path(folder)
    theirs = (target / "campaign.toml") if files and target.is_dir() else target
    if exists(theirs) and not (theirs.is_dir() and (force or not any(theirs.iterdir()))) and not (files and force):
        do = "choose another name" + (", or --force to write into it" if target.is_dir() else "")
        raise UserError("this exists already", where=str(theirs), do=do)
    try:
        if files:
            _from_files(target, files, columns, as_json)
        elif columns:
            raise UserError("--columns is for data files", do="name the files after the folder")
        else:
            _starter(target, as_json)
    except OSError as error:
        raise UserError(error.strerror or "cannot be written", where=folder, do="choose another folder") from None


def _from_files(target: Path, files: tuple[str, ...], columns: dict[str, str | int], as_json: bool) -> None:
    from ..campaign.propose import LEFT_OUT, propose
    from ..errors import visible
    from ..report.new_folder import write_whole

    progress(f"reading {len(files)} file{'s' if len(files) > 1 else ''}")
    text = propose([Path(file) for file in files], target, columns)
    target.mkdir(parents=True, exist_ok=True)
    path = target / "campaign.toml"
    write_whole(path, text)
    for line in text.splitlines():
        if line.startswith(LEFT_OUT):  # the comment stands below all records
            click.echo(visible(f"ident: left out: {line.removeprefix(LEFT_OUT)}"), err=True)
    if as_json:
        say_json(_written([path]))
        return
    say(text)
    say(f"{path} is written. Look at what is guessed and at the doubts, then:")
    say(f"      ident check {target}")
    say(f"      ident fit {target}")


def _starter(target: Path, as_json: bool) -> None:
    from .starter import write_starter

    progress("compiling the model and simulating two records")
    written = write_starter(target)
    if as_json:
        say_json(_written(written))
        return
    for file in written:
        say(str(file))
    say(f"\nNext: ident fit {target}")
    say(f"      ident effects gas-drag --file {target / 'my_effect.py'}   the example effect, as the tool sees it")


def _written(files: Sequence[Path]) -> dict[str, Any]:
    return {"format": 1, "files": [str(file) for file in files]}
