"""A device that differs from one record to the next: warmer or charged, at another pressure, read with another
sensitivity, later, or by a sensor that drifts.

Each record then has numbers s of its own, found by Gauss-Newton steps beside everything that the model absorbs:

    m z̈ + c ż + k (1 + s) z = F  or  m z̈ + c (1 + s) ż + k z = F,
    reading = (1 + s) z  or  z(t − s Δt)  or  z(t − s t)  or  z + s  or  z + s₀ + s₁ t + s₂ t².

To a sine every nonlinear device is a linear one of another resonance at each level
(N. Minorsky, Nonlinear Oscillations, 1962, ch. 14): that records differ is an answer only where no law explains them.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Literal

import numpy as np

from ...campaign.apart import TOLD, Kind, curves, read_apart, signal_of
from ...campaign.campaign import Campaign
from ...campaign.record import Trace
from ...fit import Fit, fit
from ...fit.reading import read
from ...model import FREQUENCY, QUALITY
from ..evidence.criterion import VERY_STRONG, Left, behind, criteria
from ..linearised.regression import Regression, by_record, prepare, stack
from ..linearised.trajectory import Diverged
from .alternated import FEWEST, ROUNDS, alternated
from .between_levels import differing_levels
from .differing import Differing, numbers_of, without_common_zero

_STEPS = 20  # of the device's fit in each round: the next one goes on from there
_SMALL = 1e-4  # change of a stiffness or a damping by which its derivative is taken

KINDS = tuple(TOLD)
_OF_DEVICE = {"stiffness": (FREQUENCY, 1.0), "damping": (QUALITY, -1.0)}
"""Which parameter of the linear part such a number moves along, and whether up or down."""


def comparable(fitted: Fit) -> bool:
    """Whether the records of a fit can be told apart by a number each."""
    enough = len(fitted.campaign.fitted) >= FEWEST and not fitted.campaign.fitted_sweeps
    return enough and fitted.model.form == "oscillator"


def kinds_of(campaign: Campaign) -> Sequence[Kind]:
    """The kinds of numbers in which the records of a campaign may differ: a decay has nothing to be late to."""
    return KINDS if all(trace.driven for trace in campaign.traces) else [k for k in KINDS if not TOLD[k].of_time]


def alike(kind: Kind | Literal["drive"]) -> Sequence[Kind | Literal["drive"]]:
    """The kinds of numbers that may be meant once a law is in that had been missing: what it did to the mean of a
    record, as its motion grew, had looked like a drift of the sensor, where a zero is enough."""
    if kind == "drive" or not TOLD[kind].of_zero:
        return [kind]
    return [k for k in KINDS if TOLD[k].of_zero and TOLD[k].each <= TOLD[kind].each]


def rows_of(regression: Regression, kind: Kind) -> np.ndarray:
    """What the numbers of each record do to it, along the measured motion: whitened, (numbers, n)."""
    records, fit = regression.fit.campaign.fitted, regression.fit
    if kind in _OF_DEVICE:
        at, sign = _OF_DEVICE[kind]
        direction = np.zeros((1, len(fit.values)))
        direction[0, at] = sign * fit.values[at]
        whole = stack(regression, fit.model, fit.values[None], direction, True, regression.trajectories.histories[None])
        rows = np.zeros((len(records), len(whole[0])))
        for row, own in zip(rows, regression.places, strict=True):
            row[own] = whole[0, own]
        return rows
    late = TOLD[kind].of_time
    along = lambda trace: _later(trace, trace.response, kind) if late else _slopes(fit, trace, trace, kind)
    return by_record(regression, _apart(regression, [along(trace) for trace in records]))


def differing(fitted: Fit, kinds: Sequence[Kind | Literal["drive"]] | None = None) -> Differing | None:
    """The kind of numbers by which the records of a fit differ, or the levels of its sweeps in their drives, if that
    explains them clearly better than one device does; None if it does not. Of traces beside sweeps only a baseline is
    asked for, of which those know nothing."""
    traces, sweeps = fitted.campaign.traces, fitted.campaign.sweeps
    if any(sweep.fast for sweep in sweeps) or fitted.model.form != "oscillator":
        return None
    asked: Sequence[Kind | Literal["drive"]] = kinds or kinds_of(fitted.campaign)
    if sweeps and kinds is None:
        asked = ("baseline",) if traces else ("drive",)
    weigh = lambda fit, more: Left(prepare(fit).left, fit.freedom + more)
    try:
        before = weigh(fitted, 0)
    except (Diverged, np.linalg.LinAlgError):  # a motion without bound tells nothing
        return None
    found: list[tuple[Differing, Left]] = []
    for kind in asked:
        try:
            one = differing_levels(fitted) if kind == "drive" else _found(fitted, kind)
            found += [] if one is None else [(one, weigh(one.fit, one.numbers))]
        except (Diverged, np.linalg.LinAlgError):  # nor if its records are read so
            continue
    better = [(one, left) for one, left in found if behind(left, before) < -VERY_STRONG]
    return better[int(np.argmin(criteria([left for _, left in better])))][0] if better else None


def _found(fitted: Fit, kind: Kind) -> Differing | None:
    told = TOLD[kind]
    fitted = without_common_zero(fitted) if told.of_zero else fitted
    campaign = fitted.campaign
    inside = np.array([i for i, trace in enumerate(campaign.traces) if not trace.holdout])
    if len(inside) < (2 if told.of_zero else FEWEST):  # a zero that moves is no device's
        return None
    shortest = min(len(trace.time) for trace in campaign.traces)
    most = min(told.most, shortest / 10) if kind == "delay" else told.most
    if told.of_zero:
        most *= max(signal_of(trace) for trace in campaign.traces)

    def along(now: Fit) -> tuple[Regression, np.ndarray]:
        regression = prepare(now)
        pairs = zip(campaign.fitted, now.campaign.fitted, strict=True)
        rows = by_record(regression, _apart(regression, [_slopes(now, as_read, own, kind) for as_read, own in pairs]))
        return regression, np.pad(rows, ((0, 0), (0, len(regression.residual) - rows.shape[1])))  # nothing to sweeps

    read_by = lambda sizes: _with(campaign, kind, sizes)
    refit = lambda now, sizes: fit(fitted.model, read_by(sizes), initial=now.values, most=_STEPS)
    start = np.zeros((len(campaign.traces), told.each))
    settled = alternated(fitted, inside, start, along, refit, told.shared, most)
    if settled is None:
        return None
    now, sizes, errors = settled
    for i, trace in enumerate(campaign.traces):
        if trace.holdout:
            sizes[i], errors[i] = _by_itself(now, trace, kind, most)
    now = fit(fitted.model, read_by(sizes), initial=now.values, most=1)
    names = tuple(trace.name for trace in campaign.traces)
    found = Differing(kind, names, sizes, errors, now, numbers_of(now, kind))
    return found if np.all(np.isfinite(sizes)) else None


def _apart(regression: Regression, slopes: Sequence[np.ndarray]) -> np.ndarray:
    """Readings (numbers, samples) that are each record's own (q, n)."""
    places, q = regression.trajectories.tape.slices, len(slopes[0])
    rows = np.zeros((q * len(slopes), regression.trajectories.tape.samples))
    for i, (own, place) in enumerate(zip(slopes, places, strict=True)):
        rows[i * q : (i + 1) * q, place] = own
    return rows


