"""What each held-out level of a sweep says against a model, if one number of its own says the greater part of it.

A law that the model lacks makes a level, to first order, an oscillator of another resonance or of another damping
(N. Minorsky, Nonlinear Oscillations, 1962, ch. 14); a drive that is not what it is called does neither: far from the
resonance, where a response is drive over inertia or over stiffness, neither spring nor damper has a say. Which of the
three numbers a level asks for is therefore a hint at what is wrong, drive or law.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Literal, NamedTuple

import numpy as np

from ..campaign.record import Sweep, same_level
from ..model import FREQUENCY, QUALITY, Model
from ..response import Equation
from .carry_over import uncertain_steps
from .curve_reading import read_curves
from .curves import lay_curves
from .result import Fit

Kind = Literal["drive", "resonance", "quality"]
_KINDS: tuple[Kind, ...] = ("drive", "resonance", "quality")
_PLACE: dict[Kind, int] = {"resonance": FREQUENCY, "quality": QUALITY}

MISSED = 1.1  # error over noise: a floor is itself known to some ten per cent
_GREATER_PART = 0.5  # of what is left of a level beyond noise
_VERY_STRONG = 10.0  # of 2 ln of a likelihood ratio: by so much one number explains more than the two others
_RESONANCE = (
    "oscillator",
    "overdamped",
    "base",
    "shaken",
)  # forms of the linear part in which the places above hold one
_ROUNDS = 8
_FARTHEST = 0.3  # of the logarithm of a number, in one round
_SETTLED = 0.1  # of its error bar: a step that moves it no further is the last


class OwnNumber(NamedTuple):
    """A `level` (V) of a sweep, or of several that hold its ways up and down (`names`), which answers as if a number of
    the model were larger by `share` ± `error` there; its error over noise, and its rms error over its peak, as the
    model is and with that number."""

    names: tuple[str, ...]
    level: float
    kind: Kind
    share: float
    error: float
    over_noise: tuple[float, float]
    over_peak: tuple[float, float]


class _Found(NamedTuple):
    """A number: its logarithm, the error of that, and χ² with it."""

    kind: Kind
    logarithm: float
    error: float
    chi2: float


def own_numbers(fit: Fit) -> tuple[OwnNumber, ...]:
    """The held-out levels to which a number of their own says the greater part of what the model misses there, and
    clearly more than another one would; none where the errors of the parameters may be the reason, the model has no
    resonance, or does not even describe what was fitted."""
    model, values, found = fit.model, fit.values, []
    if model.form not in _RESONANCE or fit.fitted.error_over_noise > MISSED or not np.all(np.isfinite(fit.covariance)):
        return ()
    steps = uncertain_steps(fit)
    settled = [sweep for sweep in fit.campaign.heldout_sweeps if not sweep.fast]
    for level, own in _by_level(settled):
        before, expected, n = _missed(model, values, own, steps)
        # The square of one uncertain direction scatters: it is twice its standard error in one case of twenty.
        if not n * MISSED**2 + 4 * expected < before < np.inf:
            continue
        tried = sorted((_search(model, values, own, kind) for kind in _KINDS), key=lambda one: one.chi2)
        best, second = tried[:2]
        taken = before - best.chi2
        if not taken > max(_GREATER_PART * (before - n), _VERY_STRONG):
            continue
        if n * np.log(second.chi2 / best.chi2) < _VERY_STRONG:
            continue
        over_noise = float(np.sqrt(before / n)), float(np.sqrt(best.chi2 / n))
        over_peak = _over_peak(model, values, own), _over_peak(model, *_with(values, own, best.kind, best.logarithm))
        share = float(np.expm1(best.logarithm))
        error = best.error * max(over_noise[1], 1.0) * (1 + share)
        names = tuple(sweep.name for sweep in own)
        found.append(OwnNumber(names, level, best.kind, share, error, over_noise, over_peak))
    return tuple(found)


def _by_level(sweeps: Sequence[Sweep]) -> list[tuple[float, list[Sweep]]]:
    """The sweeps cut into levels, weakest first."""
    own = [(k, int(row)) for k, sweep in enumerate(sweeps) for row in range(len(sweep.frequency))]
    if not own:
        return []
    level = np.concatenate([sweep.level for sweep in sweeps])
    found = []
    for rows in same_level(level):
        parts = [sweep.only(np.array([own[i][1] for i in rows if own[i][0] == k], int))
                 for k, sweep in enumerate(sweeps)]  # fmt: skip
        found.append((float(np.median(level[rows])), [part for part in parts if len(part.frequency)]))
    return found


def _with(values: np.ndarray, sweeps: Sequence[Sweep], kind: Kind, logarithm: float) -> tuple[np.ndarray, list[Sweep]]:
    """Values and sweeps where a number is larger by a factor, of which this is the logarithm."""
    if kind == "drive":
        times = lambda sweep: sweep.acting / sweep.level * np.exp(logarithm)
        return values, [replace(sweep, stronger=times(sweep) - 1) for sweep in sweeps]
    changed = values.copy()
    changed[_PLACE[kind]] *= np.exp(logarithm)
    return changed, list(sweeps)


def _missed(model: Model, values: np.ndarray, sweeps: Sequence[Sweep], steps: np.ndarray) -> tuple[float, float, int]:
    """χ² of some sweeps, what steps (p, m) of the values would do to it, and how many numbers they have."""
    equation = Equation(model)
    curves = lay_curves(sweeps, model).weighed(equation, values)
    steady = curves.solve(equation, values)
    left = curves.residuals(steady)
    return float(left @ left), float(np.sum(curves.slopes(steady, steps) ** 2)), len(left)


def _search(model: Model, values: np.ndarray, sweeps: Sequence[Sweep], kind: Kind) -> _Found:
    """The best size of a number of the level's own, by Gauss-Newton steps."""
    equation, x = Equation(model), 0.0
    best = _Found(kind, 0.0, np.inf, np.inf)
    for _ in range(_ROUNDS):
        here, there = _with(values, sweeps, kind, x)
        curves = lay_curves(there, model).weighed(equation, here)
        steady = curves.solve(equation, here)
        left = curves.residuals(steady)
        if kind == "drive":
            slope = curves.rows(np.ones(len(curves.measured), complex))
        else:
            direction = np.zeros((1, len(values)))
            direction[0, _PLACE[kind]] = here[_PLACE[kind]]
            slope = curves.slopes(steady, direction)[0]
        weight, chi2 = float(slope @ slope), float(left @ left)
        if not (weight > 0 and np.isfinite(chi2)):
            break
        if chi2 < best.chi2:
            best = _Found(kind, x, 1 / np.sqrt(weight), chi2)
        step = -float(slope @ left) / weight
        x += float(np.clip(step, -_FARTHEST, _FARTHEST))
        if abs(step) * np.sqrt(weight) < _SETTLED:
            break
    return best


def own_drive(model: Model, values: np.ndarray, sweeps: Sequence[Sweep]) -> tuple[float, float]:
    """Logarithm of the drive that acted in some sweeps over the one that they tell, and its error in noise floors."""
    found = _search(model, values, sweeps, "drive")
    return found.logarithm, found.error


def _over_peak(model: Model, values: np.ndarray, sweeps: Sequence[Sweep]) -> float:
    """Rms error of the points on the right branch, over the peak."""
    scores = [curve.score for curve in read_curves(model, values, sweeps)]
    n = np.array([score.n for score in scores], float)
    squares = float(n @ [score.rmse**2 for score in scores]) / max(float(np.sum(n)), 1.0)
    return float(np.sqrt(squares)) / max(float(np.max(sweep.amplitude)) for sweep in sweeps)
