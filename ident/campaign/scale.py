"""A sensor's sensitivity: what a column in volts means, `scale = { response = "5 um/V" }`."""

from __future__ import annotations

import re
from typing import NamedTuple

from ..errors import UserError
from ..units import ACCELERATION, Dimension, Unit, base_unit, find_unit
from .tables.table import MOST

_SENSITIVITY = re.compile(
    r"\s*([-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?)\s*([^\d\s(].*?)\s*/\s*(\([^()]+\)|[^/()]+)\s*"
)
_GRAVITY = Unit("g_n", 9.80665, ACCELERATION)  # of an accelerometer's mV/g; a gram else


class Scale(NamedTuple):
    """`factor`: SI of the quantity per SI of the column; the column's `dimension`; the `unit` of the quantity, and how
    much SI it is."""

    factor: float
    dimension: Dimension
    unit: str
    size: float


def parse_scale(text: str, wanted: Dimension, base: str, where: str) -> Scale:
    """A sensitivity, "5 um/V" or "100 mV/g", for a quantity of dimension `wanted` with the base unit `base`.

    **Raises:** UserError if neither side of the slash is of that dimension.
    """
    match = _SENSITIVITY.fullmatch(text)
    do = f'write for example "5 {base}/V", or "0.2 V/({base})"'
    if match is None:
        raise UserError(f'"{text}" is no sensitivity', where=where, do=do)
    value = float(match[1])
    above, below = (_unit(name.strip(" ()"), wanted) for name in match.groups()[1:])
    if not 1 / MOST < abs(value) < MOST or above is None or below is None:
        raise UserError(f'"{text}" is no sensitivity', where=where, do=do)
    if above[2] == wanted:
        return Scale(value * above[1] / below[1], below[2], above[0], above[1])
    if below[2] == wanted:
        return Scale(below[1] / (value * above[1]), above[2], below[0], below[1])
    raise UserError(f'"{text}" says nothing about a quantity in {base}', where=where, do=do)


def quantity_of(text: str) -> str:
    """The unit of what a sensitivity is about, the side of the slash that is not volts; "" if it is none."""
    match = _SENSITIVITY.fullmatch(text)
    sides = [] if match is None else [_unit(name.strip(" ()"), _GRAVITY.dimension) for name in match.groups()[1:]]
    known = [base_unit(side[2]) for side in sides if side is not None]
    return next((unit for unit in known if unit != "V"), "V") if len(known) == 2 else ""


def _unit(name: str, wanted: Dimension) -> tuple[str, float, Dimension] | None:
    found = _GRAVITY if name == "g" and wanted == _GRAVITY.dimension else find_unit(name)
    return None if found is None else (found.name, found.factor, found.dimension)
