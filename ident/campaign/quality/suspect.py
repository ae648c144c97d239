"""Records that something is wrong with, as far as the data alone can tell: listed twice, clipped, outliers, drift."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any, Literal

import numpy as np

from ..campaign import Campaign
from ..record import Trace
from .clipping import CLIPPED
from .judge import drifts, judge

Kind = Literal["delay", "gain", "sign", "time-scale", "wrong-record", "clipping", "spikes", "drift", "duplicate"]

ALL = "all records"
"""In place of a file: what is wrong in the same way with all of them."""
_UNPLACED = (
    "a lag that no record can place: of the trigger, a filter, the amplifier or the sensor? Correct the times if it "
    "is the instrument's, or add a lag of the drive or of the sensor"
)

ADVICE: dict[Kind, str] = {
    "delay": "is its trigger that of the others? Correct the times",
    "gain": "was a range or a probe switched? Correct the unit or the column",
    "sign": "is a probe reversed? Turn the sign of the column",
    "time-scale": "is the unit of its time, or its sampling rate, right? Correct it",
    "wrong-record": "does this file belong to this drive, device and load? Find the right one",
    "clipping": "measure again, in a wider range if it left its range",
    "spikes": "what the neighbours say took their place; look at the sensor if there are many",
    "drift": "let it settle, or take the drift out before; a model would need a drift of the sensor",
    "duplicate": "list it once: twice makes error bars too small",
}
_KEPT: tuple[Kind, ...] = ("spikes", "drift", "duplicate")  # the record is of use as it is


@dataclass(frozen=True)
class Suspect:
    """A record that disagrees in a way that no device explains.

    **Arguments:** `size` in `unit`; `probability` that the record is faulty; `says`: the finding in words, without the
    name of the file; `first`: whether it explains more than any effect does, so that no physics is named before;
    `settles`: whether so read, and with one effect at most, all records stand at their noise; `left`: what they leave
    where they do not, χ² per sample.
    """

    file: str
    kind: Kind
    size: float
    unit: str
    probability: float
    says: str
    first: bool = False
    settles: bool = True
    left: float = 0.0

    @property
    def sentence(self) -> str:
        """What is wrong and what to do."""
        instead = "" if self.file == ALL or self.kind in _KEPT else ", or leave the record out"
        return self.left_out.removesuffix(".") + f"{instead}."

    @property
    def left_out(self) -> str:
        """What is wrong and what to do with a record that is left out already."""
        do = _UNPLACED if self.file == ALL else ADVICE[self.kind]
        return f"{self.file}: {self.says} ({100 * self.probability:.0f} %): {do}."

    def as_json(self) -> dict[str, Any]:
        """As it stands in diagnosis.json under "records"."""
        return {"file": self.file, "suspect": self.kind, "size": self.size, "unit": self.unit,
                "probability": self.probability, "words": self.sentence}  # fmt: skip


def set_aside(campaign: Campaign, suspects: Sequence[Suspect]) -> Campaign:
    """The campaign without its fitted traces that are suspect, which it then has as `left_out`."""
    why = {suspect.file: suspect for suspect in suspects}
    gone = [record for record in campaign.fitted if record.name in why]
    left_out = (*campaign.left_out, *((record, why[record.name]) for record in gone))
    return replace(campaign, records=tuple(r for r in campaign.records if r not in gone), left_out=left_out)


def suspects_by_data(campaign: Campaign) -> tuple[Suspect, ...]:
    """What the records alone tell, without any model."""
    found: list[Suspect] = []
    traces = campaign.traces
    begins = np.array([record.response[:_BEGIN] for record in traces])
    for k, record in enumerate(traces):
        near = np.flatnonzero(np.max(np.abs(begins[:k] - begins[k]), axis=1, initial=0.0) <= _allowed(record))
        twin = next((traces[j] for j in near if _same(traces[j], record)), None)
        if twin is not None:
            says = f"the response is sample by sample that of {twin.name}"
            found.append(Suspect(record.name, "duplicate", 1.0, "records", 1.0, says))
        if record.stuck > CLIPPED:
            says = f"{record.stuck:.1%} of the response sticks to a limit; those samples have no weight"
            found.append(Suspect(record.name, "clipping", 100 * record.stuck, "%", 0.99, says))
        if record.outliers:
            count = len(record.outliers)
            says = f"{count} sample{'s leave' if count > 1 else ' leaves'} the curve"
            found.append(Suspect(record.name, "spikes", float(count), "samples", 0.99, says))
        judged = judge(record)
        if drifts(record, judged.drift, judged.size):
            share = 100 * abs(judged.drift) / judged.size
            says = f"the mean moves by {share:.0f} % of the rms response"
            found.append(Suspect(record.name, "drift", share, "% of rms", 0.5, says))
    return tuple(found + _curves_twice(campaign))


def _curves_twice(campaign: Campaign) -> list[Suspect]:
    """Sweeps of which an earlier one has all points, in whichever order and however many more."""
    found = []
    tables = [np.column_stack([s.frequency, s.amplitude, np.zeros_like(s.frequency) if s.phase is None else s.phase])
              for s in campaign.sweeps]  # fmt: skip
    for k, sweep in enumerate(campaign.sweeps):
        rows = set(map(tuple, tables[k].tolist()))
        twin = next((j for j in range(k) if rows <= set(map(tuple, tables[j].tolist()))), None)
        if twin is not None:
            says = f"its curve is point by point in {campaign.sweeps[twin].name}"
            found.append(Suspect(sweep.name, "duplicate", 1.0, "records", 1.0, says))
    return found


_BEGIN = 8  # samples, which tell most records apart


def _allowed(record: Trace) -> float:
    """By how much samples of one and the same recording may differ: digits that were printed."""
    return 1e-9 * float(np.std(record.response))


def _same(one: Trace, other: Trace) -> bool:
    """Whether two responses are one recording: noise never repeats."""
    if len(one.response) != len(other.response):
        return False
    return float(np.max(np.abs(one.response - other.response))) <= _allowed(other)