def _slopes(now: Fit, as_read: Trace, trace: Trace, kind: Kind) -> np.ndarray:
    """Change of the reading of a record, as it was read and as its numbers so far make it, with these, (q, n)."""
    if TOLD[kind].of_zero:
        return curves(as_read)[: TOLD[kind].each]
    here = read(now.model, now.values, [trace])[0]
    if kind == "sensitivity":
        return here[None] / (1 + trace.number(kind))
    if TOLD[kind].of_time:
        return _later(trace, here, kind)
    more = read_apart(trace, kind, [trace.number(kind) + _SMALL])
    return (read(now.model, now.values, [more])[0] - here)[None] / _SMALL


def _later(trace: Trace, reading: np.ndarray, kind: Kind) -> np.ndarray:
    """Change of a reading with its delay, in samples, or with the share by which its clock is fast, (1, n)."""
    return -np.gradient(reading)[None] * (np.arange(len(trace.time)) if kind == "clock" else 1.0)


def _by_itself(now: Fit, trace: Trace, kind: Kind, most: float) -> tuple[np.ndarray, np.ndarray]:
    """The numbers of a held-out record and their errors, (q,), from what the model misses of it."""
    sizes = np.zeros(TOLD[kind].each)
    for _ in range(ROUNDS):
        own = read_apart(trace, kind, sizes)
        left = (own.response - read(now.model, now.values, [own])[0])[own.counted] / own.noise.sigma
        slopes = _slopes(now, trace, own, kind)[:, own.counted] / own.noise.sigma
        if not np.all(np.any(slopes, axis=1)):  # it does not move
            return np.zeros(len(sizes)), np.full(len(sizes), np.inf)
        back = np.linalg.pinv(slopes.T)
        sizes, errors = np.clip(sizes + back @ left, -most, most), np.linalg.norm(back, axis=1)
    return sizes, errors


def _with(campaign: Campaign, kind: Kind, sizes: np.ndarray) -> Campaign:
    """The campaign with traces that differ."""
    own = iter(sizes)
    told = (read_apart(r, kind, next(own)) if isinstance(r, Trace) else r for r in campaign.records)
    return replace(campaign, records=tuple(told))
