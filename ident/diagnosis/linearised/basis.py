"""The span of rows, without what is negligible."""

from __future__ import annotations

import numpy as np

ABSORBED = 1e-3  # share of a column that must survive the projection for it to say anything new


def orthonormal(rows: np.ndarray, like: np.ndarray | None = None) -> np.ndarray:
    """Orthonormal basis (n, q) of the span of rows (k, n), ignoring those that are negligible against `like`."""
    lengths = np.linalg.norm(rows if like is None else like, axis=1)
    usable = np.isfinite(lengths) & (lengths > 0)
    if not np.any(usable):
        return np.zeros((rows.shape[1], 0))
    u, s, _ = np.linalg.svd((rows[usable] / lengths[usable, None]).T, full_matrices=False)
    return u[:, s > ABSORBED * (1.0 if like is not None else 1e-4)]
