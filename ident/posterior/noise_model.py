"""The likelihood of what a model leaves, given the records' noise: its colour, and the doubt of its size.

A residual in noise floors is whitened by the record's own autoregression, given its first samples. Where the floor is
an estimate with relative error δ its variance is unknown with ν = 1/(2δ²) degrees of freedom, and the likelihood of n
white residuals becomes Student's:

    ln L = ln Γ((ν+n)/2) − ln Γ(ν/2) − (n/2) ln πν − ((ν+n)/2) ln(1 + χ²/ν) − Σ ln σ

Source: A. Zellner, An Introduction to Bayesian Inference in Econometrics, 1971, §3.2 (unknown variance), §7.1 (AR).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any, NamedTuple

import jax.numpy as jnp
import numpy as np
from jax.scipy.special import gammaln

from ..campaign.autoregression import variance_of
from ..campaign.record import Trace
from ..fit.result import SigmaChoice

_UNKNOWN = math.sqrt(0.5)  # relative error of a floor of which nothing is known: one degree of freedom


class Noise(NamedTuple):
    """The noise of the lanes of one group.

    **Arguments:** `ar` (lanes, k), zero-padded; `gain` (lanes,): σ over that of the innovations; `counted` (lanes, n):
    1 where an innovation counts; `count` (lanes,) how many; `freedom` (lanes,) ν, infinite where the floor is known;
    `log_sigma` (lanes,) ln of the innovations' σ, SI.
    """

    ar: np.ndarray
    gain: np.ndarray
    counted: np.ndarray
    count: np.ndarray
    freedom: np.ndarray
    log_sigma: np.ndarray


def group_noise(records: Sequence[Trace], length: int, sigma: SigmaChoice) -> Noise:
    """The noise of records that share a group of padded `length`; `sigma`, what the fit's error bars stand on."""
    order = max((len(r.noise.ar) for r in records), default=0)
    ar = np.zeros((len(records), order))
    counted = np.zeros((len(records), length))
    gain, freedom, log_sigma = (np.zeros(len(records)) for _ in range(3))
    for i, record in enumerate(records):
        own = np.asarray(record.noise.ar, float)
        ar[i, : len(own)] = own
        counted[i, record.skip + len(own) : len(record.time)] = 1.0
        gain[i] = math.sqrt(variance_of(own, 1.0))
        log_sigma[i] = math.log(record.noise.sigma / gain[i])
        doubt = record.noise.relative_error
        if sigma == "scaled":
            doubt = _UNKNOWN
        elif sigma == "fitted":
            doubt = max(doubt, 1.0 / math.sqrt(2.0 * counted[i].sum()))
        freedom[i] = 1.0 / (2.0 * doubt**2) if doubt > 0 else np.inf
    return Noise(ar, gain, counted, counted.sum(axis=1), freedom, log_sigma)


def whiten(noise: Noise, residual: Any) -> Any:
    """Innovations in units of their σ, of residuals (..., lanes, n) in noise floors; zero where none counts."""
    found = residual
    for j in range(noise.ar.shape[1]):
        earlier = jnp.pad(residual, [(0, 0)] * (residual.ndim - 1) + [(j + 1, 0)])[..., : residual.shape[-1]]
        found = found - noise.ar[:, j, None] * earlier
    return found * noise.gain[:, None] * noise.counted


def log_likelihood(noise: Noise, chi2: Any) -> Any:
    """ln L (lanes,) of records with Σ innovation² = `chi2` (lanes,), in units of the floors."""
    known = jnp.isinf(noise.freedom)
    nu, n = jnp.where(known, 1.0, noise.freedom), noise.count
    gaussian = -0.5 * chi2 - 0.5 * n * math.log(2 * math.pi)
    student = (
        gammaln((nu + n) / 2) - gammaln(nu / 2) - 0.5 * n * jnp.log(jnp.pi * nu) - 0.5 * (nu + n) * jnp.log1p(chi2 / nu)
    )
    return jnp.where(known, gaussian, student) - n * noise.log_sigma


def precision(noise: Noise, chi2: np.ndarray) -> np.ndarray:
    """(lanes,) expected σ⁻² in units of the floor's, given Σ innovation²: the weight of each record."""
    known = np.isinf(noise.freedom)
    nu = np.where(known, 1.0, noise.freedom)
    return np.where(known, 1.0, (nu + noise.count) / (nu + chi2))
