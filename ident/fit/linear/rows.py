"""What gain and constant do to readings under a linear form, and the best of them."""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import partial
from typing import NamedTuple

import numpy as np
from scipy import optimize

from .candidate import Candidate
from .forms import Form
from .modes import solved
from .stretches import Stretch

_BEYOND = 8.0  # times the range of the grid: so far the search may go


class Kind(NamedTuple):
    """Which numbers a candidate has: those of its `form`, None of one without inertia, a gain unless its `name` is
    "constant", and a constant if `level`."""

    name: str
    level: bool
    form: Form | None = None


def fitted(stretches: Sequence[Stretch], kind: Kind, point: np.ndarray | None = None) -> Candidate:
    """The candidate of a kind at the trial `point` of its form."""
    left, found = solve(stretches, kind, point)
    drive = int(kind.name != "constant" and any(stretch.driven for stretch in stretches))
    numbers = drive + kind.level + (0 if point is None else len(point))
    gain = float(found[0]) if drive else 0.0
    constant = float(found[drive]) if kind.level else 0.0
    one = Candidate(kind.name, kind.level, left, numbers, gain=gain, constant=constant)
    if point is None or kind.form is None:
        return one
    first, second = kind.form.parameters(point, stretches)
    return one._replace(first=first, second=second)


def searched(stretches: Sequence[Stretch], kind: Kind, start: tuple[float, float] | None) -> Candidate:
    """The best of a kind: over the grid of its form, then by Nelder and Mead from the two best points."""
    assert kind.form is not None
    form, grid = kind.form, kind.form.grid(stretches)
    misfit = lambda x: solve(stretches, kind, np.exp(x))[0]
    trials = sorted(
        ((misfit(np.log(point)), tuple(np.log(point))) for point in [*grid, *([start] if start else [])]),
    )
    low, high = np.min(grid, axis=0) / _BEYOND, np.max(grid, axis=0) * _BEYOND
    bounds = np.log([np.maximum(low, form.least), np.minimum(high, form.most)])
    best = trials[0]
    for _, x in trials[:2]:
        steps = np.eye(len(x)) * np.array([0.03, 0.4])[: len(x)]
        simplex = np.clip(np.vstack([x, np.asarray(x) + steps]), *bounds)
        options = {"initial_simplex": simplex, "xatol": 1e-5, "fatol": 1e-10, "maxiter": 100}
        at = optimize.minimize(misfit, simplex[0], method="Nelder-Mead", bounds=bounds.T, options=options)
        best = min(best, (float(at.fun), tuple(at.x)))
    return fitted(stretches, kind, form.told(np.exp(np.array(best[1])), stretches))


def solve(stretches: Sequence[Stretch], kind: Kind, point: np.ndarray | None) -> tuple[float, np.ndarray]:
    """(rms left over rms of the signal, gain and constant)."""
    rows, targets = rows_of(stretches, kind, point)
    if not math.isfinite(float(np.linalg.norm(rows))):
        return 1e9, np.zeros(rows.shape[1])
    found, rest = solved(rows, targets)
    return math.sqrt(float(rest @ rest) / sum(stretch.power for stretch in stretches)), found


def rows_of(stretches: Sequence[Stretch], kind: Kind, point: np.ndarray | None) -> tuple[np.ndarray, np.ndarray]:
    """What gain and constant do to the readings (n, 1 or 2), and the readings (n,), free motions taken out of both."""
    driven = any(stretch.driven for stretch in stretches) and kind.name != "constant"
    rows, targets = [], []
    for stretch in stretches:
        one = np.ones_like(stretch.response)
        columns = [*([stretch.drive] if driven else []), *([one] if kind.level else [])]
        if kind.form is not None and point is not None:
            answer = partial(kind.form.answer, point, stretch)
            columns = [answer(stretch.push)] if driven else []
            if kind.level:
                columns.append(answer(np.ones_like(stretch.push)) if kind.form.name == "no-spring" else one)
        stacked = np.stack([*(c / stretch.size for c in columns), stretch.response], axis=1)
        if kind.form is not None and point is not None and not stretch.rest:
            basis, _ = np.linalg.qr(kind.form.free(point, stretch))
            stacked = stacked - basis @ (basis.T @ stacked)
        rows.append(stacked[:, :-1])
        targets.append(stacked[:, -1])
    return np.concatenate(rows), np.concatenate(targets)
