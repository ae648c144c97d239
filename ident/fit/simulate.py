"""The forward model of records: what it says that their sensor shows, at values that were found or are asked about."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from ..campaign.campaign import Campaign
from ..campaign.read import read_campaign
from ..campaign.record import Trace
from ..errors import UserError, nearest
from ..model import Model
from ..pulse import Report
from ..threads import one_thread
from .change_values import changed_values
from .fit_data import Effects, model_for
from .linear.guess import data_scales, guess_linear
from .linear.start_model import with_drives
from .reading import read
from .result import Fit
from .starts import base_values

if TYPE_CHECKING:
    from pandas import DataFrame

State = tuple[Model, Campaign, np.ndarray]


class Simulation(NamedTuple):
    """A model at `values` (m,) SI, and its `readings` (n,) SI of the `records`: `simulation["a.csv"]`."""

    model: Model
    values: np.ndarray
    records: tuple[Trace, ...]
    readings: tuple[np.ndarray, ...]

    def reading(self, name: str) -> np.ndarray:
        """(n,) reading of one record, SI."""
        return self.readings[self.records.index(wanted(self.records, [name])[0])]

    @property
    def parameters(self) -> dict[str, float]:
        """Every parameter with its value, SI."""
        return {p.name: float(v) for p, v in zip(self.model.parameters, self.values, strict=True)}

    def to_dataframe(self) -> DataFrame:
        """Record, time, drive and reading (SI), one row a sample, as a pandas table."""
        from pandas import DataFrame, concat

        pairs = zip(self.records, self.readings, strict=True)
        return concat(
            [DataFrame({"record": r.name, "time": r.time, "drive": r.drive, "reading": said}) for r, said in pairs],
            ignore_index=True,
        )

    def __repr__(self) -> str:
        effects = ", ".join(self.model.names) or "the linear model"
        return f"<Simulation of {len(self.records)} records by {effects}>"


@one_thread
def simulate(
    data: Any,
    effects: Effects = None,
    *,
    values: Mapping[str, float | str] | None = None,
    records: Sequence[str] = (),
    report: Report = lambda _: None,
    **told: Any,
) -> Simulation:
    """What a model says for the drive of every record; the initial state of one that does not start at rest is fitted.

    **Arguments:** `data`: a Fit, whose values are taken, or what `read_campaign` reads (with `told`), where a fit would
    start; `effects`: as in `ident.fit`; `values`: parameters to change, SI or with a unit ({"quality": 40}); `records`:
    names of those wanted, () for all.

    **Raises:** UserError for data or names that cannot be used.
    """
    if isinstance(data, Fit):
        state = data.model, data.campaign, data.values
    else:
        campaign = with_drives(read_campaign(data, **told))
        state = start_state(campaign, model_for(campaign, effects, report))
    return simulate_state(state, values or {}, records, report)


def start_state(campaign: Campaign, model: Model) -> State:
    """A model where its fit to a campaign would start."""
    if not campaign.traces:
        raise UserError("the campaign has no traces", do="a forward model needs the drive of a trace")
    guess = guess_linear(campaign.traces, model.linear.nominal_frequency, mass=model.linear.mass)
    return model, campaign, base_values(model, guess, data_scales(campaign.traces, guess.frequency))


def simulate_state(
    state: State, values: Mapping[str, float | str], records: Sequence[str], report: Report = lambda _: None
) -> Simulation:
    """The same from model, campaign and values."""
    model, campaign, known = state
    changed = changed_values(model, known, values, campaign.order)
    # Of what a zero of a record's own is read by, a change of the values changes nothing.
    traces = [replace(trace, floats=False) for trace in campaign.traces]
    chosen = wanted(traces, records) if records else traces
    if not chosen:
        raise UserError("the campaign has no traces", do="a forward model needs the drive of a trace")
    report(f"compiling the model and simulating {len(chosen)} records")
    return Simulation(model, changed, tuple(chosen), tuple(read(model, changed, chosen)))


def wanted(traces: Sequence[Trace], names: Sequence[str]) -> list[Trace]:
    """The traces of these names. **Raises:** UserError with the nearest name, if there is none."""
    known = [trace.name for trace in traces]
    for name in names:
        if name not in known:
            do = nearest(name, known, f"the traces are {', '.join(known) or 'none'}")
            raise UserError(f"there is no trace called {name!r}", do=do)
    return [trace for trace in traces if trace.name in names]
