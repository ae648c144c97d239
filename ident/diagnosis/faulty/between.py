"""A device that differs from one record to the next: warmer or charged, read with another sensitivity, later, or by a
sensor that drifts.

Each record then has numbers s of its own, found by Gauss-Newton steps beside everything that the model absorbs:

    m z̈ + c ż + k (1 + s) z = F,   reading = (1 + s) z  or  z(t − s Δt)  or  z(t − s t)  or  z + s₀ + s₁ t + s₂ t².

To a sine every nonlinear device is a linear one of another resonance at each level
(N. Minorsky, Nonlinear Oscillations, 1962, ch. 14): that records differ is an answer only where no law explains them.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from ...campaign.apart import TOLD, Kind, curves, read_apart, size_of
from ...campaign.campaign import Campaign
from ...campaign.record import Trace
from ...fit import Fit, fit
from ...fit.reading import read
from ...model import FREQUENCY
from ..evidence.criterion import VERY_STRONG, Left, behind, criteria
from ..linearised.regression import Regression, by_record, prepare, stack
from ..linearised.shorten import working
from ..linearised.trajectory import Diverged
from ..unknown.subsets import regress

_ROUNDS = 6  # of the records' numbers and the device's in turn
_SETTLED = 0.3  # of its error bar: a step that moves no number further ends them
_SMALL = 1e-4  # change of a stiffness by which its derivative is taken
# How many numbers a record has.
_EACH: dict[Kind, int] = {"stiffness": 1, "sensitivity": 1, "delay": 1, "clock": 1, "baseline": 3}
_SHARED: tuple[Kind, ...] = ("stiffness", "sensitivity")  # what all records have of these is the device's
_FEWEST = 3  # records: of two that disagree nobody knows which one is the device's


class Differing(NamedTuple):
    """Records that differ in one `kind` of numbers: `sizes` and `errors` (traces, q), shares or (delays) samples, their
    mean zero over the fitted ones where the device has such a number too; and the `fit` of the same model to the
    records as a device like the others would have given them."""

    kind: Kind
    sizes: np.ndarray
    errors: np.ndarray
    fit: Fit

    @property
    def words(self) -> str:
        """What differs, for people."""
        told, traces = TOLD[self.kind], self.fit.campaign.traces
        doubt = lambda error: f" ± {told.times * error[0]:.1g}" if len(error) == 1 else ""
        each = ", ".join(f"{size_of(trace):+.2g}{doubt(error)} {told.unit} in {trace.name}"
                         for trace, error in zip(traces, self.errors, strict=True))  # fmt: skip
        alone = f"The records agree only if each has a {told.what} of its own: {each}."
        return f"{alone} They are read so, held-out ones too: {told.why}"

    def moved(self, before: Differing) -> bool:
        """Whether a number has moved by more than is little beside its error."""
        return bool(np.any(np.abs(self.sizes - before.sizes) > _SETTLED * self.errors))

    def begun(self, start: Fit) -> Fit:
        """The fit from which a walk had begun, with the records read so."""
        campaign = self.fit.campaign
        told = replace(campaign, notes=(*campaign.notes, self.words))
        return fit(start.model, told, initial=start.values)


KINDS = tuple(TOLD)


def comparable(fitted: Fit) -> bool:
    """Whether the records of a fit can be told apart by a number each."""
    enough = len(fitted.campaign.fitted) >= _FEWEST and not fitted.campaign.fitted_sweeps
    return enough and fitted.model.form == "oscillator"


def numbers_of(fitted: Fit, kind: Kind) -> int:
    """How many numbers a fit has more where its records differ so."""
    return _EACH[kind] * len(fitted.campaign.fitted) - (kind in _SHARED)


def rows_of(regression: Regression, kind: Kind) -> np.ndarray:
    """What the numbers of each record do to it, along the measured motion: whitened, (numbers, n)."""
    records, fit = regression.fit.campaign.fitted, regression.fit
    if kind == "stiffness":
        direction = np.zeros((1, len(fit.values)))
        direction[0, FREQUENCY] = fit.values[FREQUENCY]
        whole = stack(regression, fit.model, fit.values[None], direction, True, regression.trajectories.histories[None])
        rows = np.zeros((len(records), len(whole[0])))
        for row, own in zip(rows, regression.places, strict=True):
            row[own] = whole[0, own]
        return rows
    late = kind in ("delay", "clock")
    along = lambda trace: _later(trace, trace.response, kind) if late else _slopes(fit, trace, kind)
    return by_record(regression, _apart(regression, [along(trace) for trace in records]))


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
    campaign, now, q = fitted.campaign, fitted, _EACH[kind]
    inside = [i for i, trace in enumerate(campaign.traces) if not trace.holdout]
    sizes, errors = np.zeros((2, len(campaign.traces), q))
    for _ in range(_ROUNDS):
        regression = prepare(working(now))
        rows = _apart(regression, [_slopes(now, trace, kind) for trace in now.campaign.fitted])
        solved = regress(regression.project(by_record(regression, rows)), regression.residual)
        step, spread = solved.coefficients.reshape(-1, q), solved.spread.reshape(len(inside), q, -1)
        if kind in _SHARED:
            step, spread = step - np.mean(step, axis=0), spread - np.mean(spread, axis=0)
        errors[inside] = np.linalg.norm(spread, axis=2) * np.sqrt(max(regression.chi2 / regression.n, 1.0))
        sizes[inside] += step
        now = fit(fitted.model, _with(campaign, kind, sizes), initial=now.values)
        if np.all(np.abs(step) < _SETTLED * errors[inside]):
            break
    for i, trace in enumerate(campaign.traces):
        if trace.holdout:
            sizes[i], errors[i] = _by_itself(now, trace, kind)
    now = fit(fitted.model, _with(campaign, kind, sizes), initial=now.values, most=1)
    return Differing(kind, sizes, errors, now) if np.all(np.isfinite(sizes)) else None


def _apart(regression: Regression, slopes: Sequence[np.ndarray]) -> np.ndarray:
    """Readings (numbers, samples) that are each record's own (q, n)."""
    places, q = regression.trajectories.tape.slices, len(slopes[0])
    rows = np.zeros((q * len(slopes), regression.trajectories.tape.samples))
    for i, (own, place) in enumerate(zip(slopes, places, strict=True)):
        rows[i * q : (i + 1) * q, place] = own
    return rows


