"""A fit on the terminal, as wide as the window."""

from __future__ import annotations

from ident.fit import Fit


def show_fit(fit: Fit) -> None:
    """Print the notes of the campaign and the tables of a fit."""
    import shutil
    import sys

    import click

    from ident.report.terminal import fit_text, fit_view

    for note in fit.campaign.notes:
        click.echo(f"note: {note}")
    click.echo()
    if sys.stdout.isatty():
        from rich.console import Console

        Console().print(fit_view(fit))
    else:
        click.echo(fit_text(fit, min(shutil.get_terminal_size((100, 24)).columns, 120)))
