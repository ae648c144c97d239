"""What the drive of a linear model may be besides a smooth curve that pushes: one that is held, or moves a base.

- A converter holds its value until the next one, a switch is open or closed (`campaign.held_drive`). Where the edges
  lie no sample tells: on the clock of the samples, or, where the drive itself jumps, anywhere between two.
- What is shaken at its base is pushed by its spring and by its damper, k u + c u̇, where the motion u of the base was
  recorded and not its acceleration; and what else acts between the two sees their distance (`forms.OnBase`). Where both
  are accelerations the sensor rides on the body and reads the base's acceleration too (`forms.Shaken`).

Each is linear physics, but a hidden effect is late or early, too. Of drives that jump, and where one is the
displacement of a base, or its acceleration beside that of the body, the criterion decides alone; else, and of smooth
drives beside those that jump, what these forms explain must be the greater part of what is left without them, as with
further modes.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy import optimize

from ...campaign.held_drive import Edges
from ...units import LENGTH, find_unit
from .candidate import Candidate
from .forms import FORMS
from .rows import Kind, fitted, solve
from .stretches import Stretch

_EDGES = (-0.5, 0.0, 1.0)  # where searches for the edges begin: measured, on the samples, one late
_EARLIEST, _LATEST = -1.0, 2.0  # no sample shows what is to come; and what is later is a lag, and no matter of edges
_NEAR = 0.01  # of a sampling interval, to the latest edge: it then lies nowhere
_NEARBY = 8.0  # times the frequency, quality or decay time beside a smooth drive: so far the search may go
_STEPS = (0.01, 0.1, 0.2)  # first steps in ln of frequency and quality, or of a decay time, and of the edge


def held(stretches: Sequence[Stretch], one: Candidate, free: Sequence[bool], jumping: bool) -> list[Candidate]:
    """The candidate with drives that are held instead of smooth: edges on the samples, or best where they jump.

    **Arguments:** `free`: of which records the drive may be.
    """
    form = FORMS[one.form]
    kind, start = Kind(one.form, one.level, form), np.log(form.point(one.first, one.second))
    low = np.log(np.maximum(form.least, np.exp(start) / _NEARBY))
    high = np.log(np.minimum(form.most, np.exp(start) * _NEARBY))

    def best(starts: Sequence[float]) -> Candidate:
        trials = []
        for edge in starts:
            fixed = len(starts) == 1
            at = np.append(start, [] if fixed else [edge])
            kept = lambda x, edge=edge, fixed=fixed: with_edge(stretches, free, edge if fixed else float(x[-1]))
            misfit = lambda x, kept=kept: solve(kept(x), kind, np.exp(x[: len(start)]))[0]
            steps = np.diag([*_STEPS[: len(start)], *([] if fixed else [_STEPS[-1]])])
            bounds = [*zip(low, high, strict=True), *([] if fixed else [(_EARLIEST, _LATEST)])]
            found = optimize.minimize(
                misfit, at, method="Nelder-Mead", bounds=bounds,
                options={"initial_simplex": np.vstack([at, at + steps]), "xatol": 1e-4, "fatol": 1e-9, "maxiter": 150},
            )  # fmt: skip
            trials.append((float(found.fun), tuple(found.x), edge if fixed else float(found.x[-1])))
        _, x, edge = min(trials)
        point = form.told(np.exp(np.array(x[: len(start)])), stretches)
        there = fitted(with_edge(stretches, free, edge), kind, point)
        return there._replace(edges=Edges(edge), numbers=there.numbers + (len(starts) > 1))

    if not jumping:
        return [best([0.0])]
    found = best(_EDGES)
    edge = found.edges.first
    return [best([0.0]), found] if edge is not None and edge < _LATEST - _NEAR else []


def with_edge(stretches: Sequence[Stretch], free: Sequence[bool], edge: float | None) -> list[Stretch]:
    """The records with other drives between the samples, where they do not say what it is."""
    return [p._replace(edge=edge, sums={}) if own else p for p, own in zip(stretches, free, strict=True)]


def is_acceleration(unit: str) -> bool:
    """Whether a drive in this unit is the acceleration of a base."""
    found = find_unit(unit)
    return found is not None and found.dimension == (1, 0, -2, 0, 0, 0, 0)


def is_length(unit: str) -> bool:
    """Whether a drive in this unit is the displacement of a base."""
    found = find_unit(unit)
    return found is not None and found.dimension == LENGTH
