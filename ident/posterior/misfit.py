"""Whether the model describes the records well enough for an interval to mean anything.

An interval says where a parameter is *if the model is right*. So what the peak leaves, whitened by the records' own
noise, is held against noise: its size, within the doubt of the floor; its correlation with itself; and single
frequencies that stick out of its spectrum, as products of the drive would.

Sources: as in `portmanteau`; R. A. Fisher, Proc. R. Soc. A 125 (1929) 54 (the largest ordinate of a periodogram).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np
from scipy import stats

from ..campaign.noise.portmanteau import SLIGHT, portmanteau
from ..fit.result import Fit
from .density import Density
from .laplace import inverse
from .noise_model import Noise

_ALARM = 1e-3  # probability of one false alarm over all records and tests together

Doubts = Callable[[Fit], Sequence[str]]
"""Reasons against a model that are found elsewhere; they take refits, and are asked for when all else is there."""


class Misfit(NamedTuple):
    """What is wrong with a model at its peak: `reasons` in words, none if nothing is; `p_value`, the smallest,
    corrected for the number of tests."""

    reasons: tuple[str, ...]
    p_value: float


def misfit(density: Density) -> Misfit:
    """Judge what the model leaves at the density's centre."""
    origin = np.zeros((1, density.size))
    white, raw = (
        [w[0] for w in one.innovations(origin)] for one in (density, density.with_noise(_colourless(density)))
    )
    tests = 3 * len(white)
    reasons, smallest = [], 1.0
    for record, noise, w, bare in zip(density.records, density.noises, white, raw, strict=True):
        repeats = _correlation(w, len(noise.ar))
        if len(noise.ar) and np.isfinite(noise.freedom):
            # A colour estimated without the model is no law: what is white without it is noise as well.
            repeats = max(repeats, _correlation(bare, 0))
        found = {
            "is larger than its noise floor": _size(w, noise.freedom),
            "repeats itself": repeats,
            "has lines in its spectrum": _largest_line(w),
        }
        smallest = min(smallest, *(min(1.0, tests * p) for p in found.values()))
        worst = min(found, key=lambda name: found[name])
        if tests * found[worst] < _ALARM:
            ratio = float(np.sqrt(np.mean(w**2)))
            reasons.append(f"what the model leaves of {record.name} {worst} (error over noise {ratio:.3g})")
    return Misfit(tuple(reasons), smallest)


def _size(w: np.ndarray, freedom: float) -> float:
    """Probability of so large a χ² if the floor's variance is known with so many degrees of freedom."""
    chi2, n = float(w @ w), len(w)
    return float(stats.chi2.sf(chi2, n)) if np.isinf(freedom) else float(stats.f.sf(chi2 / n, n, freedom))


def _correlation(w: np.ndarray, order: int) -> float:
    rho, q = portmanteau(w - w.mean())
    freedom, slight = max(len(rho) - order, 1), len(w) * SLIGHT**2 if order else 0.0
    return float(stats.ncx2.sf(q, freedom, slight) if slight else stats.chi2.sf(q, freedom))


def _largest_line(w: np.ndarray) -> float:
    power = np.abs(np.fft.rfft(w - w.mean())[1:-1]) ** 2
    share = float(power.max() / power.sum())
    return float(min(1.0, len(power) * (1.0 - share) ** (len(power) - 1)))


def _colourless(density: Density) -> list[Noise]:
    """The records' noises, were they white."""
    return [noise._replace(ar=noise.ar[:0], gain=1.0) for noise in density.noises]


def too_narrow(density: Density) -> float:
    """By how much intervals would be too narrow if the colour of the noise were ignored: the largest ratio of a
    parameter's standard error with and without it; one for white noise."""
    if not any(record.noise.ar for record in density.records):
        return 1.0
    coloured = density.linearise().matrix + density.prior_slope()[1]
    ignoring = density.with_noise(_colourless(density)).linearise().matrix + density.prior_slope()[1]
    deviations = [np.sqrt(np.diag(inverse(m))) for m in (coloured, ignoring)]
    return float(np.max(deviations[0] / np.maximum(deviations[1], 1e-300)))
