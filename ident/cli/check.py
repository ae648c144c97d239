"""`ident check`: the data alone, before any model."""

from __future__ import annotations

import click

from .options import campaign_argument, columns_option, json_option
from .output import say, say_json, say_sheet


@click.command("check", short_help="Read and judge the data of a campaign alone.")
@campaign_argument
@columns_option
@json_option
def command(campaign: tuple[str, ...], columns: dict[str, str | int], as_json: bool) -> None:
    """Read CAMPAIGN and judge its data: units, sampling, clipping, drift, noise floor, purity of the drive, and what
    these records can and cannot tell apart. Nothing is fitted and nothing is written.

    CAMPAIGN is a TOML file, a folder that holds campaign.toml, or data files.

    \b
    Example:
      ident check data/platform_317hz
    """
    from ..report.check import check

    found = check(list(campaign), columns)
    if as_json:
        say_json(found.as_json())
        return
    for part in found.parts:
        say(part) if isinstance(part, str) else say_sheet(part)
