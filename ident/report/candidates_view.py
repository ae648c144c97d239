"""The candidates of a diagnosis as tables: those at its first model, and those that stood against each later step."""

from __future__ import annotations

from ..campaign.device import Device
from ..diagnosis.answer import Diagnosis
from ..diagnosis.ranking.score import NAMED_BY_CHANCE
from ..diagnosis.ranking.weigh import Candidate
from ..fit import Fit
from .words.quantity import show
from .words.sheet import Column, Mark, Sheet

_LISTED = 6
_LISTED_LATER = 3  # of a later step, beside what it added


def ranking_sheet(found: Diagnosis) -> Sheet:
    """The best candidates at the first model: share of the excess error that each would remove, as scored and as
    confirmed by a refit. Of an excess that is noise no share is told: any candidate may take all of it, or none."""
    loop = found.discovery
    nothing = loop.verdict == "adequate"
    rows: list[tuple[str, ...]] = []
    marks: list[Mark] = []
    for candidate in loop.ranking[:_LISTED]:
        shares = _percent(candidate.predicted_gain), _percent(loop.confirmed.get(candidate.name))
        chance = "< 1e-15" if candidate.p_value < 1e-15 else f"{candidate.p_value:.1g}"
        rows.append((candidate.name, *(() if nothing else shares), _size(candidate, loop.start), chance))
        sure = candidate.p_value * max(len(loop.ranking), 1) < NAMED_BY_CHANCE
        marks.append("" if sure else "quiet")
    told = () if nothing else (Column("predicted", True), Column("confirmed", True))
    columns = (
        Column("candidate", wraps=True), *told, Column("estimated size", wraps=True), Column("by chance", True),
    )  # fmt: skip
    if nothing:
        note = (
            "what is left is noise, of which a share means nothing; by chance: how often noise alone makes such a size"
        )
        return Sheet("Nothing is missing; nearest to it come", columns, tuple(rows), tuple(marks), note)
    note = "share of the error beyond noise that the effect removes: as scored, and in a refit of the full simulation"
    return Sheet("Which effect is missing?", columns, tuple(rows), tuple(marks), note)


def later_sheet(found: Diagnosis) -> Sheet | None:
    """What each later step added, and the candidates that stood against it; None if none did against any."""
    rows: list[tuple[str, ...]] = []
    marks: list[Mark] = []
    for step in found.discovery.steps[1:]:
        if step.rivals:
            rows.append((f"+ {step.added}", "", _percent(step.predicted_gain), _percent(step.confirmed_gain)))
            marks.append("")
        for rival in step.rivals[:_LISTED_LATER]:
            rows.append(("", rival.name, _percent(rival.predicted_gain), _percent(rival.confirmed_gain)))
            marks.append("quiet")
    if not rows:
        return None
    columns = (
        Column("step", wraps=True), Column("instead", wraps=True), Column("predicted", True), Column("confirmed", True),
    )  # fmt: skip
    note = "share of what the step before had left beyond noise"
    return Sheet("And then? What stood against each later step", columns, tuple(rows), tuple(marks), note)


def _percent(gain: float | None) -> str:
    if gain is None:
        return "–"
    return f"{100 * min(gain, 1.0):.1f} %" if gain > 0 else "none"


def _size(candidate: Candidate, fitted: Fit) -> str:
    device: Device = fitted.model.device
    units = candidate.units
    parts = []
    for name, error in candidate.errors.items():
        parts.append(f"{name} {show(candidate.values[name], error, units[name], device)}")
    return ", ".join(parts)
