"""The noise floor of a record, from the data alone."""

from __future__ import annotations

import numpy as np

from .record import NoiseFloor


def noise_floor(time: np.ndarray, drive: np.ndarray, response: np.ndarray, period: float | None = None) -> NoiseFloor:
    """Noise floor from the scatter that high differences of the response show.

    **Arguments:** `time` (n,) s, `drive` (n,) V, `response` (n,) m, `period`: samples per period of the drive or None.
    """
    sixth = np.diff(response, 6)
    sigma = float(np.median(np.abs(sixth))) / 0.6745 / np.sqrt(924.0)
    return NoiseFloor(max(sigma, 1e-9 * float(np.std(response))), method="sixth differences", relative_error=0.1)
