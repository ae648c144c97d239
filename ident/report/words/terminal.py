"""A fit in the terminal: tables and sentences within the width of the window."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING

from ...errors import visible
from ...fit.result import Fit
from .linear import linear_sheet
from .sentences import Sentence, sentences, verdict
from .sheet import plain, rich_sheet
from .tables import combination_sentences, correlation_sentences, parameter_sheet, record_sheet, start_sheet

if TYPE_CHECKING:
    from rich.console import Group, RenderableType


def fit_view(fit: Fit) -> Group:
    """The whole fit for a `rich` console: `console.print(fit_view(fit))`."""
    from rich.console import Group

    parts: list[RenderableType] = [_paragraph(verdict(fit)), rich_sheet(parameter_sheet(fit))]
    parts += _list("Undetermined", map(Sentence, combination_sentences(fit)))
    parts += _list("Strong correlations", map(Sentence, correlation_sentences(fit)))
    parts += [rich_sheet(record_sheet(fit)), rich_sheet(start_sheet(fit))]
    parts += [rich_sheet(sheet) for sheet in [linear_sheet(fit)] if sheet is not None]
    parts += _list("To know", sentences(fit))
    return Group(*parts)


def fit_text(fit: Fit, width: int = 96) -> str:
    """What is told of a fit, as plain text."""
    return plain(fit_view(fit), width)


def _paragraph(text: str) -> RenderableType:
    from rich.padding import Padding
    from rich.text import Text

    return Padding(Text(visible(text)), (0, 0, 1, 0))


def _list(title: str, items: Iterable[Sentence]) -> list[RenderableType]:
    """Sentences with a hanging indent under a heading; nothing if there are none."""
    from rich.padding import Padding
    from rich.table import Table
    from rich.text import Text

    grid = Table.grid(padding=(0, 1))
    grid.add_column(width=1)
    grid.add_column(overflow="fold")
    for text, warning in items:
        grid.add_row("!" if warning else "·", Text(visible(text)), style="yellow" if warning else "")
    return [Text(title, style="bold"), Padding(grid, (0, 0, 1, 0))] if grid.rows else []
