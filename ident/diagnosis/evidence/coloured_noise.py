"""Could noise alone have done it? Tests for rich sets of functions, which follow slow noise as readily as an effect,
and for what a refit has gained.

Source: P. J. Brockwell, R. A. Davis, Time Series: Theory and Methods, 1991, §8.1 (prewhitening).
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from scipy.special import fdtrc

from ...campaign.noise.recursive import convolved
from ..linearised.whiten import prediction_filter
from .criterion import Left, Weighed, behind

if TYPE_CHECKING:
    from ..linearised.regression import Regression

_SMALL = 1.5  # χ² per sample up to which the residual may be noise of a colour that the noise floor does not have


def chance(regression: Regression, basis: np.ndarray, tried: int) -> float:
    """Probability of such a fall of χ² by chance, the colour of what is left taken into account.

    What remains after the candidate is modelled as autoregressive noise of order 12, record by record; candidate and
    residual are whitened with it and the F test is made there.
    """
    left = regression.residual - basis @ (basis.T @ regression.residual)
    y, x = [], []
    for own in regression.places:
        part = left[own]
        taps = prediction_filter(part[None])
        size = float(np.std(convolved(taps, part))) or 1.0
        y.append(convolved(taps, regression.residual[own]) / size)
        x.append(convolved(taps, basis[own]) / size)
    target, regressors = np.concatenate(y), np.concatenate(x)
    q, _ = np.linalg.qr(regressors)
    drop = float(np.sum((q.T @ target) ** 2))
    freedom = regression.n - tried - regression.absorbed.shape[1]
    rest = (float(target @ target) - drop) / freedom
    return float(fdtrc(tried, freedom, drop / tried / max(rest, 1e-300)))


def behind_in_colour(after: Weighed, before: Regression) -> float:
    """By how much the criterion of a refit is worse than that of the fit before, in the colour of what it leaves.

    A force that no law describes may be small, but a mass without a spring adds it up twice: what is left then lies far
    above the sensor's noise, as smooth as the motion, and a law that bends takes its slowest part, which weighs most
    where all frequencies count alike, and adds to the rest. What a refit leaves is therefore taken as autoregressive
    noise of order 12, record by record: by the same, what was left before must be more. At the noise floor it is white,
    and nothing changes. Points of sweeps have no colour.
    """
    if before.plane is not None:
        return behind(after, before)
    white = []
    for own in before.places:
        taps = prediction_filter(after.left[own][None])
        both = convolved(taps, np.column_stack([after.left[own], before.left[own]]))
        both = both[min(len(taps), len(both) // 2) :]  # before them the filter has not all that it predicts from
        white.append(both / (float(np.std(both[:, 0])) or 1.0))
    now, was = np.concatenate(white).T
    return behind(Left(now, after.numbers), Left(was, before.numbers))


def chance_of(regression: Regression, basis: np.ndarray) -> float:
    """Probability of such a fall of χ² by chance.

    A small misfit is first supposed to be noise throughout, and everything is whitened by its own colour; a large one
    cannot be, and only what the functions leave is (`chance`).

    **Arguments:** `basis` (n, dof), orthonormal.
    """
    if regression.chi2 > _SMALL * regression.n:
        return chance(regression, basis, basis.shape[1])
    y: list[np.ndarray] = []
    x: list[np.ndarray] = []
    for own in regression.places:
        part = regression.residual[own]
        taps = prediction_filter(part[None])
        both = np.column_stack([part, basis[own]])
        white = convolved(taps, both)
        white = white / (float(np.std(white[:, 0])) or 1.0)
        y.append(white[:, 0])
        x.append(white[:, 1:])
    target = np.concatenate(y)
    q, _ = np.linalg.qr(np.concatenate(x))
    drop = float(np.sum((q.T @ target) ** 2))
    freedom = regression.n - basis.shape[1] - regression.absorbed.shape[1]
    rest = max((float(target @ target) - drop) / freedom, 1e-300)
    return float(fdtrc(basis.shape[1], freedom, drop / basis.shape[1] / rest))
