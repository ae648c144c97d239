"""`ident new`: a starter campaign with an example effect file."""

from __future__ import annotations

from pathlib import Path

import click

from .options import force_option
from .output import progress, say


@click.command("new", short_help="Write a starter campaign with an example effect.")
@click.argument("folder", metavar="FOLDER")
@force_option
def command(folder: str, force: bool) -> None:
    """Write a campaign to start from into FOLDER: campaign.toml with comments, two small records, and my_effect.py, an
    effect of your own that explains them. Replace the records by yours.

    \b
    Example:
      ident new mine
      ident fit mine
    """
    from ident.errors import UserError

    target = Path(folder)
    if target.exists() and not (target.is_dir() and (force or not any(target.iterdir()))):
        do = "choose another name" + (", or --force to write into it" if target.is_dir() else "")
        raise UserError("this exists already", where=folder, do=do)

    from .starter import write_starter

    progress("compiling the model and simulating two records")
    try:
        files = write_starter(target)
    except OSError as error:
        raise UserError(error.strerror or "cannot be written", where=folder, do="choose another folder") from None
    for file in files:
        say(str(file))
    say(f"\nNext: ident fit {folder}")
    say(f"      ident effects gas-drag --file {target / 'my_effect.py'}   the example effect, as the tool sees it")
