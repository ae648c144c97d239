"""Long records that were sampled far more often than their motion needs: filtered against aliases, and thinned.

Drive and response pass the same linear filter, which for a linear device leaves the one the response to the other. The
noise floor is estimated from what is left, so that it is that of the samples which a fit sees.
"""

from __future__ import annotations

import numpy as np

MANY = 100_000  # samples of a record: fewer are read in a moment and fitted in seconds as they are
PER_PERIOD = 40  # samples that are kept of the fastest motion: the solver takes about as many steps
_SEGMENT = 65_536  # samples of a spectrum
_NOISE = 30.0  # times the median of the upper half of a spectrum, which is noise: chance reaches that once in 10⁹
_MOTION, _DRIVE = 1e-8, 1e-2  # of the power: what is faster of the response, of the drive, leaves the fit as it is


def thinning(drive: np.ndarray, response: np.ndarray) -> int:
    """Every which sample of a record (n,) is enough: 1 for all that are not long."""
    if len(response) <= MANY:
        return 1
    top = max(_fastest(response, _MOTION), _fastest(drive, _DRIVE))
    return max(int(1.0 / (PER_PERIOD * top)), 1) if top > 0 else 1


def thinned(signal: np.ndarray, every: int) -> np.ndarray:
    """Every so many samples of a signal (n,), filtered without phase against what would alias."""
    from scipy.signal import resample_poly  # here, because its import costs more than reading a campaign

    return np.asarray(resample_poly(signal, 1, every, padtype="line"))


def thinned_mask(masked: np.ndarray, every: int) -> np.ndarray:
    """The samples kept (n,) near which a masked one is."""
    wide = np.convolve(masked.astype(float), np.ones(2 * every + 1), "same") > 0.5
    return wide[::every]


def _fastest(signal: np.ndarray, share: float) -> float:
    """Frequency, per sample, above which a signal has less than a share of its power beyond noise."""
    from scipy.signal import welch

    frequency, power = welch(signal, nperseg=_SEGMENT, detrend="constant")
    noise = float(np.median(power[len(power) // 2 :]))
    beyond = np.where(power > _NOISE * noise, power, 0.0)
    above = np.cumsum(beyond[::-1])[::-1]
    faster = np.flatnonzero(above > share * above[0])
    return float(frequency[faster[-1]]) if len(faster) and above[0] > 0 else 0.0
