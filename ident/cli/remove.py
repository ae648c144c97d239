"""`ident remove`: one effect less."""

from __future__ import annotations

import click

from .options import figures_option, force_option, json_option, run_argument, trust_option


@click.command("remove", short_help="Refit a run with one effect less.")
@run_argument
@click.argument("effect", metavar="EFFECT")
@click.option("-o", "--output", metavar="RUN2", help="Run folder to write; RUN-EFFECT if not given.")
@force_option
@json_option
@figures_option
@trust_option
def command(run: str, effect: str, output: str | None, force: bool, as_json: bool) -> None:
    """Take EFFECT out of the model of RUN, refit from its values, and print the errors before and after.

    \b
    Example:
      ident remove runs/b coulomb-friction -o runs/c
    """
    from .changed import change

    change(run, effect, output, adding=False, force=force, as_json=as_json)
