"""Recursive filters as triangular banded systems: `scipy.signal` takes longer to import than a warm fit to search."""

from __future__ import annotations

import numpy as np
from scipy.linalg.lapack import dtbtrs  # pyright: ignore[reportAttributeAccessIssue]  (missing from its stubs)


def recursive_filter(numerator: np.ndarray, denominator: np.ndarray, values: np.ndarray) -> np.ndarray:
    """Output y of the filter Σ a_k y[i − k] = Σ b_k x[i − k], which is at rest before the first sample.

    **Arguments:** `numerator` b and `denominator` a, a_0 = 1; `values` x, (n,) or (n, columns), filtered along the
    first axis. **Returns:** as `values`.
    """
    x = np.asarray(values, float)
    fed = numerator[0] * x
    for k, b in enumerate(numerator[1:], 1):
        fed[k:] += b * x[:-k]
    bands = np.empty((len(denominator), len(x)), order="F")
    bands[:] = np.reshape(denominator, (-1, 1))
    solved, _ = dtbtrs(bands, fed.reshape(len(x), -1), uplo="L", diag="U")
    return np.asarray(solved).reshape(x.shape)
