"""`ident report`: the HTML page of a run, made again."""

from __future__ import annotations

import click

from .options import figures_option, json_option, run_argument, trust_option
from .output import progress, say, say_json


@click.command("report", short_help="Make the HTML report of a run again.")
@run_argument
@json_option
@figures_option
@trust_option
def command(run: str, as_json: bool) -> None:
    """Make report.html and the figures of RUN again, from its numbers and the campaign's files. Nothing is fitted.

    \b
    Example:
      ident report runs/first
    """
    from ..report.run_folder import lacking_formats, load_run, read_run, renew_report

    read_run(run)  # a wrong folder is answered before anything is compiled
    progress("reading the campaign and compiling the model")
    fit = load_run(run)
    progress("writing the report")
    page = renew_report(fit, run)
    if lacking := lacking_formats(run):
        what = f"the figures of {' and '.join(lacking)} are kept as PNG alone"
        progress(f"{what}: the command that drew them draws them in other formats with --figures")
    if as_json:
        say_json(read_run(run))
        return
    say(str(page))
