"""Single parameters changed by name: `{"quality": 40, "residual-stress.sigma12": "80 MPa"}`."""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np

from ..campaign.tables.table import is_number
from ..errors import UserError
from ..model import FREQUENCY, QUALITY, Model
from ..units import parse_frequency, parse_quantity, unit
from .access import position


def changed_values(model: Model, values: np.ndarray, changes: Mapping[str, float | str], order: int) -> np.ndarray:
    """The parameter values (m,) SI with those of `changes`: SI numbers, or texts with a unit; `order`:
    of the derivative of the displacement that is read.

    **Raises:** UserError for a name that the model does not have, or a value that its parameter cannot take.
    """
    values, units = np.array(values, float), model.units(order)
    for name, told in changes.items():
        index = position([p.name for p in model.parameters], name)
        parameter = model.parameters[index]
        if isinstance(told, str) and not is_number(told):
            if units[index] == "Hz":
                value = parse_frequency(told, where=name)
            else:
                value = parse_quantity(told, unit(units[index]).dimension, where=name)
        elif isinstance(told, (str, int, float, np.number)):
            value = float(told)
        else:
            raise UserError(f"{told!r} is no number", where=name, do='give a number in SI units, or a text ("0.6 kHz")')
        more = index in (FREQUENCY, QUALITY)  # of an amplitude zero means that there is none
        if not math.isfinite(value) or (parameter.positive and value < 0) or (more and value == 0):
            do = "give a finite number" + (" above zero" if more else " that is not negative" * parameter.positive)
            raise UserError(f"{told} is not possible", where=name, do=do)
        values[index] = value
    return values
