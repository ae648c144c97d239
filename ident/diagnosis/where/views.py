"""The residual seen along one axis: how far each part of it rises above the noise floor, and whether by chance."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from scipy.special import chdtrc, ndtr


class View(NamedTuple):
    """Residual against one axis.

    **Arguments:** `axis`: what is binned, with its unit; `edges` (k + 1,); `ratio` (k,): rms residual ÷ noise floor in
    each bin, NaN where nothing was measured; `excess` (k,): χ² above that of noise; `p_value` (k,): probability that
    noise alone rises so high; `distinct` (k,): probability that the bin is no worse than all others together.
    """

    axis: str
    edges: np.ndarray
    ratio: np.ndarray
    excess: np.ndarray
    p_value: np.ndarray
    distinct: np.ndarray

    @property
    def centres(self) -> np.ndarray:
        return (self.edges[1:] + self.edges[:-1]) / 2

    def stands_out(self, alarms: float, factor: float = 1.5) -> np.ndarray:
        """Bins (k,) above the noise floor and `factor` times worse, in χ² above noise, than the mean of all bins."""
        seen = np.isfinite(self.ratio)
        count = max(int(seen.sum()), 1)
        above = np.where(seen, self.ratio**2 - 1, 0.0)
        worse = above > factor * float(np.mean(above[seen])) if np.any(seen) else np.zeros(len(above), bool)
        with np.errstate(invalid="ignore"):
            return seen & worse & (self.p_value * count < alarms) & (self.distinct * count < alarms)

    def share(self, chosen: np.ndarray) -> float:
        """Part of the excess that lies in the chosen bins, 0 to 1."""
        positive = np.maximum(np.nan_to_num(self.excess), 0.0)
        return float(positive[chosen].sum() / max(positive.sum(), 1e-300))


def view(axis: str, place: np.ndarray, edges: np.ndarray, squares: np.ndarray, floor_error: float) -> View:
    """Bin squared white residuals, (n,), by their `place`, (n,).

    A bin of n samples of white noise has mean square 1 ± √(2/n); a misfit m² adds m² ± √(4 m²/n). The noise floor
    itself is known to a relative `floor_error`, which blurs the first comparison and not the second.
    """
    k = len(edges) - 1
    number = np.clip(np.searchsorted(edges, place, side="right") - 1, 0, k - 1)
    count = np.bincount(number, minlength=k).astype(float)
    total = np.bincount(number, weights=squares, minlength=k)
    return from_sums(axis, edges, total, count, floor_error)


def from_sums(axis: str, edges: np.ndarray, total: np.ndarray, count: np.ndarray, floor_error: float) -> View:
    """The same from sums of squares (k,) and their numbers of degrees of freedom (k,)."""
    with np.errstate(divide="ignore", invalid="ignore"):
        mean = total / count
        rest_count = count.sum() - count
        rest = (total.sum() - total) / rest_count
        spread = lambda m, n: (2 + 4 * np.maximum(m - 1, 0)) / n
        z = (mean - rest) / np.sqrt(spread(mean, count) + spread(rest, rest_count))
        p = chance_of(total, count, floor_error)
    empty = count < 1
    ratio = np.where(empty, np.nan, np.sqrt(np.where(empty, 1.0, mean)))
    distinct = np.where(np.isfinite(z), ndtr(-z), 1.0)
    return View(axis, edges, ratio, total - count, np.where(empty, 1.0, p), np.where(empty, 1.0, distinct))


def chance_of(chi2: Any, freedom: Any, floor_error: float) -> Any:
    """Probability that noise alone reaches this χ², the noise floor being known to a relative `floor_error`.

    The floor's error widens the distribution: variance 2 n (1 + 2 n e²) in place of 2 n.
    """
    return chdtrc(freedom, freedom + (chi2 - freedom) / np.sqrt(1 + 2 * freedom * floor_error**2))
