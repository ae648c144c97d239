"""How far a model and a possible effect together could describe sweeps: the balance of the fundamental, refitted.

The drive that is needed is linear in the amplitudes, but its modulus is not: where phases were not measured, a spring
that turns the drive by a right angle changes nothing to first order and much to second. The few numbers are therefore
searched, which takes a millisecond; traces beside the sweeps count as linear.

Source: G. A. F. Seber, C. J. Wild, Nonlinear Regression, 1989, §14.2 (Levenberg and Marquardt).
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from .curve_columns import Moves

if TYPE_CHECKING:
    from .score import Bench

_ROUNDS = 60
_STARTS = (0.0, 0.3, -0.3)  # of the drive that was there, as size of the effect
_SMALL = 1e-9  # fall of χ², as a share, that ends a search


class Balanced(NamedTuple):
    """`step` (k + q,) of the model's own parameters and of the amplitudes; what is `left` (n,), white; `slopes` (k + q,
    n) of what the readings do there."""

    step: np.ndarray
    left: np.ndarray
    slopes: np.ndarray


def balanced(bench: Bench, samples: np.ndarray, moves: Moves) -> Balanced:
    """The best of a model and q amplitudes.

    **Arguments:** `samples`, (q, samples) white: what a unit of each does to the traces; `moves`, of q: to the points
    of the sweeps.
    """
    plane, own = bench.plane, len(bench.directions)
    assert plane is not None  # there are sweeps
    first = samples.shape[1]
    drives = np.concatenate([plane.own, moves.drives])
    shares = np.concatenate([np.zeros_like(plane.own), moves.shares])
    rows = np.concatenate([bench.known[:, :first], samples])
    largest = np.max(np.abs(drives), axis=1) / np.median(plane.curves.points.level) + np.max(np.abs(shares), axis=1)
    usable = np.isfinite(largest) & ((largest > 0) | (np.abs(rows).max(axis=1, initial=0.0) > 0))
    scale = np.where(usable, 1.0 / np.where(largest > 0, largest, 1.0), 0.0)
    both, rows = Moves(drives * scale[:, None], shares * scale[:, None]), rows * scale[:, None]

    def at(x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        needed, given = plane.needed + x @ both.drives, 1.0 + x @ both.shares
        left = np.concatenate([bench.left[:first] - x @ rows, plane.left(needed, given)])
        return left, np.concatenate([rows, -plane.slopes(needed, given, both)], axis=1)

    found = []
    for size in _STARTS[: 1 if not len(moves.drives) else None]:
        x = np.zeros(len(drives))
        x[own:] = size
        found.append(_searched(at, x))
    step, left, slopes = min(found, key=lambda one: float(one[1] @ one[1]))
    return Balanced(step * scale, left, slopes)


def samples_of(bench: Bench) -> int:
    """How many of the bench's numbers are samples of traces."""
    return bench.n - (0 if bench.plane is None else len(bench.plane.order))


def _searched(at: Callable[[np.ndarray], tuple[np.ndarray, np.ndarray]], x: np.ndarray) -> Balanced:
    left, slopes = at(x)
    damping, cost = 1e-3, float(left @ left)
    for _ in range(_ROUNDS):
        gram = slopes @ slopes.T
        units = np.maximum(np.diag(gram), 1e-300)
        move = np.linalg.lstsq(gram + damping * np.diag(units), slopes @ left, rcond=1e-14)[0]
        with np.errstate(all="ignore"):
            tried = at(x + move)
        new = float(tried[0] @ tried[0])
        if not new < cost:
            damping *= 8
            if damping > 1e8:
                break
            continue
        small = cost - new < _SMALL * cost
        x, (left, slopes), cost, damping = x + move, tried, new, damping / 5
        if small:
            break
    return Balanced(x, left, slopes)
