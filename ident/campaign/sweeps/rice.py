"""What an amplitude reads beside noise: never less than nothing.

    E|H + n| = σ √(π/2) ₁F₁(−½; 1; −H²/2σ²),   E|H + n|² = H² + 2σ²

with noise n of standard deviation σ in both parts. Far above the noise that is H, in it about 1.25 σ whatever H is.

Source: S. O. Rice, Mathematical analysis of random noise, Bell System Technical Journal 24 (1945) 46, §3.10.
"""

from __future__ import annotations

import numpy as np
from scipy.special import ive

_FAR = 40.0  # standard deviations from where on the amplitude is the amplitude


def read_beside(size: np.ndarray, noise: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Mean of the amplitude that is read, its derivative by the true `size`, and its standard deviation."""
    ratio = np.minimum(size / noise, _FAR)
    half = ratio**2 / 4
    flat, bent = ive(0, half), ive(1, half)  # times e^(−half)
    mean = np.sqrt(np.pi / 2) * ((1 + 2 * half) * flat + 2 * half * bent)
    slope = np.sqrt(np.pi / 2) * ratio / 2 * (flat + bent)
    spread = np.sqrt(np.maximum(2 + ratio**2 - mean**2, 0.0))
    far = size >= _FAR * noise
    return np.where(far, size, mean * noise), np.where(far, 1.0, slope), np.where(far, 1.0, spread) * noise
