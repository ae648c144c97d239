"""Two effects at once: what one does to the readings may hide what the other does.

A force that grows with V² and a stiffness that follows V, say, both shift the centre of the motion; against each other
they leave little of it, and either alone explains next to nothing. Scores of pairs cost no simulation: the columns of
every candidate are there already.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from ..linearised.regression import Regression
from .weigh import Candidate

_SURVIVES = 1e-4  # squared share of a column that must be left beside the other effect's: rounding and the measured
# path's noise make up the rest


class Pair(NamedTuple):
    """Two candidates, the one that explains more alone first; `left` (n,): whitened residual with both, as scored, and
    the `numbers` of the model with them (see `evidence`)."""

    names: tuple[str, str]
    left: np.ndarray
    numbers: int


def best_pair(regression: Regression, candidates: Sequence[Candidate], one: str | None = None) -> Pair | None:
    """The two candidates (one of them as named) that explain the most together, at the best points of their grids."""
    points = [(k, rows) for k, c in enumerate(candidates) for rows in (c.signature, *c.near_signatures)]
    if len(candidates) < 2 or not points:
        return None
    of = np.array([k for k, _ in points])
    named = np.array([one is None or candidates[k].name == one for k in of])
    prices = np.array([candidates[k].dof for k in of]) * np.log(regression.n)
    worth = _drops([rows for _, rows in points], regression.residual) - prices[:, None] - prices
    worth[(of[:, None] >= of) | ~(named[:, None] | named)] = -np.inf
    a, b = np.unravel_index(int(np.argmax(worth)), worth.shape)
    if worth[a, b] == -np.inf:
        return None
    i, j = of[a], of[b]
    both = np.concatenate([points[a][1], points[b][1]])
    u, s, _ = np.linalg.svd(both.T, full_matrices=False)
    basis = u[:, s**2 > _SURVIVES * s[0] ** 2]
    ordered = sorted((candidates[i], candidates[j]), key=lambda c: -c.drop)
    left = regression.residual - basis @ (basis.T @ regression.residual)
    return Pair((ordered[0].name, ordered[1].name), left, regression.numbers + candidates[i].dof + candidates[j].dof)


def _drops(signatures: Sequence[np.ndarray], residual: np.ndarray) -> np.ndarray:
    """Fall of χ² by any two orthonormal sets of rows, (sets, sets): by the first, and by what the second has beside
    it. A set with fewer rows than others is filled up with zeros, which do nothing."""
    sets, most = len(signatures), max(len(rows) for rows in signatures)
    places = np.concatenate([k * most + np.arange(len(rows)) for k, rows in enumerate(signatures)])
    rows = np.concatenate(signatures)
    gram, along = np.zeros((sets * most, sets * most)), np.zeros(sets * most)
    gram[np.ix_(places, places)], along[places] = rows @ rows.T, rows @ residual
    cross = gram.reshape(sets, most, sets, most).transpose(2, 0, 1, 3)  # (first, second, rows of it, of the first)
    along = along.reshape(sets, most)
    beside = along[None] - np.einsum("abij,aj->abi", cross, along)
    sizes, vectors = np.linalg.eigh(np.eye(most) - cross @ np.swapaxes(cross, 2, 3))
    parts = np.einsum("abij,abi->abj", vectors, beside) ** 2
    second = np.sum(np.where(sizes > _SURVIVES, parts / np.maximum(sizes, _SURVIVES), 0.0), axis=2)
    return np.sum(along**2, axis=1)[:, None] + second
