"""Could noise alone have done it? Tests for rich sets of functions, which follow slow noise as readily as an effect,
and for what a refit has gained.

Source: P. J. Brockwell, R. A. Davis, Time Series: Theory and Methods, 1991, §8.1 (prewhitening).
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from scipy.special import fdtrc

from ...campaign.noise.recursive import convolved
from ..linearised.whiten import prediction_filter
from .criterion import Left, Weighed, behind
from .force_noise import ForceNoise, force_noise

if TYPE_CHECKING:
    from ..linearised.regression import Regression

_SMALL = 1.5  # χ² per sample up to which the residual may be noise of a colour that the noise floor does not have


class _Past(NamedTuple):
    """Noise as an autoregression; `taps` of the filter that whitens it, after so many samples."""

    taps: np.ndarray

    @property
    def begins(self) -> int:
        return len(self.taps)

    def whiten(self, values: np.ndarray) -> np.ndarray:
        return convolved(self.taps, values)


def _colour(regression: Regression, k: int, left: np.ndarray, before: np.ndarray | None = None) -> _Past | ForceNoise:
    """The noise that is left of the k-th record: an autoregression of order 12, of what was left `before` if that is
    given; or noise of the force, which has fewer numbers, if that describes it better."""
    past, force = _Past(prediction_filter((left if before is None else before)[None])), force_noise(regression, k, left)
    price = np.log(max(len(left), 2)) / max(len(left), 1)
    worth = lambda way, numbers: np.log(max(float(np.var(way.whiten(left))), 1e-300)) + numbers * price
    return past if force is None or worth(force, 1) > worth(past, past.begins) else force


def chance(regression: Regression, basis: np.ndarray, tried: int, before: np.ndarray | None = None) -> float:
    """Probability of such a fall of χ² by chance, the colour of what is left taken into account.

    What remains after the candidate is modelled as coloured noise, record by record; candidate and residual are
    whitened with it and the F test is made there. As an autoregression it may be that of what was left `before`, (n,).
    """
    left = regression.residual - basis @ (basis.T @ regression.residual)
    colours = [
        _colour(regression, k, left[own], None if before is None else before[own])
        for k, own in enumerate(regression.places)
    ]
    # Where noise of the force rules some frequencies the others tell the parameters otherwise than all did alike.
    absorbed = regression.absorbed[:, : regression.absorbed.shape[1] * any(isinstance(c, ForceNoise) for c in colours)]
    white = []
    for colour, own in zip(colours, regression.places, strict=True):
        noise = left if before is None or isinstance(colour, ForceNoise) else before
        columns = [noise[own], regression.residual[own], basis[own], absorbed[own]]
        found = colour.whiten(np.column_stack(columns))
        white.append(found[:, 1:] / (float(np.std(found[:, 0])) or 1.0))
    target, regressors, beside = np.split(np.concatenate(white), [1, 1 + basis.shape[1]], axis=1)
    own, _ = np.linalg.qr(beside)
    target, regressors = target - own @ (own.T @ target), regressors - own @ (own.T @ regressors)
    q, _ = np.linalg.qr(regressors)
    drop = float(np.sum((q.T @ target) ** 2))
    freedom = regression.n - tried - regression.absorbed.shape[1]
    rest = max((float(np.sum(target**2)) - drop) / freedom, 1e-300)
    return float(fdtrc(tried, freedom, drop / tried / rest))


def chance_of(regression: Regression, basis: np.ndarray) -> float:
    """Probability of such a fall of χ² by chance.

    A small misfit is first supposed to be noise throughout, and everything is whitened by its own colour; a large one
    cannot be, and only what the functions leave is (`chance`). Noise of the force is only what they leave: it has the
    colour of the device's own answers, and would be whatever a law makes of them.

    **Arguments:** `basis` (n, dof), orthonormal.
    """
    if not basis.shape[1]:  # a constant is nothing where each record has a zero of its own
        return 1.0
    small = regression.chi2 <= _SMALL * regression.n
    return chance(regression, basis, basis.shape[1], regression.residual if small else None)


def behind_in_colour(after: Weighed, before: Regression) -> float:
    """By how much the criterion of a refit is worse than that of the fit before, in the colour of what it leaves.

    A force that no law describes may be small, but a mass without a spring adds it up twice: what is left then lies far
    above the sensor's noise, as smooth as the motion, and a law that bends takes its slowest part, which weighs most
    where all frequencies count alike, and adds to the rest. What a refit leaves is therefore taken as coloured noise,
    record by record: by the same, what was left before must be more. At the noise floor it is white, and nothing
    changes. Points of sweeps have no colour.
    """
    if before.plane is not None or before.passes is not None:
        return behind(after, before)
    white = []
    for k, own in enumerate(before.places):
        colour = _colour(before, k, after.left[own])
        both = colour.whiten(np.column_stack([after.left[own], before.left[own]]))
        both = both[min(colour.begins, len(both) // 2) :]  # before them the filter has not all that it predicts from
        white.append(both / (float(np.std(both[:, 0])) or 1.0))
    now, was = np.concatenate(white).T
    return behind(Left(now, after.numbers), Left(was, before.numbers))
