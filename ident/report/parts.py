"""Parts of a run's page beside its fit, kept in its folder: the page is what the folder holds, whoever draws it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from .figures.picture import from_dict
from .html import Section
from .words.sheet import Column, Sheet

FILE = "parts.json"
ORDER = ("diagnosis", "posterior", "attribution")
"""By the commands that leave them; on the page they stand in this order, after the history of the run."""


def parts_dict(parts: Mapping[str, Sequence[Section]]) -> dict[str, Any]:
    """`parts.json`: per part its sections, pictures as base64."""
    told = {name: [_as_dict(section) for section in sections] for name, sections in parts.items()}
    return {"format": 1, "parts": told}


def parts_of(document: Mapping[str, Any]) -> dict[str, list[Section]]:
    """The parts that `parts.json` holds, in the order of the page."""
    told = document.get("parts", {})
    return {name: [_as_section(one) for one in told[name]] for name in ORDER if name in told}


def _as_dict(section: Section) -> dict[str, Any]:
    pictures = [picture.as_dict() for picture in section.pictures]
    sheets = [sheet._asdict() | {"columns": [list(c) for c in sheet.columns]} for sheet in section.sheets]
    return {"title": section.title, "paragraphs": list(section.paragraphs), "sheets": sheets, "pictures": pictures}


def _as_section(told: Mapping[str, Any]) -> Section:
    sheets = [
        Sheet(
            one["title"], tuple(Column(*c) for c in one["columns"]), tuple(tuple(row) for row in one["rows"]),
            tuple(one["marks"]), one["note"],
        )
        for one in told["sheets"]
    ]  # fmt: skip
    pictures = [from_dict(one) for one in told["pictures"]]
    return Section(told["title"], tuple(told["paragraphs"]), sheets, pictures)
