"""`ident report`: the HTML page of a run, made again."""

from __future__ import annotations

import click

from .options import run_argument, trust_option
from .output import progress, say


@click.command("report", short_help="Make the HTML report of a run again.")
@run_argument
@trust_option
def command(run: str) -> None:
    """Make report.html and the figures of RUN again, from its numbers and the campaign's files. Nothing is fitted.

    \b
    Example:
      ident report runs/first
    """
    from pathlib import Path

    from ident.report.run_folder import load_run, read_run, renew_report

    from .sections import drawn_sections

    told = read_run(run)
    progress("reading the campaign and compiling the model")
    fit = load_run(run)
    progress("writing the report")
    options = {"command": told["command"], "sections": drawn_sections(Path(run), fit)}
    say(str(renew_report(fit, run, options)))
