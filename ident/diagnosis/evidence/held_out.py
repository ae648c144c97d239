"""What records that no fit has seen say of a model, and of another in its place."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Protocol

import numpy as np

from ...campaign.campaign import Campaign
from ...campaign.record import Trace
from ...fit import Fit
from ...fit.carry_over import expected_error
from ...fit.linear.independent import independent_samples
from ...fit.reading import read
from ...model import Model
from .enough import known_floor_of

BEYOND_FLOORS = 3.0  # times what is expected, an error that no wrong noise floor makes: those are within 2
_HURT = 1.02  # held-out error may grow by this factor before a term is refused
_CLEARLY_WORSE = 2.0  # of 2 ln(odds): less is not worth a mention (Kass, Raftery, as in `criterion`)


def foretold(fit: Fit) -> bool:
    """Whether the held-out records, if there are any, stand at the noise floor too, within what is known of it and what
    the parameters' errors make of them."""
    held = fit.holdout
    floor = known_floor_of([r for r in fit.campaign.records if r.holdout])
    return held is None or held.error_over_noise < floor or held.error_over_noise < floor * expected_error(fit)


def contradicted(fit: Fit) -> bool:
    """Whether the held-out records clearly say otherwise of a model that stands at the noise floor on the fitted ones:
    the error there is many noise floors and a good part of the signal, and what the parameters' errors can make of it
    is not enough."""
    held = fit.holdout
    if held is not None and not np.isfinite(held.error_over_noise):
        return True  # a motion without bound is not what was measured
    if held is None or held.error_over_noise < BEYOND_FLOORS * max(fit.fitted.error_over_noise, 1.0):
        return False
    if held.error_over_signal < BEYOND_FLOORS * fit.fitted.error_over_signal:
        return False
    return held.error_over_noise > BEYOND_FLOORS * expected_error(fit)


def predicts_better(before: Fit, after: Fit) -> bool:
    """Whether held-out records are predicted better, by more than chance makes of them, or there are none."""
    if before.holdout is None or after.holdout is None:
        return True
    return after.holdout.error_over_noise < before.holdout.error_over_noise and _beyond_chance(after, before)


def hurts(before: Fit, after: Fit) -> bool:
    """Whether held-out records are predicted worse, by more than laws of one kind and chance make of them."""
    if before.holdout is None or after.holdout is None:
        return False
    if not np.isfinite(after.holdout.error_over_noise):
        return bool(np.isfinite(before.holdout.error_over_noise))
    if after.holdout.error_over_noise <= _HURT * before.holdout.error_over_noise:
        return False
    return _worse_in_each(before, after) and _beyond_chance(before, after)


def hurts_more(before: Fit, after: Fit) -> bool:
    """Whether held-out records lose more by another law than the fitted ones gain.

    Beside an effect that is not sure yet, held-out error tells about that one's parameters rather than about the law.
    """
    if before.holdout is None or after.holdout is None or not hurts(before, after):
        return False
    return after.holdout.chi2 - before.holdout.chi2 > before.fitted.chi2 - after.fitted.chi2


class Predicting(Protocol):
    """A model and its values (SI)."""

    @property
    def model(self) -> Model: ...
    @property
    def values(self) -> np.ndarray: ...


def behind_held_out(campaign: Campaign, one: Predicting, other: Predicting) -> float:
    """By how much another model predicts the held-out traces worse, in 2 ln(odds): neither was fitted to them, so that
    no number has a price. 0 if there are none."""
    held = [trace for trace in campaign.traces if trace.holdout]
    if not held:
        return 0.0
    missed = [_left_of(held, read(told.model, told.values, held, compared=True)) for told in (one, other)]
    was, now = (float(left @ left) for left in missed)
    if not np.isfinite(was + now):
        return np.inf if np.isfinite(was) else -np.inf
    return independent_samples(missed[0]) * float(np.log(now / was))


def _worse_in_each(before: Fit, after: Fit) -> bool:
    """Whether held-out records are predicted worse where each counts by its own error, whatever its noise floor: far
    above the floors the record with the lowest would else decide alone, and outvote another that became ten times
    better."""
    pairs = [(a, b) for a, b in zip(before.scores, after.scores, strict=True) if a.holdout]
    growth = [np.log(max(b.error_over_noise, 1.0) / max(a.error_over_noise, 1.0)) for a, b in pairs]
    return bool(np.average(growth, weights=[a.n for a, _ in pairs]) > np.log(_HURT))


def _beyond_chance(before: Fit, after: Fit) -> bool:
    """Whether the second of two fits predicts held-out traces worse, by more than their independent samples leave to
    chance; where only sweeps are held out, whose points are independent, nothing is left to it."""
    was, now = _missed(before), _missed(after)
    if not len(was):
        return True
    n = independent_samples(was)
    return not n * np.log(max(float(now @ now), 1e-300) / max(float(was @ was), 1e-300)) < _CLEARLY_WORSE


def _missed(fit: Fit) -> np.ndarray:
    """What a fit misses of its held-out records, in noise floors."""
    pairs = [pair for pair in zip(fit.campaign.traces, fit.readings, strict=True) if pair[0].holdout]
    return _left_of([trace for trace, _ in pairs], [told for _, told in pairs])


def _left_of(traces: Sequence[Trace], readings: Sequence[np.ndarray]) -> np.ndarray:
    pairs = zip(traces, readings, strict=True)
    parts = [((trace.response - told) / trace.noise.sigma)[trace.counted] for trace, told in pairs]
    return np.concatenate(parts) if parts else np.zeros(0)
