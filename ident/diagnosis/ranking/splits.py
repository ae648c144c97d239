"""Starts in which a memory takes over a part of what the linear spring had absorbed.

A spring with memory is a spring first: a linear fit gives its stiffness to the resonance, and from there a refit finds
no way to give it back. Each start leaves the linear part a share of its stiffness and lets the effect carry the rest,
so that the motion is the same to first order; the damping changes by what the effect dissipates on that motion.
"""

from __future__ import annotations

import itertools

import numpy as np

from ...model import FREQUENCY, QUALITY, Model
from ...response import Equation
from ..linearised.columns import Terms, contributions, no_histories
from ..linearised.regression import Regression

_SHARES = (0.3, 0.6)  # of the stiffness, taken over
_LEAST_DAMPING = 0.1  # of the linear part's: what is left to it at the least


def takes_over(model: Model) -> bool:
    """Whether the last effect of a model is a force with a memory of the motion."""
    effect = model.effects[-1]
    return effect.overrides("force") and bool(effect.state0()) and not effect.needs


def split_starts(regression: Regression, model: Model, base: np.ndarray) -> list[np.ndarray]:
    """Starts (m,) SI of a model whose last effect carries a part of the stiffness, over its whole grid.

    **Arguments:** `base`: values of the parameters before that effect's.
    """
    effect, scales = model.effects[-1], regression.fit.scales
    declared = effect.declared()
    size = next((i for i, p in enumerate(declared) if p.kind == "amplitude" and p.fitted), None)
    if size is None or not regression.trajectories.tape.spans:  # a memory is seen on the motion of traces
        return []
    axes = [(0.0,) if p.kind == "amplitude" else [g * getattr(scales, p.scale) for g in p.grid] for p in declared]
    points = np.array([np.concatenate([base, point]) for point in itertools.product(*axes)])
    taken_by = len(base) + size
    mass = model.mass_of(base)
    stiffness, damping = model.spring_and_damper(base[FREQUENCY], base[QUALITY], mass)
    if not stiffness > 0:
        return []
    starts = []
    for point, (spring, damper) in zip(points, _likeness(regression, model, points, taken_by), strict=True):
        for share in _SHARES if np.isfinite(spring) and spring > 0 else ():
            start = point.copy()
            start[taken_by] = share * stiffness / spring
            left = max(damping - start[taken_by] * damper, _LEAST_DAMPING * damping)
            start[FREQUENCY] = base[FREQUENCY] * np.sqrt(1 - share)
            start[QUALITY] = 2 * np.pi * start[FREQUENCY] * mass / left
            starts.append(start)
    return starts


def _likeness(regression: Regression, model: Model, values: np.ndarray, size: int) -> list[tuple[float, float]]:
    """Stiffness (N/m) and damping (N s/m) that the effect looks like on the measured motion, per unit of the parameter
    at position `size`, for each set of `values` (k, m)."""
    trajectories = regression.trajectories
    along = np.eye(values.shape[1])[[size]]
    gram, right = np.zeros((2, 2)), np.zeros((2, len(values)))
    equation = Equation(model)
    rest = no_histories(equation, len(values), trajectories.tape)
    pushed = contributions(
        Terms(equation, False), trajectories.tape, values, along, trajectories.moved, trajectories.seen, rest
    )
    for (force, _), motion in zip(pushed, trajectories.moved, strict=True):
        moved = np.stack([np.ravel(motion.z), np.ravel(motion.v)])
        gram += moved @ moved.T
        right += moved @ np.moveaxis(force, 1, 2).reshape(-1, len(values))
    unit = np.sqrt(np.diag(gram))
    found = -np.linalg.solve(gram / np.outer(unit, unit), right / unit[:, None]) / unit[:, None]
    return [(float(spring), float(damper)) for spring, damper in found.T]
