"""Zeros of records' own that are fitted with every model.

As an initial state does, such a zero moves one record only, and it enters linearly: at any parameters the one that fits
best is known without a search, and least squares over the others go on with what it leaves,

    y = z(p) + c(p) · curves,   c(p) = argmin |w (m − z(p) − c · curves)|²,   dy = dz + dc · curves.

So nothing that a model lacks is read out of a record before the law that would say it has been asked.

Source: G. H. Golub, V. Pereyra, The differentiation of pseudo-inverses and nonlinear least squares problems whose
variables separate, SIAM J. Numer. Anal. 10 (1973) 413, in the form of L. Kaufman, BIT 15 (1975) 49.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from ..campaign.apart import TOLD, curves
from ..campaign.record import Trace


class Zero(NamedTuple):
    """The zero of one record: its `place` among the fitted ones, and the `curves` (q, n) of which it is a sum."""

    place: int
    curves: np.ndarray


def zero_curves(record: Trace) -> np.ndarray:
    """Of what a zero of a record's own is a sum, (q, n); of nothing, q = 0, unless it is fitted with every model."""
    each = TOLD[record.own[0]].each if record.floats and record.own is not None else 0
    return curves(record)[:each]


def lay_zeros(records: Sequence[Trace]) -> tuple[Zero, ...]:
    """The zeros that are fitted with every model to some records."""
    found = (Zero(k, zero_curves(record)) for k, record in enumerate(records))
    return tuple(zero for zero in found if len(zero.curves))


def numbers_of_zeros(records: Sequence[Trace]) -> int:
    """How many numbers such zeros are."""
    return sum(len(zero.curves) for zero in lay_zeros(records))


@np.errstate(over="ignore", invalid="ignore")  # a motion without bound has no zero
def best_by(zeros: Sequence[Zero], slices: Sequence[slice], weight: np.ndarray, rows: np.ndarray) -> np.ndarray:
    """The part (k, samples) of rows that zeros make best, each record's own with the weights of its samples."""
    part = np.zeros_like(rows)
    for zero in zeros:
        own = slices[zero.place]
        seen = zero.curves * weight[own]
        share = np.linalg.pinv(seen @ seen.T, hermitian=True) @ (seen @ (rows[:, own] * weight[own]).T)
        part[:, own] = share.T @ zero.curves
    return part
