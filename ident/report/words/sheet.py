"""A table as a value, written once and shown in the terminal and on the page alike."""

from __future__ import annotations

from typing import TYPE_CHECKING, Literal, NamedTuple

from ...errors import visible

if TYPE_CHECKING:
    from rich.console import RenderableType
    from rich.table import Table

Mark = Literal["", "quiet", "warning", "total"]
_STYLE = {"": "", "quiet": "dim", "warning": "yellow", "total": "bold"}


class Column(NamedTuple):
    """`name` above it; numbers are right-aligned; what may be broken over lines has `wraps`."""

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


def rich_table(sheet: Sheet) -> Table:
    """The sheet without its note for a `rich` console; colour only repeats what the words say."""
    from rich import box
    from rich.markup import escape
    from rich.table import Table

    table = Table(
        title=escape(visible(sheet.title)), title_justify="left", title_style="bold", box=box.SIMPLE_HEAD,
        pad_edge=False, padding=(0, 1), header_style="", show_edge=False,
    )  # fmt: skip
    for column in sheet.columns:
        table.add_column(
            escape(column.name), justify="right" if column.number else "left",
            no_wrap=not column.wraps, overflow="fold" if column.wraps else "ellipsis",
        )  # fmt: skip
    total = False
    for i, row in enumerate(sheet.rows):
        if sheet.mark(i) == "total" and not total and i:
            table.add_section()
            total = True
        table.add_row(*(escape(visible(cell)) for cell in row), style=_STYLE[sheet.mark(i)])
    return table


def rich_sheet(sheet: Sheet) -> RenderableType:
    """The sheet with its note for a `rich` console."""
    from rich.console import Group
    from rich.padding import Padding
    from rich.text import Text

    return Padding(Group(rich_table(sheet), Text(sheet.note)) if sheet.note else rich_table(sheet), (0, 0, 1, 0))


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
