"""Arguments and options that several commands share, so that they look alike everywhere."""

from __future__ import annotations

import sys
from collections.abc import Callable
from typing import Any

import click

Decorator = Callable[[Callable[..., Any]], Callable[..., Any]]

campaign_argument: Decorator = click.argument("campaign", nargs=-1, required=True, metavar="CAMPAIGN…")
run_argument: Decorator = click.argument("run", metavar="RUN")
force_option: Decorator = click.option("--force", is_flag=True, help="Overwrite what is there.")
json_option: Decorator = click.option(
    "--json", "as_json", is_flag=True, help="Print what the JSON file of the run folder holds, and nothing else."
)


def _trust(_: click.Context, __: click.Parameter, asked: bool) -> None:
    if asked or "ident.campaign.trust" in sys.modules:
        from ..campaign.trust import trust_what_runs

        trust_what_runs(asked)


trust_option: Decorator = click.option(
    "--trust",
    is_flag=True,
    expose_value=False,
    callback=_trust,
    help="Run effect files that have not run here before; remembered until they change.",
)


minutes_option: Decorator = click.option(
    "--minutes", type=click.FloatRange(min=0, min_open=True), metavar="M",
    help="Stop after so many minutes and keep what was found.",
)  # fmt: skip
resume_option: Decorator = click.option("--resume", is_flag=True, help="Go on with what the run folder holds.")


def _figures(context: click.Context, _: click.Parameter, value: str | None) -> None:
    if value is not None:
        from ..report.figures.picture import FORMATS, drawn_as

        asked = tuple(dict.fromkeys(part.strip().lower() for part in value.split(",")))
        if unknown := [one for one in asked if one not in FORMATS]:
            raise click.BadParameter(f"{unknown[0]!r} is none of {', '.join(FORMATS)}")
        context.with_resource(drawn_as(asked))


figures_option: Decorator = click.option(
    "--figures",
    expose_value=False,
    callback=_figures,
    metavar="svg,pdf,png",
    help="Formats of the files in figures/; png if not given.",
)


def columns(_: click.Context, __: click.Parameter, value: str | None) -> dict[str, str | int]:
    """ "time=t,drive=CH1,response=3" as {"time": "t", "drive": "CH1", "response": 3}."""
    found: dict[str, str | int] = {}
    for part in (value or "").split(","):
        role, equals, column = (word.strip() for word in part.partition("="))
        if not part.strip():
            continue
        if role not in _ROLES or not equals or not column:
            raise click.BadParameter(f"{part.strip()!r} is not ROLE=COLUMN, where ROLE is one of {', '.join(_ROLES)}")
        found[role] = int(column) if column.isascii() and column.isdigit() else column
    return found


_ROLES = ("time", "drive", "response", "frequency", "level", "amplitude", "phase", "direction")
columns_option: Decorator = click.option(
    "--columns",
    callback=columns,
    metavar="ROLE=COLUMN,…",
    help="Which column is which, by name or number: time=t,drive=CH1,response=CH2.",
)


def names(_: click.Context, __: click.Parameter, value: str | None) -> tuple[str, ...] | None:
    """ "a,b" as ("a", "b"); an empty text as (), which is the plain linear model."""
    return None if value is None else tuple(name for name in (part.strip() for part in value.split(",")) if name)


effects_option: Decorator = click.option(
    "--effects",
    callback=names,
    metavar="A,B",
    help='Effects of the model, instead of those of the campaign; "" is the plain linear one.',
)
