"""The model that a refit of a candidate fits, values from which it may start, and whether what it ends in can be."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from functools import lru_cache

import numpy as np

from ...effects.effect import AbstractEffect
from ...fit import Fit
from ...fit.linear.guess import DataScales
from ...fit.linear.one_tone import with_quality
from ...model import FREQUENCY, QUALITY, Model, make_effect
from ..linearised.regression import Regression
from .weigh import Candidate

_OFF_BOUND = 3.0  # times a quality factor at its bound, where a refit would have no slope to leave it by
_FAINT = 0.01  # of what the score predicts: nearly absent, so that the motion is the one without it
_OTHERWISE = -0.3  # of what the score predicts, where its sign may be wrong and its size too large, as in `balance`
_FREED = 5  # points of earlier shapes from which a refit starts too
_ABSENT = 0.05  # of an effect's largest amplitude: a smaller one is as good as none


def with_effect(before: Fit, effect: type[AbstractEffect], words: Mapping[str, str] | None = None) -> Model:
    """The model of a fit with one effect more; `words` as of `make_effect`.

    A quality factor that had to be held, for a steady sine does not determine it, is free beside the effect, as it is
    in the scores: a wrong one would make another effect of it.
    """
    free = with_quality(before.model)
    return free + make_effect(before.campaign, effect.name, {effect.name: effect}, words)


def without_unseen(model: Model, candidate: Candidate | None) -> Model:
    """The model with those amplitudes of its last effect held that no record shows: a search would take them wherever
    the error of the solver leads."""
    unseen = frozenset() if candidate is None else candidate.unseen
    return (
        replace(model, held=model.held | {f"{model.effects[-1].name}.{name}" for name in unseen}) if unseen else model
    )


def base_of(regression: Regression) -> np.ndarray:
    """The values from which a refit starts: the fit's own, its quality factor off the bound to which it may have bent.

    At a bound a parameter has no slope that could lead it back.
    """
    values = regression.fit.values.copy()
    if "at-bound" in regression.fit.estimates[QUALITY].flags:
        values[QUALITY] *= _OFF_BOUND
    return values


def start_of(model: Model, candidate: Candidate | None, scales: DataScales) -> np.ndarray:
    """Parameters of the model's last effect as scored, or as declared if the score saw nothing; an amplitude that
    cannot be negative starts small instead."""
    effect = model.effects[-1]
    declared = {p.name: p for p in effect.declared()}
    known = {} if candidate is None else candidate.values
    values = []
    for p in effect.parameters:
        value = known.get(p.name, p.default * getattr(scales, p.scale))
        if declared[p.name].positive and value <= 0:
            value = abs(candidate.errors.get(p.name, value)) if candidate is not None else 0.0
            value = value or p.default or 1e-3
        elif declared[p.name].one_sided:
            value = max(value, 0.0)
        values.append(value)
    return np.array(values)


def nearly_absent(candidate: Candidate, model: Model) -> Candidate:
    """A candidate that is nearly absent."""
    amplitudes = {p.name for p in model.effects[-1].declared() if p.kind == "amplitude"}
    faint = {name: _FAINT * value for name, value in candidate.values.items() if name in amplitudes}
    return candidate._replace(values={**candidate.values, **faint})


def mirrored(candidate: Candidate, model: Model) -> Candidate:
    """A candidate with smaller amplitudes of the other sign."""
    either = {p.name for p in model.effects[-1].declared() if p.kind == "amplitude" and not (p.one_sided or p.positive)}
    return candidate._replace(
        values={name: _OTHERWISE * value if name in either else value for name, value in candidate.values.items()}
    )


def shapes_of(model: Model, before: Fit) -> list[tuple[int, float]]:
    """Position and value of the shapes of earlier effects at the points of their grids, a few of all."""
    points = [
        (i, g * getattr(before.scales, p.scale))
        for i, p in enumerate(model.parameters[: len(before.values)])
        if p.kind == "shape" and p.fitted and len(p.grid) > 1
        for g in p.grid
    ]
    return points[:: max(-(-len(points) // _FREED), 1)]


def with_one(values: np.ndarray, index: int, value: float) -> np.ndarray:
    """Parameters (m,) with one of them at another value."""
    changed = values.copy()
    changed[index] = value
    return changed


def begins_as_it_may(model: Model, start: np.ndarray) -> bool:
    """Whether a start has an amplitude of one sign on its side.

    What cannot be may fit as well as what can, where another shape goes with the other sign, as a wall above the stage
    and one below it.
    """
    effect = model.effects[-1]
    sizes = start[len(start) - len(effect.parameters) :]
    return any(p.one_sided and size > 0 for p, size in zip(effect.declared(), sizes, strict=True))


def is_possible(model: Model, values: np.ndarray, effect: AbstractEffect, scales: DataScales) -> bool:
    """Whether an effect of a model has signs that physics allows, no value beyond its limits, and can be beside the
    linear part.

    A side of a stop that is about absent may have either. A stop that pulls bends the curve of another law, and a
    friction that drives makes good what another takes too much: neither is there.
    """
    own = dict(zip((p.name for p in model.parameters), values, strict=True))
    for p in effect.declared():
        if p.limits and not p.positive:  # of a positive one a fit keeps inside
            share = own[f"{effect.name}.{p.name}"] / getattr(scales, p.scale)
            if not p.limits[0] <= share <= p.limits[1]:
                return False
    spring, damper = model.spring_and_damper(values[FREQUENCY], values[QUALITY], model.mass_of(values))
    there = effect.with_values(**{p.name: own[f"{effect.name}.{p.name}"] for p in effect.parameters})
    if not there.can_be(float(spring), float(damper)):
        return False
    sizes = [own[f"{effect.name}.{p.name}"] for p in effect.declared() if p.one_sided]
    return not sizes or min(sizes) >= -_ABSENT * max(map(abs, sizes))


def refinements(effect: AbstractEffect | type[AbstractEffect]) -> frozenset[str]:
    """The numbers of an effect that only refine its law, as a model calls them."""
    return frozenset(f"{effect.name}.{p.name}" for p in effect.parameters if p.refines)


@lru_cache
def all_free(effect: type[AbstractEffect]) -> type[AbstractEffect]:
    """An effect with what refines its law free, to be scored with it."""
    own = {p.name: replace(p, fitted=True) for p in effect.parameters if p.refines}
    free = type(effect.__name__, (effect,), {"__module__": effect.__module__, "__doc__": effect.__doc__, **own})
    free.parameters = tuple(own.get(p.name, p) for p in effect.parameters)  # as the law itself has them
    return free
