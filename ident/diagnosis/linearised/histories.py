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

if TYPE_CHECKING:
    from .regression import Regression

_ROUNDS = 6  # of the sizes with the histories held, and of the histories with the sizes held


class Histories(NamedTuple):
    """Changes of a candidate's rows by its hidden states at the start: `rows` (h, rows, n), each per unit of
    `start_scale`; `spans`: where the records that begin in motion are in n."""

    rows: np.ndarray
    spans: tuple[slice, ...]

    def fitted(self, regression: Regression, raw: np.ndarray, own: slice) -> tuple[np.ndarray, float]:
        """The rows (k, n) of one point of a grid with the histories that suit it best, and what these cost in χ²."""
        slopes = self.rows[:, own]
        kept, best, price = regression.project(raw), raw, 0.0
        if not np.all(np.isfinite(kept)):
            return raw, price
        for _ in range(_ROUNDS):
            lengths = np.maximum(np.linalg.norm(kept, axis=1), 1e-300)
            size = np.linalg.lstsq((kept / lengths[:, None]).T, regression.residual, rcond=1e-10)[0] / lengths
            acting = regression.project(self._by_record(np.einsum("a,han->hn", size, slopes)))
            # I + ΦΦᵀ by its eigenvalues: beside a memory that dies slowly the identity is lost in rounding.
            gains, axes = np.linalg.eigh(acting @ acting.T)
            gains = np.maximum(gains, 0.0)
            wanted = axes.T @ (acting @ (regression.residual - size @ regression.project(raw)))
            found = axes @ (wanted / (1.0 + gains))
            best = raw.copy()
            for record, h in zip(self.spans, found.reshape(len(self.spans), -1), strict=True):
                best[:, record] += np.einsum("h,han->an", h, slopes[:, :, record])
            kept = regression.project(best)
            price = float(found @ found + np.sum(np.log1p(gains)))
        return best, price

    def beyond(self, regression: Regression, raw: np.ndarray, size: np.ndarray, own: slice) -> np.ndarray:
        """What the rows (k, n) of one point, with amplitudes `size` (k,), do beyond any history that the effect could
        have had; (n, q) orthonormal. Only that is evidence: a memory that rings down by itself fits many a nuisance."""
        dying = orthonormal(regression.project(self._by_record(np.einsum("a,han->hn", size, self.rows[:, own]))))
        kept = regression.project(raw)
        return orthonormal(kept - (kept @ dying) @ dying.T, raw)

    def _by_record(self, rows: np.ndarray) -> np.ndarray:
        """Rows (h, n) of all records as rows (records h, n) of one each."""
        apart = np.zeros((len(self.spans), *rows.shape))
        for k, record in enumerate(self.spans):
            apart[k, :, record] = rows[:, record]
        return apart.reshape(-1, rows.shape[1])


def begun_apart(regression: Regression, model: Model, places: int) -> np.ndarray | None:
    """Histories (h, places, records, hidden) of a model whose last effect has each of its h hidden states in turn at
    its unit when a record begins in motion; None if it has none, or if all records start at rest."""
    records, states = regression.fit.campaign.fitted, len(model.effects[-1].state0())
    if not states or all(record.start == "rest" for record in records):
        return None
    equation = Equation(model)
    scales = np.array([start_scale(record, 1.0 / regression.fit.scales.period, equation)[2:] for record in records])
    found = np.zeros((states, places, *scales.shape))
    for j, hidden in enumerate(range(scales.shape[1] - states, scales.shape[1])):
        found[j, :, :, hidden] = scales[:, hidden]
    return found


def histories(regression: Regression, changed: np.ndarray, rows: np.ndarray) -> Histories:
    """How `rows` (d, n) change with histories `begun_apart`, with which they are `changed` (h, d, n)."""
    records = zip(regression.fit.campaign.fitted, regression.places, strict=False)
    spans = tuple(own for record, own in records if record.start != "rest")
    # A point of a grid at which the memory has no bound has no history that could say anything either.
    known = np.all(np.isfinite(rows), axis=1, keepdims=True)
    bounded = known & np.all(np.isfinite(changed), axis=2, keepdims=True)
    return Histories(np.where(bounded, changed - np.where(known, rows, 0.0), 0.0), spans)
