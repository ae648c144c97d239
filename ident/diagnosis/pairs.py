"""Two effects at once: what one does to the readings may hide what the other does.

A force that grows with V² and a stiffness that follows V, say, both shift the centre of the motion; against each other
they leave little of it, and either alone explains next to nothing. Scores of pairs cost no simulation: the columns of
every candidate are there already.
"""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from .bench import Bench
from .score import Candidate

_SURVIVES = 1e-4  # squared share of a column that must be left beside the other effect's: rounding and the measured
# path's noise make up the rest


class Pair(NamedTuple):
    """Two candidates, the one that explains more alone first; `left` (n,): whitened residual with both, as scored, and
    the `numbers` of the model with them (see `evidence`)."""

    names: tuple[str, str]
    left: np.ndarray
    numbers: int


def best_pair(
    bench: Bench, candidates: Sequence[Candidate], one: str | None = None, most: float = np.inf
) -> Pair | None:
    """The two candidates (one of them as named) that explain the most together, at the best points of their grids, with
    at `most` so many numbers between them."""
    points = [(c.signature, *c.near_signatures) for c in candidates]
    flat = [p for several in points for p in several]
    if len(candidates) < 2 or not flat:
        return None
    rows = np.concatenate(flat)
    edges = np.cumsum([0, *(len(p) for p in flat)])
    firsts = np.cumsum([0, *(len(several) for several in points)])
    spans = [slice(a, b) for a, b in itertools.pairwise(edges)]
    of = [spans[a:b] for a, b in itertools.pairwise(firsts)]
    gram, along = rows @ rows.T, rows @ bench.residual
    best, chosen = -np.inf, None
    for i, j in itertools.combinations(range(len(candidates)), 2):
        if one is not None and one not in (candidates[i].name, candidates[j].name):
            continue
        if candidates[i].dof + candidates[j].dof > most:
            continue
        price = (candidates[i].dof + candidates[j].dof) * np.log(bench.n)
        for a, b in itertools.product(of[i], of[j]):
            worth = _drop(gram, along, a, b) - price
            if worth > best:
                best, chosen = worth, (i, j, a, b)
    if chosen is None:
        return None
    i, j, a, b = chosen
    both = np.concatenate([rows[a], rows[b]])
    u, s, _ = np.linalg.svd(both.T, full_matrices=False)
    basis = u[:, s**2 > _SURVIVES * s[0] ** 2]
    ordered = sorted((candidates[i], candidates[j]), key=lambda c: -c.drop)
    left = bench.residual - basis @ (basis.T @ bench.residual)
    return Pair((ordered[0].name, ordered[1].name), left, bench.numbers + candidates[i].dof + candidates[j].dof)


def _drop(gram: np.ndarray, along: np.ndarray, a: slice, b: slice) -> float:
    """Fall of χ² by two orthonormal sets of rows: by the first, and by what the second has beside it."""
    cross = gram[b, a]
    beside = along[b] - cross @ along[a]
    sizes, vectors = np.linalg.eigh(np.eye(len(cross)) - cross @ cross.T)
    kept = sizes > _SURVIVES
    return float(along[a] @ along[a] + np.sum((vectors[:, kept].T @ beside) ** 2 / sizes[kept]))
