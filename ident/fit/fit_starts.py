"""The initial states alone that fit best, with the parameters as they are."""

from __future__ import annotations

import math

import numpy as np

from .judge import GOOD
from .problem import Data, Evaluation, Static, Unknowns, evaluate

_ROUNDS = 8  # at most
_STILL = 1e-7  # of the largest displacement and velocity
_LEAST = 1 / 16  # of a step: a shorter one gains nothing
_PARTS = (1 / 64, 1 / 16, 1 / 4, 1.0)  # of a record, one after the other


@np.errstate(over="ignore", invalid="ignore")  # a motion without bound has no scale
def fit_starts(
    static: Static, data: Data, unknowns: Unknowns, rounds: int = _ROUNDS, enough: float = 0.0
) -> tuple[Unknowns, Evaluation]:
    """Gauss–Newton on the initial states alone, in so many rounds at most; they enter almost linearly, but where a loop
    remembers them: steps that gain nothing are halved. Never worse than where it began; the model there too.

    `enough`: share of the cost that is not worth another round.
    """
    best, kept, share = unknowns, evaluate(static, data, unknowns), 1.0
    for _ in range(rounds):
        light = np.where(np.arange(data.start_scale.shape[1]) < 2, 1e-6, data.misfit_of(kept))
        least = _cost(kept, best, light)
        steps, promised = _steps(data, kept, best, light)
        if steps is None or share * np.max(np.abs(steps), initial=0.0) < _STILL or promised < enough * least:
            break
        trial = Unknowns(best.x, best.starts - share * steps)
        found = evaluate(static, data, trial)
        cost = _cost(found, trial, light)
        if cost < least:
            best, kept, share = trial, found, 1.0
        elif (share := share / 4) < _LEAST:
            break
    return best, kept


def fit_starts_of_others(
    static: Static, data: Data, unknowns: Unknowns, enough: float = 0.0
) -> tuple[Unknowns, Evaluation]:
    """As `fit_starts`, of records that the parameters have not seen: what still misses one is fitted once more from
    its beginning on, in parts that grow.

    The rhythm of a motion that bends goes with its size: a start that is read off a few samples is turns away at the
    end of a long record, and from there no step leads back.
    """
    first, seen = fit_starts(static, data, unknowns, enough=enough)
    errors = data.errors_of(seen)
    off = [k for k, error in enumerate(errors) if not error <= GOOD]
    if not (off and static.equation.model.effects):
        return first, seen
    grown, there = unknowns, seen
    for part in _PARTS:
        weight = np.zeros_like(data.weight)
        for own in (data.tape.slices[k] for k in off):
            until = own.start + math.ceil(part * (own.stop - own.start))
            weight[own.start : until] = data.weight[own.start : until]
        grown, there = fit_starts(static, data._replace(weight=weight), grown, _ROUNDS, enough)
    better = [k for k, error in enumerate(data.errors_of(there)) if k in off and error < errors[k]]
    if not better:
        return first, seen
    starts = first.starts.copy()
    starts[better] = grown.starts[better]
    best = Unknowns(first.x, starts)
    return best, evaluate(static, data, best)


def _cost(found: Evaluation, unknowns: Unknowns, light: np.ndarray) -> float:
    return float(found.residuals @ found.residuals + np.sum((light * unknowns.starts) ** 2))


def _steps(data: Data, found: Evaluation, unknowns: Unknowns, light: np.ndarray) -> tuple[np.ndarray | None, float]:
    """Steps (records, s) to where the initial states would fit best if they entered linearly, None if the motion has no
    bound; the fall of the cost that they promise."""
    steps, promised = np.zeros_like(unknowns.starts), 0.0
    for record, own in enumerate(data.tape.slices):
        slope = found.by_start[:, own]
        gram = slope @ slope.T
        pull = slope @ found.residuals[own] + light**2 * unknowns.starts[record]
        if not (np.all(np.isfinite(gram)) and np.all(np.isfinite(pull))):
            return None, 0.0
        # A start of which nothing is left where samples count stays as it was read; of an overdamped motion
        # displacement and velocity at the start leave the same trace.
        inverse = np.linalg.pinv(gram + np.diag(light**2), rcond=1e-12, hermitian=True)
        steps[record] = inverse @ pull * (data.start_scale[record] > 0)
        promised += float(pull @ steps[record])
    return steps, promised