def _slopes(now: Fit, trace: Trace, kind: Kind) -> np.ndarray:
    """Change of the reading of a record with its numbers, (q, n)."""
    if kind == "baseline":
        return curves(trace)
    here = read(now.model, now.values, [trace])[0]
    if kind == "sensitivity":
        return here[None]
    if kind in ("delay", "clock"):
        return _later(trace, here, kind)
    stiffer = replace(trace, stiffer=trace.stiffer + _SMALL)
    return (read(now.model, now.values, [stiffer])[0] - here)[None] / _SMALL


def _later(trace: Trace, reading: np.ndarray, kind: Kind) -> np.ndarray:
    """Change of a reading with its delay, in samples, or with the share by which its clock is fast, (1, n)."""
    return -np.gradient(reading)[None] * (np.arange(len(trace.time)) if kind == "clock" else 1.0)


def _by_itself(now: Fit, trace: Trace, kind: Kind) -> tuple[np.ndarray, np.ndarray]:
    """The numbers of a held-out record and their errors, (q,), from what the model misses of it."""
    sizes = np.zeros(_EACH[kind])
    for _ in range(_ROUNDS):
        own = read_apart(trace, kind, sizes)
        left = (own.response - read(now.model, now.values, [own])[0])[own.counted] / own.noise.sigma
        slopes = _slopes(now, own, kind)[:, own.counted] / own.noise.sigma
        if not np.all(np.any(slopes, axis=1)):  # it does not move
            return np.zeros(len(sizes)), np.full(len(sizes), np.inf)
        back = np.linalg.pinv(slopes.T)
        sizes, errors = sizes + back @ left, np.linalg.norm(back, axis=1)
    return sizes, errors


def _with(campaign: Campaign, kind: Kind, sizes: np.ndarray) -> Campaign:
    """The campaign with traces that differ."""
    own = iter(sizes)
    told = (read_apart(r, kind, next(own)) if isinstance(r, Trace) else r for r in campaign.records)
    return replace(campaign, records=tuple(told))
