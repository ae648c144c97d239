"""A device that differs from one record to the next: warmer or charged, read with another sensitivity, or later.

Each record then has a number s of its own, found by Gauss-Newton steps beside everything that the model absorbs:

    m z̈ + c ż + k (1 + s) z = F    or    reading = (1 + s) z    or    reading(t) = z(t − s Δt).

To a sine every nonlinear device is a linear one of another resonance at each level
(N. Minorsky, Nonlinear Oscillations, 1962, ch. 14): that records differ is an answer only where no law explains them.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Literal, NamedTuple

import numpy as np

from ...campaign.campaign import Campaign
from ...campaign.late import told_apart
from ...campaign.record import Trace
from ...fit import Fit, fit
from ...fit.reading import read
from ...model import FREQUENCY
from ..evidence.criterion import VERY_STRONG, Left, behind, criteria
from ..linearised.regression import Regression, by_record, prepare, stack
from ..linearised.shorten import working
from ..linearised.trajectory import Diverged
from ..unknown.subsets import regress

Kind = Literal["stiffness", "sensitivity", "delay"]

_ROUNDS = 6  # of the records' numbers and the device's in turn
_SETTLED = 0.3  # of its error bar: a step that moves no number further ends them
_SMALL = 1e-4  # change of a stiffness by which its derivative is taken
_FEWEST = 3  # records: of two that disagree nobody knows which one is the device's


_WORDS: dict[Kind, tuple[str, float, str, str]] = {  # what, times its number in the unit, and why
    # A resonance moves by half of what its spring does.
    "stiffness": ("resonance", 50.0, "%", "was the device warmer or otherwise loaded in some?"),
    "sensitivity": ("sensitivity", 100.0, "%", "was the sensor moved?"),
    "delay": ("delay", 1.0, "samples", "did each have a trigger of its own?"),
}


class Differing(NamedTuple):
    """Records that differ in one `kind` of number: `sizes` and `errors` (traces,), as shares or (delays) in samples,
    their mean zero over the fitted ones where the device has such a number too; and the `fit` of the same model to the
    records as a device like the others would have given them."""

    kind: Kind
    sizes: np.ndarray
    errors: np.ndarray
    fit: Fit

    @property
    def words(self) -> str:
        """What differs, for people."""
        names = [trace.name for trace in self.fit.campaign.traces]
        what, times, unit, why = _WORDS[self.kind]
        each = ", ".join(f"{times * s:+.2g} ± {times * e:.1g} {unit} in {name}"
                         for name, s, e in zip(names, self.sizes, self.errors, strict=True))  # fmt: skip
        told = f"The records agree only if each has a {what} of its own: {each}."
        return f"{told} They are read so, held-out ones too: {why}"

    def moved(self, before: Differing) -> bool:
        """Whether a number has moved by more than is little beside its error."""
        return bool(np.any(np.abs(self.sizes - before.sizes) > _SETTLED * self.errors))

    def begun(self, start: Fit) -> Fit:
        """The fit from which a walk had begun, with the records read so."""
        campaign = self.fit.campaign
        told = replace(campaign, notes=(*campaign.notes, self.words))
        return fit(start.model, told, initial=start.values)


KINDS = tuple(_WORDS)


def comparable(fitted: Fit) -> bool:
    """Whether the records of a fit can be told apart by a number each."""
    enough = len(fitted.campaign.fitted) >= _FEWEST and not fitted.campaign.fitted_sweeps
    return enough and fitted.model.form == "oscillator"


def numbers_of(fitted: Fit, kind: Kind) -> int:
    """How many numbers a fit has more where its records differ so: what all share is the device's, but for a delay."""
    return len(fitted.campaign.fitted) - (kind != "delay")


def rows_of(regression: Regression, kind: Kind) -> np.ndarray:
    """What the number of each record does to it, along the measured motion: whitened, (traces, n)."""
    records, fit = regression.fit.campaign.fitted, regression.fit
    if kind == "stiffness":
        direction = np.zeros((1, len(fit.values)))
        direction[0, FREQUENCY] = fit.values[FREQUENCY]
        whole = stack(regression, fit.model, fit.values[None], direction, True, regression.trajectories.histories[None])
        rows = np.zeros((len(records), len(whole[0])))
        for row, own in zip(rows, regression.places, strict=True):
            row[own] = whole[0, own]
        return rows
    rows = np.zeros((len(records), regression.trajectories.tape.samples))
    readings = read(fit.model, fit.values, records) if kind == "sensitivity" else [r.response for r in records]
    for row, reading, own in zip(rows, readings, regression.trajectories.tape.slices, strict=True):
        row[own] = reading if kind == "sensitivity" else -np.gradient(reading)
    return by_record(regression, rows)


def differing(fitted: Fit, kinds: Sequence[Kind] = KINDS) -> Differing | None:
    """The kind of number by which the records of a fit differ, if that explains them clearly better than one device
    does; None if it does not."""
    if not comparable(fitted):
        return None
    weigh = lambda fit, more: Left(prepare(working(fit)).left, fit.freedom + more)
    try:
        before = weigh(fitted, 0)
        found = [(one, weigh(one.fit, numbers_of(fitted, kind)))
                 for kind in kinds if (one := _found(fitted, kind)) is not None]  # fmt: skip
    except (Diverged, np.linalg.LinAlgError):  # a motion without bound tells nothing
        return None
    better = [(one, left) for one, left in found if behind(left, before) < -VERY_STRONG]
    return better[int(np.argmin(criteria([left for _, left in better])))][0] if better else None


def _found(fitted: Fit, kind: Kind) -> Differing | None:
    campaign, now = fitted.campaign, fitted
    inside = [i for i, trace in enumerate(campaign.traces) if not trace.holdout]
    sizes, errors = np.zeros((2, len(campaign.traces)))
    for _ in range(_ROUNDS):
        regression = prepare(working(now))
        rows = np.zeros((len(inside), regression.trajectories.tape.samples))
        for row, trace, own in zip(rows, now.campaign.fitted, regression.trajectories.tape.slices, strict=True):
            row[own] = _slope(now, trace, kind)
        solved = regress(regression.project(by_record(regression, rows)), regression.residual)
        step, spread = solved.coefficients, solved.spread
        if kind != "delay":  # of which the device has none
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
    return Differing(kind, sizes, errors, now) if np.all(np.isfinite(sizes)) else None


def _slope(now: Fit, trace: Trace, kind: Kind) -> np.ndarray:
    """Change of the reading of a record with its number, (n,)."""
    here = read(now.model, now.values, [trace])[0]
    if kind == "sensitivity":
        return here
    if kind == "delay":
        return -np.gradient(here)
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
    if kind == "delay":
        return told_apart(trace, size)
    times = 1 / (1 + size)
    noise = replace(trace.noise, sigma=trace.noise.sigma * times)
    return replace(trace, response=trace.response * times, noise=noise, rescaled=trace.rescaled * times)
