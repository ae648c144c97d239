"""What columns explain, from their inner products: rows of as many numbers as the records have are met once.

A score asks of many points of a grid which share of a residual r a few columns X explain beside what a model absorbs,
A: of P X with P = 1 − A Aᵀ. All that it needs are XᵀX, XᵀA and Xᵀr, as r has nothing of A. A column of which P leaves
less than a thousandth is none, and of its square a millionth is told from rounding by ten digits.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from .basis import ABSORBED

_SAME = 1e-10  # of the largest eigenvalue: sums of columns that cannot be told from nothing have no size


class Inner(NamedTuple):
    """Inner products of rows (q, n): among `themselves`, (q, q); of what a model does not absorb of them, `kept`; and
    `along` the residual, (q,)."""

    themselves: np.ndarray
    kept: np.ndarray
    along: np.ndarray

    @property
    def drop(self) -> float | None:
        """The fall of χ²; None if the model absorbs them all."""
        size = np.diag(self.themselves)
        usable = np.isfinite(size) & (size > 0)
        power, axes = self._axes(np.sqrt(size[usable]), usable)
        told = power > ABSORBED**2
        if not np.any(told):
            return None
        seen = axes.T @ (self.along[usable] / np.sqrt(size[usable]))
        return float(np.sum(seen[told] ** 2 / power[told]))

    @property
    def sizes(self) -> np.ndarray:
        """How much of each row the residual has, (q,); none of one that the model absorbs: rounding has no size."""
        size, whole = np.diag(self.kept), np.diag(self.themselves)
        usable = np.isfinite(size) & (size > ABSORBED**2 * whole)
        found, lengths = np.zeros(len(size)), np.sqrt(size[usable])
        power, axes = self._axes(lengths, usable)
        told = power > _SAME * np.max(power, initial=0.0)
        axes = axes[:, told]
        found[usable] = axes @ (axes.T @ (self.along[usable] / lengths) / power[told]) / lengths
        return found

    def without(self, gone: np.ndarray) -> Inner:
        """The same with some of the rows, (q,), at zero."""
        there = ~gone
        both = np.outer(there, there)
        return Inner(self.themselves * both, self.kept * both, self.along * there)

    def _axes(self, lengths: np.ndarray, usable: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        return np.linalg.eigh(self.kept[np.ix_(usable, usable)] / np.outer(lengths, lengths))


def inner(rows: np.ndarray, absorbed: np.ndarray, residual: np.ndarray) -> list[Inner]:
    """Of each of several sets of rows, (p, q, n), beside what the columns of `absorbed`, (n, k), do."""
    p, q, n = rows.shape
    with np.errstate(invalid="ignore", over="ignore"):  # where a memory has no bound
        shared = (rows.reshape(p * q, n) @ absorbed).reshape(p, q, -1)
        themselves = rows @ np.swapaxes(rows, 1, 2)
        kept = themselves - shared @ np.swapaxes(shared, 1, 2)
        return [Inner(*one) for one in zip(themselves, kept, rows @ residual, strict=True)]
