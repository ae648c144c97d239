"""Sizes of hidden states and of amplitudes, by their units."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from ..units import exponents
from .linear.guess import DataScales

_PART = 0.1  # of the spring's force at the largest amplitude: a law that is seen, and does not rule


def size_of_hidden(units: Sequence[str], amplitude: float, volts: float, omega: float) -> np.ndarray:
    """About as large as what moves hidden states with these units makes them in a motion of an amplitude (m) at a
    pulsation (rad/s) under a drive (V)."""
    sizes = {"m": amplitude, "V": volts, "s": 1.0 / omega}
    size = lambda unit: math.prod(sizes.get(base, 1.0) ** power for base, power in exponents(unit).items())
    return np.array([size(unit) for unit in units])


def small_size(unit: str, scales: DataScales, mass: float) -> float:
    """A size of an amplitude with a unit with which its force is a small part of the spring's, where the motion is
    largest; of a drive or a reading the same part of those."""
    of = {"kg": mass, "m": scales.displacement, "s": scales.period / (2 * math.pi), "V": scales.voltage}
    return _PART * math.prod(of[base] ** power for base, power in exponents(unit).items())
