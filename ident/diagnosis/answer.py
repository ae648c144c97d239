"""The answer of a diagnosis."""

from __future__ import annotations

from dataclasses import dataclass
from html import escape
from pathlib import Path
from typing import TYPE_CHECKING

from ..campaign.quality.suspect import Suspect
from ..fit import Fit
from .next_record.experiments import NextExperiment
from .search.steps import Discovery, Verdict
from .search.ties import Unseen
from .unknown.find import Unknown
from .where.locate import Where
from .where.words import summary

if TYPE_CHECKING:
    from pandas import DataFrame


@dataclass(frozen=True, eq=False)
class Diagnosis:
    """Answers about a fit.

    **Arguments:** `where`: where the first fit of the walk fails; `unknown`: what the library lacks, if it lacks
    something, and `effect_file`, where that was written; `next_experiments`: records that would separate what ties;
    `unseen`: effects of which these records cannot say anything; `suspects`: records that something is wrong with. A
    faulty record that explains more than any effect does is left out of the walk. This has no steps, but for that of a
    sensor's zero, if the others are too few for that, or if one law that the library lacks says everything and nobody
    said where to write it.
    """

    discovery: Discovery
    where: Where
    unknown: Unknown | None = None
    effect_file: Path | None = None
    next_experiments: tuple[NextExperiment, ...] = ()
    unseen: tuple[Unseen, ...] = ()
    suspects: tuple[Suspect, ...] = ()

    @property
    def summary(self) -> str:
        """Where the first fit of the walk fails, in one paragraph."""
        return summary(self.where)

    @property
    def verdict(self) -> Verdict:
        """Whether something is missing, and how sure its name is."""
        return self.discovery.verdict

    @property
    def final(self) -> Fit:
        """The fit with everything that was found."""
        return self.discovery.final

    def to_dataframe(self) -> DataFrame:
        """The candidates, best first: share of the error beyond noise that each removes, as scored and as refitted."""
        from pandas import DataFrame

        ranking, confirmed = self.discovery.ranking, self.discovery.confirmed
        rows = [(c.predicted_gain, confirmed.get(c.name), c.p_value) for c in ranking]
        return DataFrame(rows, columns=["predicted", "confirmed", "by chance"], index=[c.name for c in ranking])

    def __repr__(self) -> str:
        added = " + ".join(step.added for step in self.discovery.steps) or "nothing added"
        before, after = (f.fitted.error_over_noise for f in (self.discovery.start, self.final))
        suspect = f"; suspect: {', '.join(s.file for s in self.suspects)}" if self.suspects else ""
        return f"<Diagnosis: {self.verdict}; {added}; error over noise {before:#.3g} → {after:#.3g}{suspect}>"

    def _repr_html_(self) -> str:
        return f"<p>{escape(repr(self))}</p><p>{escape(self.summary)}</p>{self.to_dataframe().to_html()}"
