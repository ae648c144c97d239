"""Priors with units: what is known of each parameter before any record is seen, and in which words.

    normal        p ~ N(centre, spread²)
    log-normal    ln p ~ N(ln centre, spread²)
    log-uniform   ln p is uniform between the limits

A parameter with limits has the part of its prior between them, normalised there, so that evidence means something.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Literal, NamedTuple

import numpy as np
from scipy.special import log_ndtr
from scipy.stats import norm

from ..campaign.campaign import Prior as ToldPrior
from ..fit.coordinates import to_values
from ..model import ModelParameter

Kind = Literal["normal", "log-normal", "log-uniform"]
_WIDE = math.log(10.0)  # spread of ln p where nothing is known but a typical value: a decade to each side


class Prior(NamedTuple):
    """The prior of one parameter: `centre` and `spread` SI (of a log-normal one the spread of ln p, of a log-uniform
    one both are unused), between `lower` and `upper`; `source`: why, in words."""

    name: str
    unit: str
    kind: Kind
    centre: float
    spread: float
    lower: float
    upper: float
    source: str

    @property
    def deviation(self) -> float:
        """Standard deviation of p (normal) or of ln p (the others)."""
        if self.kind == "log-uniform":
            return math.log(self.upper / self.lower) / math.sqrt(12.0)
        return self.spread

    def density(self, value: np.ndarray) -> np.ndarray:
        """Probability density of physical values, per SI unit."""
        inside = (value > self.lower) & (value < self.upper)
        if self.kind == "normal":
            shape = norm.pdf(value, self.centre, self.spread)
        else:
            safe = np.where(value > 0, value, 1.0)
            logarithm = np.log(safe)
            shape = norm.pdf(logarithm, math.log(self.centre), self.spread) if self.kind == "log-normal" else np.ones(1)
            shape = shape / safe
        return np.where(inside, shape, 0.0) * math.exp(-_log_mass(self))


def choose_prior(
    parameter: ModelParameter, lower: float, upper: float, told: ToldPrior | None, signal_size: float, value: float
) -> Prior:
    """The prior of a fitted parameter.

    In this order: what the campaign says; what the effect declares as expected; the limits of a shape; the size with
    which the parameter alone would be as large as the whole signal; a decade around a typical value.

    **Arguments:** `lower`, `upper`: limits in the fit, SI; `signal_size`: |p| with which it would move the readings by
    as much as they are; `value`: of the fit, used only where nothing else gives an order of magnitude.
    """
    make = lambda kind, centre, spread, source: Prior(
        parameter.name, parameter.unit, kind, float(centre), float(spread), lower, upper, source
    )
    if told is not None:
        return make("normal", told.mean, told.deviation, "the campaign")
    expected = parameter.expected
    if expected is not None:
        kind = "log-normal" if parameter.positive else "normal"
        return make(kind, expected.centre, expected.spread, expected.source)
    if math.isfinite(upper) and lower > 0:
        return make("log-uniform", math.sqrt(lower * upper), 0.0, "any size between its limits")
    if not parameter.positive:
        return make("normal", 0.0, signal_size, "alone it is at most about as large as the signal")
    return make("log-normal", value, _WIDE, "within a decade of the fitted size; the data gave the size")


class PriorTable(NamedTuple):
    """Priors of all unknowns as arrays (p,): `normal` 1 where p itself is Gaussian, `logarithmic` 1 where ln p is."""

    normal: np.ndarray
    logarithmic: np.ndarray
    centre: np.ndarray
    spread: np.ndarray
    constant: np.ndarray


def table(priors: Sequence[Prior]) -> PriorTable:
    """Priors as arrays for the compiled code."""
    centre = [math.log(p.centre) if p.kind == "log-normal" else p.centre if p.kind == "normal" else 0.0 for p in priors]
    spread = [p.spread if p.kind != "log-uniform" else 1.0 for p in priors]
    constant = [
        -_log_mass(p) - (math.log(s * math.sqrt(2 * math.pi)) if p.kind != "log-uniform" else 0.0)
        for p, s in zip(priors, spread, strict=True)
    ]
    kinds = [p.kind for p in priors]
    return PriorTable(
        np.array([float(k == "normal") for k in kinds]),
        np.array([float(k == "log-normal") for k in kinds]),
        np.array(centre),
        np.array(spread),
        np.array(constant),
    )


def _log_mass(prior: Prior) -> float:
    """ln of the prior's mass between its limits, in the variable in which it is written."""
    if prior.kind == "log-uniform":
        return math.log(math.log(prior.upper / prior.lower))
    if prior.kind == "normal":
        low, high = ((x - prior.centre) / prior.spread for x in (prior.lower, prior.upper))
    else:
        logs = [math.log(x) if x > 0 else -math.inf for x in (prior.lower, prior.upper)]
        low, high = ((x - math.log(prior.centre)) / prior.spread for x in logs)
    if low > 0:  # the tail above is that below, mirrored, where differences keep their digits
        low, high = -high, -low
    return float(log_ndtr(high) + np.log1p(-np.exp(log_ndtr(low) - log_ndtr(high))))


def log_prior(priors: PriorTable, coordinates: np.ndarray, lower: np.ndarray, upper: np.ndarray) -> np.ndarray:
    """ln prior density of unbounded coordinates (..., p), each: that of the value times the slope of the bijection."""
    values = to_values(coordinates, lower, upper)
    positive, ranged = np.isfinite(lower), np.isfinite(upper)
    logarithm = np.log(np.where(positive, values, 1.0))
    # ln s(1 − s) from the coordinate itself, so that it keeps its digits next to a bound.
    length = np.log(np.where(ranged, upper, 2.0) / np.where(ranged, lower, 1.0))
    y = 4.0 * np.where(ranged, coordinates, 0.0) / length
    share = np.where(ranged, math.log(4.0) - np.logaddexp(0.0, y) - np.logaddexp(0.0, -y), 0.0)
    variable = np.where(priors.normal > 0, values, logarithm)
    gaussian = -0.5 * (priors.normal + priors.logarithmic) * ((variable - priors.centre) / priors.spread) ** 2
    return gaussian + priors.constant + share + priors.normal * logarithm
