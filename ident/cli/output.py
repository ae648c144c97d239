"""Results go to stdout, progress to stderr."""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping
from typing import Any

import click


def progress(text: str) -> None:
    """One line of progress."""
    click.echo(f"{text}…", err=True)


def say(text: str = "") -> None:
    """One line or block of results."""
    click.echo(text)


def say_json(document: Mapping[str, Any]) -> None:
    """A JSON document as the result of a command."""
    click.echo(json.dumps(document, indent=1, ensure_ascii=False, allow_nan=False))


def columns(rows: Iterable[Iterable[str]]) -> str:
    """Rows of words as aligned columns."""
    table = [[str(cell) for cell in row] for row in rows]
    widths = [max(len(row[k]) for row in table) for k in range(len(table[0]))] if table else []
    return "\n".join(
        "  ".join(cell.ljust(width) for cell, width in zip(row, widths, strict=True)).rstrip() for row in table
    )
