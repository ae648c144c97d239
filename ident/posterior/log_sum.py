"""Sums of exponentials without overflow, as numbers: by its stubs SciPy's may be a tuple."""

from __future__ import annotations

from typing import Any

import numpy as np
from scipy.special import logsumexp


def log_sum(logarithms: np.ndarray, axis: int | None = None) -> Any:
    """ln Σ exp, over all or along an axis."""
    return logsumexp(logarithms, axis=axis)
