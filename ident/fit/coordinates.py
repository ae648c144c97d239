"""Coordinates without bounds, in which the optimiser works; bounds are kept by bijections.

    no bound          c = p
    p > 0             c = ln p
    l < p < u         c = (L/4) ln(s/(1 − s)),  s = ln(p/l)/L,  L = ln(u/l)

A bound is never reached, only approached, and the covariance maps back by the slope dp/dc. A search works in ln p and
keeps to the ranges itself (see `solve`): near a bound of this coordinate slope and curvature vanish together.
"""

from __future__ import annotations

from typing import Any

import numpy as np

_EDGE = 1e-9  # of the range: a start on a bound is moved inside by this much


def to_values(coordinates: np.ndarray, lower: np.ndarray, upper: np.ndarray) -> np.ndarray:
    """Physical values from coordinates, elementwise; `lower` is −inf, 0 or positive, `upper` inf or finite."""
    positive, ranged = np.isfinite(lower), np.isfinite(upper)
    logarithm = np.where(positive & ~ranged, coordinates, 0.0)
    low, length = _range(lower, upper, ranged)
    with np.errstate(over="ignore"):  # far outside a range the value is the bound
        inside = low + length / (1.0 + np.exp(-4.0 * np.where(ranged, coordinates, 0.0) / length))
        return np.where(positive, np.exp(np.where(ranged, inside, logarithm)), coordinates)


def to_coordinates(values: np.ndarray, lower: np.ndarray, upper: np.ndarray) -> np.ndarray:
    """Coordinates of physical values."""
    positive, ranged = np.isfinite(lower), np.isfinite(upper)
    logarithm = np.log(np.where(positive, np.maximum(values, 1e-300), 1.0))
    low, length = _range(lower, upper, ranged)
    share = np.clip((logarithm - low) / length, _EDGE, 1 - _EDGE)
    inside = length / 4 * np.log(share / (1 - share))
    return np.where(ranged, inside, np.where(positive, logarithm, values))


def slopes(values: np.ndarray, lower: Any, upper: Any) -> np.ndarray:
    """dp/dc at physical values."""
    lower, upper = np.asarray(lower), np.asarray(upper)
    positive, ranged = np.isfinite(lower), np.isfinite(upper)
    low, length = _range(lower, upper, ranged)
    share = (np.log(np.where(ranged, np.maximum(values, 1e-300), 1.0)) - low) / length
    inside = 4.0 * np.clip(share * (1 - share), _EDGE, 0.25)
    return np.where(positive, values, 1.0) * np.where(ranged, inside, 1.0)


def _range(lower: Any, upper: Any, ranged: Any) -> tuple[Any, Any]:
    low = np.log(np.where(ranged, lower, 1.0))
    return low, np.where(ranged, np.log(np.where(ranged, upper, 2.0)) - low, 1.0)
