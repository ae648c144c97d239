"""One sensor, several records: their noise has one colour, which all of them together know better than each alone."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from ..record import NoiseFloor
from .autoregression import variance_of
from .floor import EXTRAPOLATED, extrapolated


def pooled(floors: Sequence[NoiseFloor], lengths: Sequence[int]) -> list[NoiseFloor]:
    """The noise floors with one common colour, if theirs agree within their errors; otherwise as they are.

    Each record keeps the strength of its own innovations, which is well known; the ratio of σ to it, which depends on
    the slowest noise and is poorly known, is shared: log ratios are averaged with the weights of their errors. What
    extrapolation does not know is common to all.

    **Arguments:** `floors`: those that were estimated; `lengths`: samples of each record.
    """
    coloured = [floor for floor in floors if 1 <= len(floor.ar) <= 2 and 0.0 < floor.relative_error < 0.5]
    if len(coloured) < 2 or len({len(floor.ar) for floor in floors}) > 1 or len(coloured) < len(floors):
        return list(floors)
    reflections = np.array([_reflections(floor.ar) for floor in coloured])
    gains = np.array([0.5 * np.log(variance_of(np.array(floor.ar), 1.0)) for floor in coloured])
    errors = np.array([max(floor.relative_error, 1e-3) for floor in coloured])
    weights = errors**-2 / np.sum(errors**-2)
    mean = float(np.sum(weights * gains))
    freedom = len(coloured) - 1
    if np.sum(((gains - mean) / errors) ** 2) > freedom + 2.5 * np.sqrt(2.0 * freedom):
        return list(floors)
    ar = _coefficients(np.tanh(np.sum(weights[:, None] * np.arctanh(reflections), axis=0)))
    common = 0.5 * np.log(variance_of(ar, 1.0))
    shared = float(np.sum(errors**-2) ** -0.5)
    if all(extrapolated(floor) for floor in coloured):
        shared = max(shared, EXTRAPOLATED)
    found = []
    for floor, gain, length in zip(coloured, gains, lengths, strict=True):
        error = float(np.hypot(shared, np.sqrt(0.5 / length)))
        sigma = floor.sigma * float(np.exp(common - gain))
        method = f"{floor.method}; colour shared by {len(coloured)} records"
        found.append(replace(floor, sigma=sigma, ar=tuple(float(a) for a in ar), method=method, relative_error=error))
    return found


def _reflections(ar: tuple[float, ...]) -> list[float]:
    """Partial autocorrelations, by the Levinson recursion backwards."""
    coefficients, found = np.array(ar), []
    while len(coefficients):
        last = float(np.clip(coefficients[-1], -0.9999, 0.9999))
        found.append(last)
        coefficients = (coefficients[:-1] + last * coefficients[:-1][::-1]) / (1 - last**2)
    return found[::-1]


def _coefficients(reflections: np.ndarray) -> np.ndarray:
    ar = np.zeros(0)
    for reflection in reflections:
        ar = np.append(ar - reflection * ar[::-1], reflection)
    return ar
