"""Columns within a width: lines are broken between words, or at a hyphen, and never inside a word while any room is
left."""

from __future__ import annotations

import re
from collections.abc import Sequence

_GAP = 3  # between two columns
_BREAK = re.compile(r"(?<= )(?<!± )(?=[^\s%])|(?<=[^\W\d_]-)(?=[^\W\d_])|(?<=\w_)(?=\w)|(?<=[\w.]/)(?=\w{3})")
"""After a space, but not between "±" and its number or before "%"; within names also after a hyphen, "_" or "/", but
not in 1e-3, -5 or mN/V."""


def columns_within(cells: Sequence[Sequence[str]], gives: Sequence[bool], width: int) -> list[int]:
    """Widths of the columns of a table, each given with its heading by all its `cells`, in so many characters together.

    **Arguments:** `gives`: which columns may be broken over lines. The widest of them gives way first, none below its
    longest piece; where that is not enough those are broken that were not to be, and in the end pieces too.
    """
    widths = [max((len(cell) for cell in column), default=0) for column in cells]
    least = [max((len(piece.rstrip()) for cell in column for piece in _pieces(cell)), default=0) for column in cells]
    room = width - _GAP * (len(cells) - 1)
    everyone = [True] * len(cells)
    for may, floor in ((gives, least), (everyone, least), (gives, [1] * len(cells)), (everyone, [1] * len(cells))):
        while sum(widths) > room:
            able = [i for i, low in enumerate(floor) if may[i] and widths[i] > low]
            if not able:
                break
            widths[max(able, key=lambda i: widths[i])] -= 1
    return widths


def broken(text: str, width: int) -> str:
    """A text in lines of at most so many characters, broken between its pieces; a longer piece stands on its own."""
    lines = [""]
    for piece in _pieces(text):
        if lines[-1] and len(lines[-1] + piece.rstrip()) > width:
            lines.append("")
        lines[-1] += piece
    return "\n".join(line.rstrip() for line in lines)


def _pieces(text: str) -> list[str]:
    """What a text may be broken between, each with the space after it."""
    return _BREAK.split(text)
