"""What another initial state would do to a record, and whether it does not begin as it is said to begin: what a free
start would take of what is left."""

from __future__ import annotations

import numpy as np

from ..response import respond
from .result import Fit

_GREATER_PART = 0.5  # of what is left of a record beyond noise
_CLEAR = 20.0  # of χ²: 10 of ln of a likelihood ratio


def taken_by_starts(fit: Fit) -> float:
    """χ² beyond noise that other starts would take of a model's misfit, where they are hinted at."""
    excess = {score.name: score.n * (score.error_over_noise**2 - 1) for score in fit.scores}
    return sum(share * excess[name] for name, share in fit.begun_otherwise)


def mostly_starts(fit: Fit) -> bool:
    """Whether other starts than are claimed would take the greater part of what a model leaves in all."""
    return taken_by_starts(fit) > _GREATER_PART * max(fit.fitted.chi2 - fit.fitted.n, 1e-9)


def start_rows(fit: Fit) -> np.ndarray:
    """Derivatives of the residuals, (s, samples), by the initial state of each sample's own record in units of its
    likely size, of records that are steady too; meaningless where a record starts at rest."""
    static, data, _, found = fit.solved
    if not data.steady:
        return found.by_start
    units = data.start_scale.copy()
    for one in data.steady:
        units[one.record] = one.unit
    kicks = np.swapaxes(units[:, :, None] * np.eye(units.shape[1]), 0, 1)
    still = np.zeros((len(kicks), len(found.values)))
    there = respond(static.equation, data.tape, found.values, found.starts, still, kicks)
    moved = data.beside_zeros(there.slopes) * data.weight
    return np.where(np.isfinite(moved), moved, 0.0)


def begun_otherwise(fit: Fit) -> list[tuple[str, float]]:
    """Records that are said to begin at rest, or steady, and the share of their misfit beyond noise that the motion of
    another displacement and velocity at the first sample takes, where that is the greater part.

    The score statistic of two numbers a record, beside the parameters of the model: r ≈ J dx + K ds with the readings'
    derivatives J by the fitted parameters and K by the start. What dx takes by itself, or moves from one record to
    another, is no start's. A hint and no proof: a force that sets in with the record moves it too.
    """
    static, data, _, found = fit.solved
    records = fit.campaign.fitted
    claimed = [k for k, unknown in enumerate(np.any(data.start_scale, axis=1)) if not unknown]
    if not claimed:
        return []
    begin = found.starts
    kicks = np.zeros((2, *begin.shape))
    for k in range(2):
        kicks[k, claimed, k] = 1.0
    moved = respond(static.equation, data.tape, found.values, begin, np.zeros((2, len(found.values))), kicks)
    columns = data.beside_zeros(moved.slopes) * data.weight
    columns = columns / np.maximum(np.linalg.norm(columns, axis=1, keepdims=True), 1e-300)
    samples = columns.shape[1]
    own = np.zeros((2 * len(claimed), samples))
    for i, record in enumerate(claimed):
        own[2 * i : 2 * i + 2, data.tape.slices[record]] = columns[:, data.tape.slices[record]]
    left = found.residuals[:samples]
    basis = np.concatenate([found.by_x[:, :samples], own]).T
    if not (np.all(np.isfinite(basis)) and np.all(np.isfinite(left))):
        return []
    parameters = basis[:, : len(found.by_x)]
    left = left - parameters @ np.linalg.lstsq(parameters, left, rcond=1e-10)[0]
    better, told = left - basis @ np.linalg.lstsq(basis, left, rcond=1e-10)[0], []
    whole = float(left @ left - better @ better)
    for record in claimed:
        part = data.tape.slices[record]
        before, after = float(left[part] @ left[part]), float(better[part] @ better[part])
        fall = min(before - after, whole)
        share = fall / max(before - np.count_nonzero(data.weight[part]), 1e-9)
        if share > _GREATER_PART and fall > _CLEAR:
            told.append((records[record].name, min(share, 1.0)))
    return told
