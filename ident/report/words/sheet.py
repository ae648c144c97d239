"""A table as a value, written once and shown in the terminal and on the page alike."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, Literal, NamedTuple

from ...errors import visible
from .widths import broken, columns_within

if TYPE_CHECKING:
    from rich.console import Console, ConsoleOptions, RenderableType
    from rich.table import Table

Mark = Literal["", "quiet", "warning", "total"]
_STYLE = {"": "", "quiet": "dim", "warning": "yellow", "total": "bold"}


class Column(NamedTuple):
    """`name` above it; numbers are right-aligned; what has `wraps` is broken over lines before
    the others are."""

    name: str
    number: bool = False
    wraps: bool = False


class Sheet(NamedTuple):
    """A table: `marks` says per row how it is to be seen; `note`, one sentence under it."""

    title: str
    columns: tuple[Column, ...]
    rows: tuple[tuple[str, ...], ...]
    marks: tuple[Mark, ...] = ()
    note: str = ""

    def mark(self, row: int) -> Mark:
        return self.marks[row] if self.marks else ""


def file_words(name: str) -> str:
    """A file of another place, by its folder and name: all steps that lead there would leave no room for numbers."""
    parts = name.split("/")
    far = name.startswith("/") or parts.count("..") > 1
    return "/".join(["…", *parts[-2:]]) if far and len(parts) > 3 else name


class _Fitted:
    """A sheet without its note, as a `rich` console of any width asks for it."""

    def __init__(self, sheet: Sheet):
        self._sheet = sheet

    def __rich_console__(self, console: Console, options: ConsoleOptions) -> Iterator[Table]:
        yield rich_table(self._sheet, options.max_width)


def rich_table(sheet: Sheet, width: int) -> Table:
    """The sheet without its note within a width; colour only repeats what the words say."""
    from rich import box
    from rich.markup import escape
    from rich.table import Table

    table = Table(
        title=escape(visible(sheet.title)), title_justify="left", title_style="bold", box=box.SIMPLE_HEAD,
        pad_edge=False, padding=(0, 1), header_style="", show_edge=False,
    )  # fmt: skip
    rows = [tuple(visible(cell) for cell in row) for row in sheet.rows]
    cells = [(column.name, *(row[k] for row in rows)) for k, column in enumerate(sheet.columns)]
    widths = columns_within(cells, [column.wraps for column in sheet.columns], width)
    for column, wide in zip(sheet.columns, widths, strict=True):
        name = escape(broken(column.name, wide))
        table.add_column(name, justify="right" if column.number else "left", overflow="fold")
    total = False
    for i, row in enumerate(rows):
        if sheet.mark(i) == "total" and not total and i:
            table.add_section()
            total = True
        told = (escape(broken(cell, wide)) for cell, wide in zip(row, widths, strict=True))
        table.add_row(*told, style=_STYLE[sheet.mark(i)])
    return table


def rich_sheet(sheet: Sheet) -> RenderableType:
    """The sheet with its note for a `rich` console."""
    from rich.console import Group
    from rich.padding import Padding
    from rich.text import Text

    table = _Fitted(sheet)
    return Padding(Group(table, Text(sheet.note)) if sheet.note else table, (0, 0, 1, 0))


def sheet_text(sheet: Sheet, width: int = 96) -> str:
    """One table as plain text."""
    return plain(rich_sheet(sheet), width)


def plain(view: RenderableType, width: int) -> str:
    """What a `rich` console shows, as text."""
    import io

    from rich.console import Console

    buffer = io.StringIO()
    Console(file=buffer, width=width, color_system=None, force_terminal=False, highlight=False).print(view)
    return "\n".join(line.rstrip() for line in buffer.getvalue().splitlines()) + "\n"
