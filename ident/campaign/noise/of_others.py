"""A noise floor that no frequency of its record shows, weighed with those of the others of its sensor.

A drive that leaves no frequency free, noise up to the highest or a blow, leaves a level just above its band, if that,
which is taken as white: beneath red noise it was half of the floor. The other records tell the level as far as they
agree with one another, for a range or a laser's spot may differ from record to record. Beneath red noise it is then a
third as far off, at about the error that it claims; beneath white noise, where that level is right by itself, it is
farther off than before, for nobody knows that it is white (`experiments.hidden_noise`).

Source: R. DerSimonian, N. Laird, Meta-analysis in clinical trials, 1986, Controlled Clinical Trials 7, 177 (levels that
differ by more than their errors); R. T. Birge, 1932, Phys. Rev. 40, 207 (the error of what hardly agrees).
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..record import VAGUE, NoiseFloor, Trace
from .floor import extrapolated
from .one_sensor import WIDER, alike

_FEWEST = 4  # others: of three, two agree by chance, and tell too little of how much the next one differs
_APART = 2.0  # errors between a floor and what the others let expect: more, and it was read otherwise than they were


def beside_others(traces: Sequence[Trace], floors: Sequence[NoiseFloor]) -> list[NoiseFloor]:
    """The floors of records, those that their records do not show as what the others and they themselves say."""
    pairs = list(zip(traces, floors, strict=True))
    sure = [(trace, floor) for trace, floor in pairs if trace.masked is None and 0.0 < floor.relative_error < VAGUE]
    return [_weighed(trace, own, [floor for t, floor in sure if alike(trace, t)]) for trace, own in pairs]


def _weighed(trace: Trace, own: NoiseFloor, others: Sequence[NoiseFloor]) -> NoiseFloor:
    """A floor that is vague, in the colour of the surest of the others; one that was read off frequencies has its own,
    and one that is far from the others is of another kind."""
    shown = own.relative_error < VAGUE or own.unseen > 0.0
    if trace.masked is not None or shown or len(others) < _FEWEST:
        return own
    errors = [f.relative_error * (WIDER if extrapolated(f) else 1.0) for f in others]
    level, error = _next_of(np.log([f.sigma for f in others]), np.array(errors))
    apart = abs(float(np.log(own.sigma)) - level) / float(np.hypot(own.relative_error, error))
    if apart > _APART:
        return own
    weights = np.array([own.relative_error, error]) ** -2.0
    sigma = float(np.exp(np.average([np.log(own.sigma), level], weights=weights)))
    surest = min(others, key=lambda floor: floor.relative_error)
    method = f"the level of {len(others)} other records of its sensor, weighed with the little that its own shows"
    return NoiseFloor(sigma, surest.ar, method, max(apart, 1.0) * float(np.sum(weights) ** -0.5))


def _next_of(values: np.ndarray, errors: np.ndarray) -> tuple[float, float]:
    """What one more of several values will be, that differ by more than their errors, and how surely: errors of one
    kind may have one sign, and are not less for being many."""
    weights = errors**-2.0
    off = float(weights @ (values - np.average(values, weights=weights)) ** 2) - (len(values) - 1)
    between = max(off / float(weights.sum() - weights @ weights / weights.sum()), 0.0)
    mean = np.average(values, weights=1 / (errors**2 + between))
    return float(mean), float(np.sqrt(between * (1 + 1 / len(values)) + 1 / weights.mean()))
