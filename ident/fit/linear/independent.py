"""How many independent samples there are in what a model leaves."""

from __future__ import annotations

import numpy as np

_FEWEST = 4.0  # of a single line


def independent_samples(left: np.ndarray) -> float:
    """Effective number of independent samples of a residual (n,): 4 (Σ P)²/Σ P² of its power spectrum P.

    n for white noise, and about four for a single line. What a model leaves that lacks something is no noise: it is as
    smooth as the motion, and a hundred of its samples may say one thing.

    Source: G. M. Jenkins, D. G. Watts, Spectral Analysis and Its Applications, 1968, §6.4 (equivalent degrees of
    freedom).
    """
    power = np.abs(np.fft.rfft(left)) ** 2
    participation = float(np.sum(power)) ** 2 / max(float(np.sum(power**2)), 1e-300)
    return float(np.clip(4.0 * participation, min(_FEWEST, len(left)), len(left)))
