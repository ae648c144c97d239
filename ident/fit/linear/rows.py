"""What gain, lead and constant do to readings under a linear form, and the best of them."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from .candidate import Candidate
from .forms import Form
from .modes import solved
from .stretches import Stretch


class Kind(NamedTuple):
    """Which numbers a candidate has: those of its `form`, None of one without inertia, a gain unless its `name` is
    "constant", a constant if `level`, and a `lead` of its drive."""

    name: str
    level: bool
    form: Form | None = None
    lead: bool = False


def fitted(stretches: Sequence[Stretch], kind: Kind, point: np.ndarray | None = None) -> Candidate:
    """The candidate of a kind at the trial `point` of its form."""
    left, found = solve(stretches, kind, point)
    drive = int(kind.name != "constant" and any(stretch.driven for stretch in stretches))
    lead = int(kind.lead and bool(drive))
    numbers = drive + lead + kind.level + (0 if point is None else len(point))
    gain = float(found[0]) if drive else 0.0
    time = float(found[1]) / gain if lead and gain else 0.0
    constant = float(found[drive + lead]) if kind.level else 0.0
    one = Candidate(kind.name, kind.level, left, numbers, gain=gain, constant=constant, lead=time)
    if point is None or kind.form is None:
        return one
    first, second = kind.form.parameters(point, stretches)
    return one._replace(first=first, second=second)


def solve(stretches: Sequence[Stretch], kind: Kind, point: np.ndarray | None) -> tuple[float, np.ndarray]:
    """(rms left over rms of the signal, gain, gain times lead and constant)."""
    rows, targets = rows_of(stretches, kind, point)
    if not math.isfinite(float(np.linalg.norm(rows))):
        return 1e9, np.zeros(rows.shape[1])
    found, rest = solved(rows, targets)
    return math.sqrt(float(rest @ rest) / sum(stretch.power for stretch in stretches)), found


def rows_of(stretches: Sequence[Stretch], kind: Kind, point: np.ndarray | None) -> tuple[np.ndarray, np.ndarray]:
    """What gain, lead and constant do to the readings (n, 1 to 3), and the readings (n,), free motions taken out of
    both."""
    driven = any(stretch.driven for stretch in stretches) and kind.name != "constant"
    rows, targets = [], []
    for stretch in stretches:
        one = np.ones_like(stretch.response)
        pushes = [stretch.drive, *([stretch.rate] if kind.lead else [])] if driven else []
        columns = [*pushes, *([one] if kind.level else [])]
        if kind.form is not None and point is not None:
            answer = lambda push, point=point, stretch=stretch, form=kind.form: form.answer(point, stretch, push)
            columns = [answer(push) for push in pushes]
            columns += [answer(one) if kind.form.name == "no-spring" else one] if kind.level else []
        stacked = np.stack([*(c / stretch.size for c in columns), stretch.response], axis=1)
        if kind.form is not None and point is not None and not stretch.rest:
            basis, _ = np.linalg.qr(kind.form.free(point, stretch))
            stacked = stacked - basis @ (basis.T @ stacked)
        rows.append(stacked[:, :-1])
        targets.append(stacked[:, -1])
    return np.concatenate(rows), np.concatenate(targets)
