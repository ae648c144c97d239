"""Results go to stdout, as wide as the window; progress goes to stderr."""

from __future__ import annotations

import shutil
import sys
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import click

from ..errors import visible

if TYPE_CHECKING:
    from pathlib import Path

    from ..fit import Fit
    from ..report.words.sheet import Sheet


def progress(text: str) -> None:
    """One line of progress."""
    click.echo(visible(f"{text}…"), err=True)


def say(text: str = "") -> None:
    """One line or block of results."""
    click.echo(visible(text))


def say_json(document: Mapping[str, Any]) -> None:
    """A JSON document as the result of a command."""
    from ..report.run_folder import json_text

    click.echo(json_text(document), nl=False)


def width() -> int:
    """Columns for tables: those of the window, within reason."""
    return max(60, min(shutil.get_terminal_size((100, 24)).columns, 140))


def say_sheet(sheet: Sheet) -> None:
    """A table."""
    from ..report.words.sheet import rich_sheet, sheet_text

    if sys.stdout.isatty():
        from rich.console import Console

        Console().print(rich_sheet(sheet))
    else:
        click.echo(visible(sheet_text(sheet, width())))


def say_folder(folder: Path) -> None:
    """Where a run was written."""
    say(f"run folder: {folder}")
    say(f"report:     {folder / 'report.html'}")


def say_fit(fit: Fit) -> None:
    """What was assumed about the data, and every table of a fit."""
    from ..report.words.terminal import fit_text, fit_view

    for note in fit.campaign.notes:
        click.echo(visible(f"note: {note}"))
    click.echo()
    if sys.stdout.isatty():
        from rich.console import Console

        Console().print(fit_view(fit))
    else:
        click.echo(visible(fit_text(fit, width())))
