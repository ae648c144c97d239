"""The likelihood of what a model leaves, given the records' noise: its colour, and the doubt of its size.

A residual in noise floors is whitened by the record's own autoregression, given its first samples. Where the floor is
an estimate with relative error δ its variance is unknown with ν = 1/(2δ²) degrees of freedom, and the likelihood of n
white residuals becomes Student's:

    ln L = ln Γ((ν+n)/2) − ln Γ(ν/2) − (n/2) ln πν − ((ν+n)/2) ln(1 + χ²/ν) − Σ ln σ

Source: A. Zellner, An Introduction to Bayesian Inference in Econometrics, 1971, §3.2 (unknown variance), §7.1 (AR).
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from scipy.special import gammaln

from ..campaign.noise.autoregression import variance_of
from ..campaign.record import Trace
from ..fit.result import SigmaChoice

_UNKNOWN = math.sqrt(0.5)  # relative error of a floor of which nothing is known: one degree of freedom


class Noise(NamedTuple):
    """The noise of one record.

    **Arguments:** `ar` (k,); `gain`: σ over that of the innovations; `first` sample whose innovation counts, and how
    many do, `count`, without masked ones; `freedom` ν, infinite where the floor is known; `log_sigma`, ln of the
    innovations' σ, SI.
    """

    ar: np.ndarray
    gain: float
    first: int
    count: int
    freedom: float
    log_sigma: float


def record_noise(record: Trace, sigma: SigmaChoice) -> Noise:
    """The noise of a record; `sigma`, what the fit's error bars stand on."""
    ar = np.asarray(record.noise.ar, float)
    first = record.skip + len(ar)
    count = int(np.count_nonzero(record.counted[first:]))
    gain = math.sqrt(variance_of(ar, 1.0))
    doubt = record.noise.relative_error
    if sigma == "scaled":
        doubt = _UNKNOWN
    elif sigma == "fitted":
        doubt = max(doubt, 1.0 / math.sqrt(2.0 * count))
    freedom = 1.0 / (2.0 * doubt**2) if doubt > 0 else math.inf
    return Noise(ar, gain, first, count, freedom, math.log(record.noise.sigma / gain))


def whiten(noise: Noise, residual: np.ndarray) -> np.ndarray:
    """Innovations in units of their σ, of residuals (..., n) in noise floors: (..., n − first)."""
    found = residual[..., noise.first :]
    for j, weight in enumerate(noise.ar):
        earlier = noise.first - 1 - j
        found = found - weight * residual[..., earlier : earlier + found.shape[-1]]
    return found * noise.gain


def log_likelihood(noise: Noise, chi2: np.ndarray) -> np.ndarray:
    """ln L of a record with Σ innovation² = `chi2`, any shape, in units of the floor."""
    nu, n = noise.freedom, noise.count
    if math.isinf(nu):
        return -0.5 * chi2 - 0.5 * n * math.log(2 * math.pi) - n * noise.log_sigma
    constant = float(gammaln((nu + n) / 2) - gammaln(nu / 2)) - 0.5 * n * math.log(math.pi * nu)
    return constant - 0.5 * (nu + n) * np.log1p(chi2 / nu) - n * noise.log_sigma


def precision(noise: Noise, chi2: float) -> float:
    """Expected σ⁻² in units of the floor's, given Σ innovation²: the weight of the record."""
    return 1.0 if math.isinf(noise.freedom) else (noise.freedom + noise.count) / (noise.freedom + chi2)
