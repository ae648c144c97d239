"""Filters, the recursive ones as triangular banded systems: `scipy.signal` takes longer to import (it brings
`scipy.stats`) than a warm fit to search."""

from __future__ import annotations

import numpy as np
from scipy.linalg.lapack import dtbtrs  # pyright: ignore[reportAttributeAccessIssue]  (missing from its stubs)


def convolved(taps: np.ndarray, values: np.ndarray) -> np.ndarray:
    """Output Σ b_k x[i − k] of a filter without memory of its own output, zero before the first sample; as `values`,
    (n,) or (n, columns)."""
    x = np.asarray(values, float)
    fed = taps[0] * x
    for k, b in enumerate(taps[1:], 1):
        fed[k:] += b * x[:-k]
    return fed


def recursive_filter(numerator: np.ndarray, denominator: np.ndarray, values: np.ndarray) -> np.ndarray:
    """Output y of the filter Σ a_k y[i − k] = Σ b_k x[i − k], which is at rest before the first sample.

    **Arguments:** `numerator` b and `denominator` a, a_0 = 1; `values` x, (n,) or (n, columns), filtered along the
    first axis. **Returns:** as `values`.
    """
    fed = convolved(numerator, values)
    bands = np.empty((len(denominator), len(fed)), order="F")
    bands[:] = np.reshape(denominator, (-1, 1))
    solved, _ = dtbtrs(bands, fed.reshape(len(fed), -1), uplo="L", diag="U")
    return np.asarray(solved).reshape(fed.shape)
