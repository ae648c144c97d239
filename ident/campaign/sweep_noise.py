"""The noise floor of an amplitude-frequency curve, from the scatter of neighbouring points."""

from __future__ import annotations

import numpy as np

from .record import NoiseFloor


def sweep_noise_floor(frequency: np.ndarray, level: np.ndarray, amplitude: np.ndarray, up: np.ndarray) -> NoiseFloor:
    """Robust scatter of the third differences along each branch, σ = MAD/0.6745/√20.

    A smooth curve has small third differences where points are dense; jumps are outliers that the median ignores.

    **Arguments:** `frequency` (n,) Hz, `level` (n,) V, `amplitude` (n,) m, `up` (n,) bool.

    Source: J. von Neumann, "Distribution of the ratio of the mean square successive difference to the variance",
    Ann. Math. Stat. 12 (1941) 367, doi:10.1214/aoms/1177731677, with third instead of first differences.
    """
    differences = []
    for one in np.unique(level):
        for direction in (True, False):
            branch = (level == one) & (up == direction)
            if branch.sum() >= 8:
                order = np.argsort(frequency[branch], kind="stable")
                differences.append(np.diff(amplitude[branch][order], 3))
    size = float(np.sqrt(np.mean(amplitude**2)))
    if not differences:
        return NoiseFloor(
            0.01 * size, method="assumed: 1 % of the rms amplitude (too few points to tell)", relative_error=1.0
        )
    together = np.concatenate(differences)
    sigma = float(np.median(np.abs(together))) / 0.6745 / np.sqrt(20.0)
    if sigma < 1e-6 * size:
        method = "assumed: 0.1 % of the rms amplitude (the points show no scatter)"
        return NoiseFloor(1e-3 * size, method=method, relative_error=1.0)
    error = max(0.2, 1.5 / np.sqrt(len(together)))  # curvature between points enters too: an upper estimate
    return NoiseFloor(
        float(sigma), method=f"scatter of {len(together)} triples of neighbouring points", relative_error=error
    )
