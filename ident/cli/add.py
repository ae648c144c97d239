"""`ident add`: one effect more."""

from __future__ import annotations

import click

from .options import figures_option, force_option, json_option, run_argument, trust_option


@click.command("add", short_help="Refit a run with one effect more.")
@run_argument
@click.argument("effect", metavar="EFFECT")
@click.option("-o", "--output", metavar="RUN2", help="Run folder to write; RUN+EFFECT if not given.")
@force_option
@json_option
@figures_option
@trust_option
def command(run: str, effect: str, output: str | None, force: bool, as_json: bool) -> None:
    """Add EFFECT to the model of RUN, refit from its values, and print the errors before and after.

    EFFECT is a name of the library (`ident effects`) or of the campaign's own files, or a Python file with an effect.

    \b
    Example:
      ident add runs/a coulomb-friction -o runs/b
    """
    from .changed import change

    change(run, effect, output, adding=True, force=force, as_json=as_json)
