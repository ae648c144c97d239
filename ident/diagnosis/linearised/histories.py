"""What came before a record that begins in motion, as far as a candidate's memory is concerned.

A memory at the first sample is whatever its history made it. For a candidate of size a with hidden states h₀ there,
the readings change by a (c + Φ h₀), with Φ the dying response to a start of one unit, record by record; its scores are
taken with the h₀ that suit it best, drawn from N(0, 1) in units of `start_scale`. What they gain is weighed against how
many others would have been as likely: the fall of χ² counts less h₀ᵀh₀ + ln |1 + a² ΦᵀΦ|.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from ...fit.assemble import start_scale
from ...model import Model
from ...response import Equation
from .basis import orthonormal
from .inner import Inner, inner

if TYPE_CHECKING:
    from .regression import Regression

_ROUNDS = 6  # of the sizes with the histories held, and of the histories with the sizes held


class Histories(NamedTuple):
    """Changes of a candidate's rows by its hidden states at the start: `rows` (h, rows, n), each per unit of
    `start_scale`; `spans`: where the records that begin in motion are in n."""

    rows: np.ndarray
    spans: tuple[slice, ...]

    def fitted(self, regression: Regression, raw: np.ndarray, own: slice) -> tuple[np.ndarray, Inner, float]:
        """The histories (records, h) that suit the rows (q, n) of one point of a grid best, the inner products of the
        rows with them, and what they cost in χ²."""
        (alone,) = inner(raw[None], regression.absorbed, regression.residual)
        none = np.zeros((len(self.spans), len(self.rows)))
        if not np.all(np.isfinite(alone.kept)):
            return none, alone, 0.0
        met, found, price = _Met.of(self, regression, raw, own), none.ravel(), 0.0
        for _ in range(_ROUNDS):
            size = met.beside(alone, found).sizes
            acting = np.einsum("a,iajb,b->ij", size, met.kept, size)
            # I + ΦΦᵀ by its eigenvalues: beside a memory that dies slowly the identity is lost in rounding.
            gains, axes = np.linalg.eigh(acting)
            gains = np.maximum(gains, 0.0)
            wanted = axes.T @ (met.along @ size - np.einsum("a,iab,b->i", size, met.kept_with, size))
            found = axes @ (wanted / (1.0 + gains))
            price = float(found @ found + np.sum(np.log1p(gains)))
        return found.reshape(none.shape), met.beside(alone, found), price

    def added(self, raw: np.ndarray, found: np.ndarray, own: slice) -> np.ndarray:
        """The rows (q, n) of one point with the histories that were found for it."""
        best = raw.copy()
        for record, h in zip(self.spans, found, strict=True):
            best[:, record] += np.einsum("h,han->an", h, self.rows[:, own, record])
        return best

    def beyond(self, regression: Regression, raw: np.ndarray, size: np.ndarray, own: slice) -> np.ndarray:
        """What the rows (k, n) of one point, with amplitudes `size` (k,), do beyond any history that the effect could
        have had; (n, q) orthonormal. Only that is evidence: a memory that rings down by itself fits many a nuisance."""
        rows = np.einsum("a,han->hn", size, self.rows[:, own])
        apart = np.zeros((len(self.spans), *rows.shape))
        for k, record in enumerate(self.spans):
            apart[k, :, record] = rows[:, record]
        dying = orthonormal(regression.project(apart.reshape(-1, rows.shape[1])))
        kept = regression.project(raw)
        return orthonormal(kept - (kept @ dying) @ dying.T, raw)


class _Met(NamedTuple):
    """Inner products of the changes (i, q, n), one for each hidden state of each record, of which none meets another
    record's: among `themselves`, (i, q, i, q), `with_rows` of the point, (i, q, q), both `kept` beside what the model
    absorbs, and `along` the residual, (i, q)."""

    themselves: np.ndarray
    kept: np.ndarray
    with_rows: np.ndarray
    kept_with: np.ndarray
    along: np.ndarray

    @classmethod
    def of(cls, histories: Histories, regression: Regression, raw: np.ndarray, own: slice) -> _Met:
        spans, (h, q) = histories.spans, (len(histories.rows), len(raw))
        count = len(spans) * h
        themselves, with_rows = np.zeros((count, q, count, q)), np.zeros((count, q, q))
        along, shared = np.zeros((count, q)), np.zeros((count, q, regression.absorbed.shape[1]))
        for k, record in enumerate(spans):
            at, rows = slice(k * h, (k + 1) * h), histories.rows[:, own, record].reshape(h * q, -1)
            themselves[at, :, at, :] = (rows @ rows.T).reshape(h, q, h, q)
            with_rows[at] = (rows @ raw[:, record].T).reshape(h, q, q)
            along[at] = (rows @ regression.residual[record]).reshape(h, q)
            shared[at] = (rows @ regression.absorbed[record]).reshape(h, q, -1)
        by_rows = raw @ regression.absorbed
        kept = themselves - np.einsum("iak,jbk->iajb", shared, shared)
        return cls(themselves, kept, with_rows, with_rows - np.einsum("iak,bk->iab", shared, by_rows), along)

    def beside(self, alone: Inner, found: np.ndarray) -> Inner:
        """Inner products of the rows with histories `found`, (i,)."""

        def changed(one: np.ndarray, crossed: np.ndarray, squares: np.ndarray) -> np.ndarray:
            once = np.einsum("i,iab->ab", found, crossed)
            return one + once + once.T + np.einsum("i,iajb,j->ab", found, squares, found)

        themselves = changed(alone.themselves, self.with_rows, self.themselves)
        return Inner(themselves, changed(alone.kept, self.kept_with, self.kept), alone.along + found @ self.along)


def begun_apart(regression: Regression, model: Model, values: np.ndarray) -> np.ndarray | None:
    """Histories (h, places, records, hidden) of a model at `values` (places, m) whose last effect has each of its h
    hidden states in turn at its unit when a record begins in motion; None if it has none, or if all records start at
    rest."""
    records, states = regression.fit.campaign.fitted, len(model.effects[-1].state0())
    if not states or all(record.start == "rest" for record in records):
        return None
    equation, frequency = Equation(model), 1.0 / regression.fit.scales.period
    swings = [equation.swings(one) for one in values]
    scales = np.array([[start_scale(record, frequency, equation, each)[2:] for record in records] for each in swings])
    found = np.zeros((states, *scales.shape))
    for j, hidden in enumerate(range(scales.shape[2] - states, scales.shape[2])):
        found[j, :, :, hidden] = scales[:, :, hidden]
    return found


def histories(regression: Regression, changed: np.ndarray, rows: np.ndarray) -> Histories:
    """How `rows` (d, n) change with histories `begun_apart`, with which they are `changed` (h, d, n)."""
    records = zip(regression.fit.campaign.fitted, regression.places, strict=False)
    spans = tuple(own for record, own in records if record.start != "rest")
    # A point of a grid at which the memory has no bound has no history that could say anything either.
    known = np.all(np.isfinite(rows), axis=1, keepdims=True)
    # What does nothing whatever the drive has done is not seen by histories, which would grow without end, either.
    known &= np.any(rows, axis=1, keepdims=True)
    bounded = known & np.all(np.isfinite(changed), axis=2, keepdims=True)
    return Histories(np.where(bounded, changed - np.where(known, rows, 0.0), 0.0), spans)
