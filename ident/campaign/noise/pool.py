"""One sensor, several records: their noise has one colour, which all of them together know better than each alone."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import reduce

import numpy as np

from ..record import NoiseFloor
from .autoregression import predictors, variance_of, with_reflection
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
    reflections = np.array([[ar[-1] for ar, _ in predictors(np.array(floor.ar))[1:]] for floor in coloured])
    gains = np.array([0.5 * np.log(variance_of(np.array(floor.ar), 1.0)) for floor in coloured])
    errors = np.array([max(floor.relative_error, 1e-3) for floor in coloured])
    weights = errors**-2 / np.sum(errors**-2)
    mean = float(np.sum(weights * gains))
    freedom = len(coloured) - 1
    if np.sum(((gains - mean) / errors) ** 2) > freedom + 2.5 * np.sqrt(2.0 * freedom):
        return list(floors)
    mean_reflections = np.tanh(np.sum(weights[:, None] * np.arctanh(reflections), axis=0))
    ar = reduce(with_reflection, mean_reflections, np.zeros(0))
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
