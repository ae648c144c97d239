"""Zeros of records' own that are fitted with every model.

As an initial state does, such a zero moves one record only, and it enters linearly: at any parameters the one that fits
best is known without a search, and least squares over the others go on with what it leaves,

    y = z(p) + c(p) · curves,   c(p) = argmin |w (m − z(p) − c · curves)|²,   dy = dz + dc · curves.

So nothing that a model lacks is read out of a record before the law that would say it has been asked. A fit that has
ended reads its records by the zeros that it found, and its readings are the device's motion alone.

Source: G. H. Golub, V. Pereyra, The differentiation of pseudo-inverses and nonlinear least squares problems whose
variables separate, SIAM J. Numer. Anal. 10 (1973) 413 (here the curves do not depend on the others).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from ..campaign.apart import TOLD, read_on, zero_curves
from ..campaign.campaign import Campaign
from ..campaign.record import Trace


class Zero(NamedTuple):
    """The zero of one record: its `place` among the fitted ones, and the `curves` (q, n) of which it is a sum."""

    place: int
    curves: np.ndarray


def lay_zeros(records: Sequence[Trace]) -> tuple[Zero, ...]:
    """The zeros that are fitted with every model to some records."""
    found = (Zero(k, zero_curves(record)) for k, record in enumerate(records))
    return tuple(zero for zero in found if len(zero.curves))


def numbers_of_zeros(records: Sequence[Trace]) -> int:
    """How many numbers such zeros are."""
    return sum(TOLD[r.own[0]].each for r in records if r.floats and r.own is not None)


def read_by(campaign: Campaign, parts: Sequence[np.ndarray]) -> Campaign:
    """The campaign with its traces read by the zeros that were found beside those by which they had been, (n,) each."""
    found = iter(parts)
    told = (read_on(r, next(found)) if isinstance(r, Trace) else r for r in campaign.records)
    return replace(campaign, records=tuple(told))


@np.errstate(over="ignore", invalid="ignore")
def best_by(zeros: Sequence[Zero], slices: Sequence[slice], weight: np.ndarray, rows: np.ndarray) -> np.ndarray:
    """The part (k, samples) of rows that zeros make best, each record's own with the weights of its samples. A motion
    without bound has no zero: a record read by one would be no record any more."""
    part = np.zeros_like(rows)
    for zero in zeros:
        own = slices[zero.place]
        seen = zero.curves * weight[own]
        share = np.linalg.pinv(seen @ seen.T, hermitian=True) @ (seen @ (rows[:, own] * weight[own]).T)
        found = share.T @ zero.curves
        part[:, own] = np.where(np.all(np.isfinite(found), axis=1, keepdims=True), found, 0.0)
    return part
