"""A device that differs from one record to the next: warmer or charged, or read with another sensitivity.

Each record then has a number s of its own, found by Gauss-Newton steps beside everything that the model absorbs:

    m z̈ + c ż + k (1 + s) z = F    or    reading = (1 + s) z.

To a sine every nonlinear device is a linear one of another resonance at each level
(N. Minorsky, Nonlinear Oscillations, 1962, ch. 14): that records differ is an answer only where no law explains them.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ...campaign.campaign import Campaign
from ...campaign.record import Trace
from ...fit import Fit, fit
from ...fit.reading import read
from ..evidence.criterion import VERY_STRONG, Left, behind, criteria
from ..linearised.regression import by_record, prepare
from ..linearised.shorten import working
from ..linearised.trajectory import Diverged
from ..unknown.subsets import regress
from .between_levels import differing_levels
from .differing import Differing, Kind

_ROUNDS = 4  # of the records' numbers and the device's in turn
_SETTLED = 0.3  # of its error bar: a step that moves no number further ends them
_SMALL = 1e-4  # change of a stiffness by which its derivative is taken
_FEWEST = 3  # records: of two that disagree nobody knows which one is the device's


def differing(fitted: Fit, kinds: tuple[Kind, ...] = ("stiffness", "sensitivity", "drive")) -> Differing | None:
    """The kind of number by which the records of a fit differ, or the levels of its sweeps in their drives, if that
    explains them clearly better than one device does; None if it does not, and where traces stand beside sweeps."""
    traces, sweeps = fitted.campaign.traces, fitted.campaign.sweeps
    if (traces and sweeps) or fitted.model.form != "oscillator":
        return None
    weigh = lambda fit, more: Left(prepare(working(fit)).left, fit.freedom + more)
    try:
        before = weigh(fitted, 0)
        tried = [differing_levels(fitted) if kind == "drive" else _found(fitted, kind)
                 for kind in kinds if (kind == "drive") == bool(sweeps)]  # fmt: skip
        found = [(one, weigh(one.fit, one.numbers)) for one in tried if one is not None]
    except (Diverged, np.linalg.LinAlgError):  # a motion without bound tells nothing
        return None
    better = [(one, left) for one, left in found if behind(left, before) < -VERY_STRONG]
    return better[int(np.argmin(criteria([left for _, left in better])))][0] if better else None


def _found(fitted: Fit, kind: Kind) -> Differing | None:
    campaign, now = fitted.campaign, fitted
    inside = [i for i, trace in enumerate(campaign.traces) if not trace.holdout]
    if len(inside) < _FEWEST:
        return None
    sizes, errors = np.zeros((2, len(campaign.traces)))
    for _ in range(_ROUNDS):
        regression = prepare(working(now))
        rows = np.zeros((len(inside), regression.trajectories.tape.samples))
        for row, trace, own in zip(rows, now.campaign.fitted, regression.trajectories.tape.slices, strict=True):
            row[own] = _slope(now, trace, kind)
        solved = regress(regression.project(by_record(regression, rows)), regression.residual)
        step, spread = solved.coefficients, solved.spread
        step, spread = step - np.mean(step), spread - np.mean(spread, axis=0)  # what all share is the device's
        errors[inside] = np.linalg.norm(spread, axis=1) * np.sqrt(max(regression.chi2 / regression.n, 1.0))
        sizes[inside] += step
        now = fit(fitted.model, _with(campaign, kind, sizes), initial=now.values)
        if np.all(np.abs(step) < _SETTLED * errors[inside]):
            break
    for i, trace in enumerate(campaign.traces):
        if trace.holdout:
            sizes[i], errors[i] = _by_itself(now, trace, kind)
    now = fit(fitted.model, _with(campaign, kind, sizes), initial=now.values, most=1)
    names = tuple(trace.name for trace in campaign.traces)
    return Differing(kind, names, sizes, errors, now) if np.all(np.isfinite(sizes)) else None


def _slope(now: Fit, trace: Trace, kind: Kind) -> np.ndarray:
    """Change of the reading of a record with its number, (n,)."""
    here = read(now.model, now.values, [trace])[0]
    if kind == "sensitivity":
        return here
    return (read(now.model, now.values, [_differing(trace, kind, _SMALL)])[0] - here) / _SMALL


def _by_itself(now: Fit, trace: Trace, kind: Kind) -> tuple[float, float]:
    """The number of a held-out record and its error, from what the model misses of it."""
    size, error = 0.0, np.inf
    for _ in range(_ROUNDS):
        own = _differing(trace, kind, size)
        left = (own.response - read(now.model, now.values, [own])[0])[own.counted] / own.noise.sigma
        slope = _slope(now, own, kind)[own.counted] / own.noise.sigma
        weight = float(slope @ slope)
        if not weight > 0:  # it does not move
            return 0.0, np.inf
        size, error = size + float(slope @ left) / weight, 1 / np.sqrt(weight)
    return size, error


def _with(campaign: Campaign, kind: Kind, sizes: np.ndarray) -> Campaign:
    """The campaign with traces that differ."""
    own = iter(sizes)
    told = (_differing(r, kind, float(next(own))) if isinstance(r, Trace) else r for r in campaign.records)
    return replace(campaign, records=tuple(told))


def _differing(trace: Trace, kind: Kind, size: float) -> Trace:
    if kind == "stiffness":
        return replace(trace, stiffer=(1 + trace.stiffer) * (1 + size) - 1)
    times = 1 / (1 + size)
    noise = replace(trace.noise, sigma=trace.noise.sigma * times)
    return replace(trace, response=trace.response * times, noise=noise, rescaled=trace.rescaled * times)
