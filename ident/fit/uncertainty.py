"""Covariance of the fitted parameters, with a reason wherever it cannot be given.

The fit weighs every sample by 1/σ. Noise that is correlated in time makes neighbouring samples say the same thing
twice, so the covariance is the sandwich (JᵀJ)⁻¹ Jᵀ R J (JᵀJ)⁻¹ with R the correlation of the noise; for white noise
R = 1.
Initial states are eliminated record by record (a Schur complement).

Source: H. White, Asymptotic Theory for Econometricians, 2001, §4.2; C. R. Rao, Linear Statistical Inference, 1973, §4a.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from ..campaign.noise.autoregression import variance_of
from ..campaign.noise.recursive import recursive_filter
from ..campaign.record import NoiseFloor, Trace
from .problem import Data, Evaluation


class Linearisation(NamedTuple):
    """The fit seen as a linear regression, after the initial states are projected out.

    **Arguments:** `jacobian`, (n, p), `residual`, (n,), both in units of the noise floor, counted samples only;
    `spread`, (p, p), the matrix Jᵀ R J of the noise.
    """

    jacobian: np.ndarray
    residual: np.ndarray
    spread: np.ndarray


def linearise(found: Evaluation, data: Data, records: Sequence[Trace]) -> Linearisation:
    """Collect the Jacobian of all records, initial states projected out, and the spread that their noise causes."""
    rows, residuals = [], []
    p = len(found.by_x)
    spread = np.zeros((p, p))
    for record, own, unit in zip(records, data.tape.slices, data.start_scale, strict=True):
        counted = slice(own.start + record.skip, own.stop)
        jacobian, residual = found.by_x[:, counted].T, found.residuals[counted]
        if np.any(unit):
            basis = told_by_start(found.by_start[:, counted])
            jacobian = jacobian - basis @ (basis.T @ jacobian)
            residual = residual - basis @ (basis.T @ residual)
        rows.append(jacobian)
        residuals.append(residual)
        spread += _spread(jacobian, record.noise)
    jacobian = found.by_x[:, data.tape.samples :].T  # of the sweeps, in units of their own white noise
    rows.append(jacobian)
    residuals.append(found.residuals[data.tape.samples :])
    spread += jacobian.T @ jacobian
    return Linearisation(np.concatenate(rows), np.concatenate(residuals), spread)


def told_by_start(rows: np.ndarray) -> np.ndarray:
    """What an initial state may add to a record, (n, q) orthonormal, from the derivatives (s, n) by it in units in
    which it is about one; what stays below a noise floor in all the record is none of it."""
    u, s, _ = np.linalg.svd(rows.T, full_matrices=False)
    return u[:, s > 1.0]


@np.errstate(over="ignore", invalid="ignore")
def _spread(jacobian: np.ndarray, noise: NoiseFloor) -> np.ndarray:
    """Jᵀ R J: filter every column with the noise's own shape, scaled to unit variance."""
    if not noise.ar:
        return jacobian.T @ jacobian
    # Running the shaping filter backwards over a column gives Aᵀ J, where A A ᵀ = R is the filter's own covariance.
    denominator = np.concatenate([[1.0], -np.asarray(noise.ar)])
    gain = 1.0 / np.sqrt(variance_of(np.asarray(noise.ar), 1.0))
    shaped = recursive_filter(np.array([gain]), denominator, jacobian[::-1])
    return shaped.T @ shaped


class Covariance(NamedTuple):
    """Covariance of the unbounded coordinates and what it leaves undetermined.

    **Arguments:**

    - `matrix`: (p, p), the null directions left out.
    - `null`: (p, k) unit vectors (in coordinates scaled to unit columns of J) along which the data say nothing.
    - `lengths`: (p,) column lengths of J by which the coordinates were scaled.
    - `singular_values`: of the scaled Jacobian, largest first; `directions`: (p, p) the matching right vectors,
      columns.
    """

    matrix: np.ndarray
    null: np.ndarray
    lengths: np.ndarray
    singular_values: np.ndarray
    directions: np.ndarray


# Below this ratio to the largest singular value the Jacobian's own rounding and step errors decide, not the data.
_NULL = 1e-6


@np.errstate(over="ignore", invalid="ignore")  # of a motion that hardly has a bound nothing is known
def covariance(linear: Linearisation, prior_weight: np.ndarray) -> Covariance:
    """Covariance matrix of the fitted coordinates; `prior_weight` (p,) is 1/deviation in the same coordinates."""
    if not len(prior_weight):  # every parameter is held
        return Covariance(np.zeros((0, 0)), np.zeros((0, 0)), np.zeros(0), np.zeros(0), np.zeros((0, 0)))
    gram = linear.jacobian.T @ linear.jacobian + np.diag(prior_weight**2)
    lengths = np.sqrt(np.diag(gram))
    safe = np.where(lengths > 0, lengths, 1.0)
    stacked = np.concatenate([linear.jacobian, np.diag(prior_weight)]) / safe
    _, singular, vt = np.linalg.svd(np.linalg.qr(stacked, mode="r"))
    seen = singular > _NULL * singular[0]
    v = vt[seen].T / singular[seen] ** 2
    inverse = v @ vt[seen]
    middle = (linear.spread + np.diag(prior_weight**2)) / np.outer(safe, safe)
    matrix = inverse @ middle @ inverse / np.outer(safe, safe)
    return Covariance(matrix, vt[~seen].T, lengths, singular, vt.T)
