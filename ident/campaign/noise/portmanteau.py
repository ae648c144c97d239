"""Whether what is left is white: its correlation with itself at the first lags, taken together.

    Q = n (n + 2) Σ_k ρ_k²/(n − k)

is χ² for noise, with a degree of freedom for every lag less those of the autoregression that whitened it.

Source: G. M. Ljung, G. E. P. Box, 1978, Biometrika 65, 297, doi:10.1093/biomet/65.2.297.
"""

from __future__ import annotations

import numpy as np

LAGS = 24  # at most
SLIGHT = 0.05  # correlation that an estimated noise colour leaves of itself


def portmanteau(white: np.ndarray) -> tuple[np.ndarray, float]:
    """ρ (k,) at lags 1, 2, …, of at most a quarter of the samples (n,), and Q."""
    n = len(white)
    lags = np.arange(1, min(LAGS, n // 4) + 1)
    power = float(white @ white) or 1.0
    rho = np.array([float(white[:-k] @ white[k:]) / power for k in lags])
    return rho, n * (n + 2) * float(np.sum(rho**2 / (n - lags)))
