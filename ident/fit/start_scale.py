"""Sizes of hidden states, by their units."""

from __future__ import annotations

import math
from collections.abc import Sequence

from ..units import exponents


def size_of_hidden(units: Sequence[str], amplitude: float, volts: float, omega: float) -> list[float]:
    """About as large as hidden states with these units become in a motion of an amplitude (m) at a pulsation (rad/s)
    under a drive (V)."""
    sizes = {"m": amplitude, "V": volts, "s": 1.0 / omega}
    return [math.prod(sizes.get(base, 1.0) ** power for base, power in exponents(unit).items()) for unit in units]
