"""ln likelihood of the records by blocks of time, at draws of the posterior.

Neighbouring samples of a motion say nearly the same thing, so what is left out, or counted, is a stretch of time. The
doubt of a noise floor binds all blocks of a record together: its size is drawn beside each draw, so that the blocks are
independent given the draw.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from .density import Density

BLOCKS = 10
"""Stretches into which the counted part of each record is cut: longer than the memory of any resonance met, and enough
of them for a standard error."""


class Blocks(NamedTuple):
    """`log_likelihood` (k, blocks) at k draws; per block its `record` and its `length` in samples; `readings`, (k, n)
    per record, and `sigma` (k, records): drawn noise over the floor."""

    log_likelihood: np.ndarray
    record: np.ndarray
    length: np.ndarray
    sigma: np.ndarray


def block_likelihood(density: Density, x: np.ndarray) -> Blocks:
    """At draws (k, p) in the coordinates of the density."""
    random = np.random.default_rng([0, 3])
    white = density.innovations(x)
    logs, record, length, sigmas = [], [], [], []
    for i, (w, noise) in enumerate(zip(white, density.noises, strict=True)):
        nu, n = noise.freedom, noise.count
        chi2 = np.sum(w**2, axis=1)
        variance = np.ones(len(x)) if np.isinf(nu) else (nu + chi2) / random.chisquare(nu + n, size=len(x))
        for part in np.array_split(np.arange(w.shape[1]), BLOCKS):
            constant = 0.5 * math.log(2 * math.pi) + noise.log_sigma
            cost = 0.5 * np.sum(w[:, part] ** 2, axis=1) / variance + 0.5 * len(part) * np.log(variance)
            logs.append(-cost - len(part) * constant)
            record.append(i)
            length.append(len(part))
        sigmas.append(np.sqrt(variance))
    return Blocks(np.stack(logs, axis=1), np.array(record), np.array(length), np.stack(sigmas, axis=1))
