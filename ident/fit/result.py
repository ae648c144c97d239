"""What a fit returns: the model with its values, their uncertainties, and its reading of every record."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any, Literal, NamedTuple

import numpy as np

from ..campaign.campaign import Campaign
from ..campaign.record import Trace
from ..model import Model
from ..response import ALLOWED, divided
from . import access
from .curve_reading import CurveReading
from .curves import in_smaller_steps
from .identifiability import Combination
from .judge import GOOD, RecordScore, Score, combine
from .linear.guess import DataScales
from .passes import in_smaller_steps as smaller_steps
from .predict import Prediction, predict
from .problem import Data, Evaluation, Static, Unknowns, readings
from .steady import no_orbit
from .uncertainty import Covariance, Linearisation
from .zeros import numbers_of_zeros

if TYPE_CHECKING:
    from pandas import DataFrame

    from .own_number import OwnNumber

SigmaChoice = Literal["known", "scaled", "fitted"]
NEGLIGIBLE_STEP = 0.1  # noise floors that halving the solver's step may change


class Start(NamedTuple):
    """One start of a fit: the error over noise where it began and ended, steps taken, whether it converged."""

    begin: float
    end: float
    steps: int
    converged: bool


class Estimate(NamedTuple):
    """One parameter as reported; `standard_error` is None where none can be given, and `flags` say why."""

    name: str
    value: float
    standard_error: float | None
    unit: str
    fitted: bool
    flags: tuple[str, ...]

    @property
    def error(self) -> float | None:
        """The standard error."""
        return self.standard_error


class Solved(NamedTuple):
    """The arrays of a fit and the model at its minimum, initial states included."""

    static: Static
    data: Data
    unknowns: Unknowns
    found: Evaluation


@dataclass(frozen=True, eq=False)
class Fit:
    """A model fitted to a campaign; a value, changed only by fitting again.

    **Arguments:**

    - `values`: (m,) SI, in the order of `model.parameters`; `estimates`: the same with uncertainties and flags.
    - `free`: positions of the fitted parameters; `covariance`: (p, p) of their physical values.
    - `combinations`: what is determined of the parameters that are not determined one by one.
    - `readings`: model reading of each trace of the campaign, in the campaign's order, m.
    - `curves`: model reading of each sweep, in the campaign's order.
    - `starts`: every start and where it ended; `sigma`: which standard deviation the error bars stand on.
    - `linear`: the fit as a linear regression, and `solved`: its arrays, for diagnosis.
    """

    model: Model
    campaign: Campaign
    values: np.ndarray
    estimates: tuple[Estimate, ...]
    free: tuple[int, ...]
    covariance: np.ndarray
    combinations: tuple[Combination, ...]
    readings: tuple[np.ndarray, ...]
    scores: tuple[RecordScore, ...]
    starts: tuple[Start, ...]
    sigma: SigmaChoice
    converged: bool
    scales: DataScales
    spectrum: Covariance
    linear: Linearisation
    solved: Solved
    curves: tuple[CurveReading, ...] = ()

    @cached_property
    def begun_otherwise(self) -> list[tuple[str, float]]:
        """Records that do not begin as they are said to, as of `start_score.begun_otherwise`."""
        from .start_score import begun_otherwise

        return begun_otherwise(self)

    @cached_property
    def off_orbit(self) -> list[tuple[str, str]]:
        """Fitted records that are called steady, and why their initial state is fitted all the same."""
        called = [(k, record) for k, record in enumerate(self.campaign.fitted) if record.start == "steady"]
        on = {one.record for one in self.solved.data.steady} if called else set()
        return [(record.name, no_orbit(record, self.solved.static.equation)) for k, record in called if k not in on]

    @cached_property
    def own_numbers(self) -> tuple[OwnNumber, ...]:
        """Held-out levels of sweeps which ask for another drive, resonance or damping, as of `own_number`."""
        from .own_number import own_numbers

        return own_numbers(self)

    @cached_property
    def step_error(self) -> float:
        """Largest discretisation error of any fitted record, in units of its noise floor, by halving the step, and by
        allowing a quarter where it meets a kink."""
        static, data, unknowns, found = self.solved
        steps, records = [2 * span.substeps for span in data.tape.spans], self.campaign.fitted
        finer = readings(static, data._replace(tape=divided(records, steps, ALLOWED / 4)), unknowns)
        change = np.abs(found.readings - finer)
        largest = [np.max(change[own]) / r.noise.sigma for own, r in zip(data.tape.slices, records, strict=True)]
        if data.curves is not None:
            once, twice = (
                c.residuals(c.solve(static.equation, self.values)) for c in (data.curves, in_smaller_steps(data.curves))
            )
            largest.append(np.max(np.abs(once - twice)))
        if data.passes is not None:
            once, twice = (
                p.residuals(p.solve(static.equation, self.values, np.zeros((0, len(self.values))), static.width))
                for p in (data.passes, smaller_steps(data.passes))
            )
            largest.append(np.max(np.abs(once - twice)))
        return float(max(largest))

    @property
    def trace_scores(self) -> tuple[RecordScore, ...]:
        """Errors on the traces alone, in the campaign's order."""
        pairs = zip(self.campaign.records, self.scores, strict=True)
        return tuple(score for record, score in pairs if isinstance(record, Trace))

    @property
    def fitted(self) -> Score:
        score = combine([s for s in self.scores if not s.holdout])
        assert score is not None  # a fit has at least one fitted record
        return score

    @property
    def holdout(self) -> Score | None:
        return combine([s for s in self.scores if s.holdout])

    @property
    def freedom(self) -> int:
        """How many numbers the records need: determined parameters, combinations of those that are not, and zeros that
        records have of their own.

        Of an effect's several amplitudes those that are zero within two errors could as well be left out.
        """
        needed = len(self.combinations) + numbers_of_zeros(self.campaign.fitted)
        small: dict[str, list[bool]] = {}
        for i in self.free:
            parameter, estimate = self.model.parameters[i], self.estimates[i]
            if "undetermined" in estimate.flags:
                continue
            if parameter.kind == "amplitude" and estimate.standard_error:
                small.setdefault(parameter.effect, []).append(abs(estimate.value) < 2 * estimate.standard_error)
            else:
                needed += 1
        return needed + sum(max(1, flags.count(False)) for flags in small.values())

    @property
    def trusted(self) -> bool:
        """Whether the model describes the records well enough for its error bars to mean anything."""
        return self.converged and self.fitted.error_over_noise <= GOOD

    def value(self, name: str) -> float:
        """Value of one parameter, SI."""
        return self[name].value

    def __getitem__(self, name: str) -> Estimate:
        """The estimate of one parameter: `fit["quality"].value`, `.error`, `.unit`."""
        return self.estimates[access.position([e.name for e in self.estimates], name)]

    def __repr__(self) -> str:
        return access.line(self)

    def _repr_html_(self) -> str:
        return access.html(self)

    def to_dataframe(self) -> DataFrame:
        """Every parameter with its value, error, unit and flags, as a pandas table."""
        return access.parameters_frame(self)

    @property
    def labelled_covariance(self) -> DataFrame:
        """Covariance of the fitted parameters (SI) as a pandas table with their names."""
        return access.covariance_frame(self)

    @property
    def residuals(self) -> dict[str, np.ndarray]:
        """Per record (n,) measured − model, SI."""
        return access.residuals(self)

    def predict(self, data: Any, values: Mapping[str, float | str] | None = None) -> Prediction:
        """What the model says of a drive, with its error: `fit.predict({"time (ms)": t, "drive (V)": u}).reading`.

        **Arguments:** `data`: a record, or its name in the campaign, whose initial state is fitted unless it starts at
        rest; or a drive, from a file or from memory, that begins at rest. `values`: parameters to change, SI or with a
        unit ({"quality": 40, "frequency": "0.6 kHz"}); they count as known.
        """
        return predict(self, data, values)
