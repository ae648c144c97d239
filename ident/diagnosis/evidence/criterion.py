"""Which of several models do the records prefer? One criterion, where noise is left and where laws differ.

    n ln χ² + k ln n

(G. Schwarz, Ann. Statist. 6 (1978) 461; the size of what is left is unknown), with k the numbers of a model and n the
independent samples in what the best one leaves. At the noise floor these are all samples, and differences are those of
χ² + k ln n. Far above it, where every model lacks something, what is left is as smooth as the motion, and the same fall
of χ² says less: counted in samples, any law with shape numbers to spare would win.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple, Protocol

import numpy as np

from ...fit.linear.independent import independent_samples

# Differences of 2 ln(odds), in words: R. E. Kass, A. E. Raftery, Bayes factors, 1995, JASA 90, 773, §3.2.
VERY_STRONG = 10.0  # below it records do not choose
STRONG = 6.0  # below it the evidence is positive at best


class Weighed(Protocol):
    """A model beside records: `left`, (n,) its whitened residual, and how many `numbers` it has."""

    @property
    def left(self) -> np.ndarray: ...
    @property
    def numbers(self) -> float: ...


class Left(NamedTuple):
    """What a model leaves, and its numbers."""

    left: np.ndarray
    numbers: float


def criteria(models: Sequence[Weighed]) -> list[float]:
    """The criterion of each of several models of the same records; less is better, and differences are 2 ln(odds)."""
    left = [float(model.left @ model.left) for model in models]
    if not np.any(np.isfinite(left)):
        return [np.inf] * len(models)
    n = independent_samples(models[int(np.nanargmin(left))].left)
    price = float(np.log(n))
    sizes = np.where(np.isfinite(left), np.maximum(left, 1e-300), np.inf)
    return [float(n * np.log(size) + model.numbers * price) for size, model in zip(sizes, models, strict=True)]


def behind(one: Weighed, other: Weighed) -> float:
    """By how much the criterion of one model is worse than that of another."""
    first, second = criteria((one, other))
    return first - second if np.isfinite(second) else -np.inf


def clearly_better(one: Weighed, other: Weighed) -> bool:
    """Whether the records choose one model rather than another."""
    return behind(one, other) < -VERY_STRONG
