"""Profile likelihood: one parameter is held at values around its optimum and the others are fitted again.

The square root of the rise of Σ r² against the parameter is a straight line where the error bar may be trusted. A
profile that rises on both sides is closed; one that does not rise shows a parameter that the data leave open.

Source: D. M. Bates, D. G. Watts, Nonlinear Regression Analysis and Its Applications, 1988, §6.1.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Any, Literal, NamedTuple

import numpy as np

from ..errors import UserError
from ..model import QUALITY, Model, ModelParameter
from ..pulse import Report
from ..response import lay_out
from ..threads import one_thread
from ..units import format_quantity
from . import solve
from .access import position
from .assemble import assemble, at_values, begin
from .on_orbits import on_orbits
from .problem import Data, Static, Unknowns, evaluate
from .result import Fit

Kind = Literal["closed", "one-sided", "flat", "failed"]
_DECADE = float(np.log(10.0))
_CLOSED = 3.84  # rise of Σ r² at which a value is excluded with 95 % confidence (χ² of one number)
_EXTENSIONS = 3  # how often the grid is widened, each time twofold, on a side that has not risen yet
_BETTER = 0.1  # fall of Σ r² below the optimum that is more than rounding


@dataclass(frozen=True, eq=False)
class Profile:
    """How the best error rises as one parameter is moved away from its optimum.

    **Arguments:**

    - `name`, `unit`: of the parameter; `optimum`: its fitted value, SI.
    - `values`: (k,) where it was held, SI, rising; `rise`: (k,) of Σ r², in units where 1 is one standard error.
    - `kind`: "closed", "one-sided", "flat", or "failed" (most fits did not converge).
    - `low`, `high`: ends of the 68 % interval; None where the profile does not rise.
    - `better`: (m,) all parameters of a better optimum found on the way, else None.
    - `failures`: number of fits that did not converge.
    """

    name: str
    unit: str
    optimum: float
    values: np.ndarray
    rise: np.ndarray
    kind: Kind
    low: float | None
    high: float | None
    better: np.ndarray | None
    failures: int

    @property
    def sentence(self) -> str:
        """The profile in words."""
        low, high = self._shown(self.low), self._shown(self.high)
        words = {
            "closed": f"closed: between {low} and {high} (68 %)",
            "one-sided": f"one-sided: below {high}, without lower limit" if self.low is None else
                         f"one-sided: above {low}, without upper limit",
            "flat": "flat: the records do not determine it",
            "failed": f"failed: {self.failures} of {len(self.values)} fits did not converge; nothing follows from it",
        }[self.kind]  # fmt: skip
        text = f"Profile of {self.name} ({self._shown(self.optimum)}): {words}."
        if self.better is None:
            return text
        at = self._shown(float(self.values[int(np.nanargmin(self.rise))]))
        return f"{text} A better optimum lies near {at}: fit again from there, the present result is not the best."

    def _shown(self, value: float | None) -> str:
        """A value with two digits of the narrower half of the interval."""
        if value is None:
            return "none"
        ends = [end for end in (self.low, self.high) if end is not None and end != self.optimum]
        finest = min((abs(end / self.optimum - 1) for end in ends if self.optimum), default=1.0)
        digits = int(np.clip(2 - np.floor(np.log10(max(finest, 1e-12))), 3, 14))
        return format_quantity(value, self.unit, digits)

    def as_dict(self) -> dict[str, Any]:
        """Plain numbers for a JSON file."""
        return {
            "name": self.name,
            "unit": self.unit,
            "kind": self.kind,
            "optimum": self.optimum,
            "low": self.low,
            "high": self.high,
            "values": self.values.tolist(),
            "rise": [float(r) if np.isfinite(r) else None for r in self.rise],
            "failures": self.failures,
            "better_optimum": None if self.better is None else self.better.tolist(),
        }


def check_profiled(model: Model, names: Sequence[str]) -> None:
    """Whether parameters can be profiled. **Raises:** UserError if one does not exist or is not fitted."""
    known = [p.name for p in model.parameters]
    for name in names:
        if not model.parameters[position(known, name)].fitted:
            raise UserError(f"{name} is held, so it has no profile", do='add it to free = ["…"] of its effect')


class _Point(NamedTuple):
    """One fit: `at`, the coordinate of the held parameter; `rise` of Σ r²; all `values`; whether it `converged`."""

    at: float
    rise: float
    values: np.ndarray
    converged: bool


@one_thread
def profile(fit: Fit, name: str, *, robust: bool = False, report: Report = lambda _: None) -> Profile:
    """Profile one fitted parameter: ±3 standard errors around the optimum, or a decade if it is undetermined.

    **Arguments:** `name`: as in `fit[name]`; `robust`: as the fit was made; `report`: called with progress.

    **Raises:** UserError if there is no such parameter, or if it is held.
    """
    check_profiled(fit.model, [name])
    index = position([p.name for p in fit.model.parameters], name)
    name = fit.model.parameters[index].name
    parameter, optimum = fit.model.parameters[index], float(fit.values[index])
    logarithmic, width, inflation = _steps(fit, index)
    static, data = _problem(fit, name)
    held = partial(_fit_held, static, data, index, logarithmic, robust)
    report(f"profile of {name}: compiling the model without it")
    centre = float(np.log(optimum)) if logarithmic else optimum
    first = held(centre, fit.values)
    base = first.rise
    points = [first._replace(rise=0.0)]
    for side in (-1, 1):
        values, factor, step = first.values, 0.0, 1.0
        for number in range(3 + _EXTENSIONS):
            factor, step = factor + step, step * (2.0 if number >= 2 else 1.0)
            if parameter.positive and not logarithmic and centre + side * factor * width <= 0:
                break
            report(f"profile of {name}: {side * factor:+g} {'standard errors' if inflation else 'steps'}")
            point = held(centre + side * factor * width, values)
            points.append(point._replace(rise=(point.rise - base) / (inflation or 1.0)))
            values = point.values if point.converged else values
            if number >= 2 and points[-1].rise > _CLOSED:
                break
    return _judge(parameter, optimum, sorted(points), logarithmic, converged=first.converged)


def _steps(fit: Fit, index: int) -> tuple[bool, float, float]:
    """How to walk: along the logarithm or not, the step, and the factor between its square and the white noise's.

    The step is one standard error; positive parameters are walked along their logarithm unless zero is near. Without a
    standard error it is a third of a decade, and the factor is 0.
    """
    k, value = fit.free.index(index), float(fit.values[index])
    error, spectrum, positive = fit.estimates[index].standard_error, fit.spectrum, fit.model.parameters[index].positive
    if error is None:
        size = abs(value) or 1.0 / max(float(spectrum.lengths[k]), 1e-300)
        return positive, _DECADE / 3 if positive else 3 * size, 0.0
    seen = spectrum.singular_values > 1e-6 * spectrum.singular_values[0]
    white = float(np.sum((spectrum.directions[k, seen] / spectrum.singular_values[seen]) ** 2))
    white /= float(spectrum.lengths[k] or 1.0) ** 2
    scaled = fit.fitted.error_over_noise**2 if fit.sigma == "scaled" and fit.fitted is not None else 1.0
    inflation = scaled * float(spectrum.matrix[k, k]) / white if white > 0 else 1.0
    logarithmic = positive and error < value * _DECADE / 3
    return logarithmic, error / value if logarithmic else error, inflation


def _problem(fit: Fit, name: str) -> tuple[Static, Data]:
    model = replace(fit.model, held=fit.model.held | {name}, freed=fit.model.freed - {name})
    records = fit.campaign.fitted
    tape = lay_out(records, 1.0 / fit.scales.period, float(fit.values[QUALITY]), fit.model)
    of_sweeps = {"curves": fit.solved.data.curves, "passes": fit.solved.data.passes}
    static, data = assemble(model, fit.campaign, records, tape, fit.values, **of_sweeps)
    if data.start_scale.any():  # the steady ones of the fit are steady here
        begun = fit.solved.found.starts / np.where(data.start_scale > 0, data.start_scale, 1.0)
        static, data, _ = on_orbits(static, data, records, Unknowns(np.zeros(len(static.free)), begun))
    return static._replace(width=len(fit.free) + 2 * static.starts_free), data  # the program of the fit


def _fit_held(
    static: Static, data: Data, index: int, logarithmic: bool, robust: bool, at: float, values: np.ndarray
) -> _Point:
    """The best fit with one parameter held at the coordinate `at`, begun at `values` (m,) SI."""
    start = np.array(values, float)
    start[index] = np.exp(at) if logarithmic else at
    if not static.free:  # nothing else to fit: the error itself
        found = evaluate(static, at_values(data, static, start), begin(data, static))
        cost = float(found.residuals @ found.residuals)
        return _Point(at, cost, start, bool(np.isfinite(cost)))
    begun = at_values(data, static, start), begin(data, static)
    _, solution = solve.least_squares(static, *begun, solve.How(robust))
    end = solution.found.values
    usable = solution.converged and bool(np.all(np.isfinite(end)))
    return _Point(at, solution.cost if usable else np.nan, end if usable else start, usable)


def _judge(
    parameter: ModelParameter, optimum: float, points: list[_Point], logarithmic: bool, converged: bool
) -> Profile:
    at, rise = np.array([p.at for p in points]), np.array([p.rise for p in points])
    failures = sum(not p.converged for p in points)
    centre = int(np.flatnonzero(rise == 0.0)[0]) if converged else 0
    low = _crossing(at[centre::-1], rise[centre::-1])
    high = _crossing(at[centre:], rise[centre:])
    closed = [bool(np.nanmax(side, initial=0.0) > _CLOSED) for side in (rise[: centre + 1], rise[centre:])]
    kind: Kind = "closed" if all(closed) else "one-sided" if any(closed) else "flat"
    if not converged or 2 * failures > len(points):
        kind = "failed"
    best = min((p for p in points if p.converged), key=lambda p: p.rise, default=None)
    better = best.values if best is not None and best.rise < -_BETTER else None
    return Profile(
        parameter.name,
        parameter.unit,
        optimum,
        np.exp(at) if logarithmic else at,
        rise,
        kind,
        _physical(low, logarithmic) if kind != "failed" and closed[0] else None,
        _physical(high, logarithmic) if kind != "failed" and closed[1] else None,
        better,
        failures,
    )


def _crossing(at: np.ndarray, rise: np.ndarray) -> float | None:
    """Where the rise passes 1, by a straight line through its square root; None if it does not."""
    known = np.isfinite(rise)
    at, root = at[known], np.sqrt(np.maximum(rise[known], 0.0))
    for k in range(1, len(at)):
        if root[k] >= 1.0 > root[k - 1]:
            share = (1.0 - root[k - 1]) / (root[k] - root[k - 1])
            return float(at[k - 1] + share * (at[k] - at[k - 1]))
    return None


def _physical(at: float | None, logarithmic: bool) -> float | None:
    if at is None:
        return None
    return float(np.exp(at)) if logarithmic else at
