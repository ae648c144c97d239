"""What stands above a table, or beside it: the words by which instruments tell units, channels and the time step."""

from __future__ import annotations

import re
from collections.abc import Sequence


def preamble_words(rows: Sequence[Sequence[str]]) -> tuple[str, list[str], list[str]]:
    """Unit of time, units of the channels and names of the channels, from lines of a key and its values.

    Tektronix writes "Horizontal Units", "Vertical Units" and "Source", Keysight "X Units" and "Y Units", LabVIEW
    "X_Dimension" and "Y_Unit_Label".
    """
    horizontal, vertical, sources = "", [], []
    for row in rows:
        key = re.sub(r"[ _:]+", " ", row[0].strip().strip('"').lower()).strip() if row else ""
        values = [cell.strip().strip('"').strip() for cell in row[1:]]
        values = [value for value in values if value]
        if not values:
            continue
        if re.fullmatch(r"(horizontal|x|time) ?(unit|units)", key):
            horizontal = values[0]
        elif re.fullmatch(r"(vertical|y) ?(unit|units|unit label)", key):
            vertical = values
        elif key in ("source", "channel", "trace"):
            sources = values
    return horizontal, vertical, sources
