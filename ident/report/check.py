"""The judgement of data alone, before any model: what `ident check` prints, as a value."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from html import escape
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ..campaign.campaign import Campaign
from ..campaign.quality.exchanged import exchanged
from ..campaign.quality.suspect import Suspect, suspects_by_data
from ..campaign.read import read_campaign
from ..campaign.trust import is_trusted
from ..threads import one_thread
from .words.data import about, judgement_dict, judgement_sheet, remarks, what_the_records_tell
from .words.sheet import Sheet, sheet_text
from .words.sweeps import run_sheet

if TYPE_CHECKING:
    from pandas import DataFrame

_WIDTH = 100


@dataclass(frozen=True, eq=False)
class Check:
    """A campaign and what its data say: `suspects`, records that something is wrong with; `strangers`, effect files
    that have not run here, which a fit would refuse."""

    campaign: Campaign
    suspects: tuple[Suspect, ...]
    strangers: tuple[Path, ...]

    @property
    def tells_apart(self) -> tuple[str, ...]:
        """What the records together can and cannot tell apart, in words."""
        return what_the_records_tell(self.campaign)

    @property
    def parts(self) -> Iterator[str | Sheet]:
        """Everything there is to say: lines, and a table."""
        data = self.campaign
        yield from (data.title, "", judgement_sheet(data))
        for record in data.records:
            yield about(record, data)
            yield from (f"  ! {remark}" for remark in remarks(record, data))
        if data.sweeps:
            yield from ("", run_sheet(data))
        if data.notes:
            yield from ("\nAssumed and found", *(f"  {note}" for note in data.notes))
        for path in self.strangers:
            yield f"  ! {path} has not run here: a fit needs --trust, and whether it is right was not checked"
        yield from (f"  ! {sentence}" for sentence in exchanged(data))
        yield from (f"  ! {suspect.sentence}" for suspect in self.suspects)
        if not data.fitted and not data.fitted_sweeps:
            yield "  ! a fit needs at least one record that is not held out"
        yield from ("\nWhat these records tell apart", *(f"  {sentence}" for sentence in self.tells_apart))

    def as_json(self) -> dict[str, Any]:
        """What was judged of the data, as plain numbers (SI) and words."""
        return judgement_dict(self.campaign)

    def to_dataframe(self) -> DataFrame:
        """One row a record: use, samples, rms and noise floor (SI), and what is unusual, as a pandas table."""
        from pandas import DataFrame

        told = self.as_json()["records"]
        rows = [
            (r["holdout"], r["samples"], r.get("size"), r["noise"]["sigma"], "; ".join(remarks(record, self.campaign)))
            for r, record in zip(told, self.campaign.records, strict=True)
        ]
        return DataFrame(
            rows, columns=["held out", "samples", "rms", "noise", "remarks"], index=[r["file"] for r in told]
        )

    def __str__(self) -> str:
        return "\n".join(part if isinstance(part, str) else sheet_text(part, _WIDTH) for part in self.parts)

    def __repr__(self) -> str:
        suspects = f"; suspect: {', '.join(s.file for s in self.suspects)}" if self.suspects else ""
        return f"<Check of {len(self.campaign.records)} records{suspects}>"

    def _repr_html_(self) -> str:
        said = [*self.campaign.notes, *(s.sentence for s in self.suspects), *self.tells_apart]
        return self.to_dataframe().to_html() + "".join(f"<p>{escape(sentence)}</p>" for sentence in said)


@one_thread
def check(data: Any, columns: Mapping[str, str | int] | None = None, **told: Any) -> Check:
    """Read and judge data without any model; `print(ident.check("a.csv"))` says what `ident check` says.

    **Arguments:** as of `ident.read_campaign`.

    **Raises:** UserError for data that cannot be used, and for what a fit would refuse about the model.
    """
    campaign = read_campaign(data, columns, **told)
    strangers = tuple(path for path in campaign.effect_files if not is_trusted(path))
    if not strangers and (campaign.effects or campaign.settings or campaign.priors or campaign.effect_files):
        from ..model import build_model

        build_model(campaign)  # what a fit would refuse about the model is refused here
    return Check(campaign, suspects_by_data(campaign), strangers)
