"""One self-contained HTML page for a fit: nothing on it is loaded from elsewhere."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

from ..campaign.device import Platform
from ..fit.judge import GOOD
from ..fit.result import Fit
from ..units import ratio_text
from .figures.curves import curve_figure
from .figures.dynamic_stiffness import dynamic_stiffness_figure
from .figures.overview import overview_figure
from .figures.picture import Picture, draw
from .figures.records import record_figure
from .run_state import versions
from .words.linear import linear_sheet
from .words.offsets import offset_sheet
from .words.sentences import sentences, verdict
from .words.sheet import Sheet
from .words.tables import combination_sentences, correlation_sentences, parameter_sheet, record_sheet, start_sheet

if TYPE_CHECKING:
    from jinja2 import Template

_MOST_FIGURES = 16  # more records than a reader looks at, and each figure takes time


class Section(NamedTuple):
    """A further part of the page: paragraphs, then tables, then pictures."""

    title: str
    paragraphs: Sequence[str] = ()
    sheets: Sequence[Sheet] = ()
    pictures: Sequence[Picture] = ()


class _Record(NamedTuple):
    name: str
    picture: Picture
    offset: Sheet | None


def write_report(fit: Fit, folder: Path, extra: Mapping[str, Any] | None = None) -> Path:
    """Write `report.html` and, as files of their own, the same pictures in `figures/`; returns the page's path.

    **Arguments:** `extra`: "sections" (a sequence of `Section`) are added before the provenance; every other entry
    ("command", "parent", …) becomes a line of the provenance.
    """
    folder = Path(folder)
    pictures = folder / "figures"
    pictures.mkdir(parents=True, exist_ok=True)
    overview, records, omitted = _pictures(fit)
    overview.write(pictures, "overview")
    for i, record in enumerate(records, 1):
        record.picture.write(pictures, f"{i:02d}_{_file_stem(record.name)}")
    given = dict(extra or {})
    sections = tuple(given.pop("sections", ()))
    if (seen := dynamic_stiffness_figure(fit.campaign)) is not None:
        picture = draw("Natural frequency and damping of every measured point, by amplitude and velocity", seen)
        picture.write(pictures, "before_any_fit")
        sections = (Section("The curves before any fit", pictures=(picture,)), *sections)
    page = _template().render(
        title=fit.campaign.title or "Fit",
        model=_model_words(fit),
        verdict=verdict(fit),
        good=fit.trusted,
        cards=_cards(fit),
        overview=overview,
        sentences=sentences(fit),
        parameters=parameter_sheet(fit),
        undetermined=[_sentence(text) for text in combination_sentences(fit)],
        correlations=[_sentence(text) for text in correlation_sentences(fit)],
        scores=record_sheet(fit),
        starts=start_sheet(fit),
        linear=linear_sheet(fit),
        records=records,
        omitted=omitted,
        sections=sections,
        notes=fit.campaign.notes,
        provenance=[*((str(key), str(value)) for key, value in given.items()), ("versions", _versions())],
        checksums=sorted(fit.campaign.checksums.items()),
    )
    path = folder / "report.html"
    path.write_text(page, encoding="utf-8", errors="backslashreplace")
    return path


def _pictures(fit: Fit) -> tuple[Picture, list[_Record], list[str]]:
    """The overview, the figure of each record (of the worst ones, if there are many), and the records left out."""
    device = fit.model.device
    rows = list(zip(fit.campaign.traces, fit.readings, fit.trace_scores, strict=True))
    worst = sorted(rows, key=lambda row: -row[2].error_over_noise)[:_MOST_FIGURES]
    shown = {id(row[0]) for row in worst}
    records, figures = [], {}
    for trace, reading, score in sorted(rows, key=lambda row: row[2].holdout):
        if id(trace) not in shown:
            continue
        caption = f"{trace.name}: model over data, residual in noise floors, response against the drive"
        picture = draw(caption, record_figure(trace, reading, score, device, figures))
        records.append(_Record(trace.name, picture, offset_sheet(trace, reading, device)))
    omitted = [trace.name for trace, _, _ in rows if id(trace) not in shown]
    for curve in fit.curves:
        caption = (
            f"{curve.sweep.name}: model over data, stable (solid) and unstable (dashed) responses, jumps, backbone"
        )
        records.append(_Record(curve.sweep.name, draw(caption, curve_figure(curve, fit)), None))
    return draw("Error over noise of each record", overview_figure(fit)), records, omitted


def _model_words(fit: Fit) -> str:
    linear = "linear platform" if isinstance(fit.model.device, Platform) else "linear oscillator"
    words = [name + _settings(fit, name) for name in fit.model.names]
    return " + ".join([linear, *words])


def _settings(fit: Fit, name: str) -> str:
    effect = next(e for e in fit.model.effects if e.name == name)
    chosen = [f"{c.name} = {effect.settings.get(c.name, c.words[0])}" for c in effect.choices]
    return f" ({', '.join(chosen)})" if chosen else ""


def _cards(fit: Fit) -> list[tuple[str, str, bool]]:
    """(number, what it is, whether it is good) for the head of the page."""
    fitted = [e for e in fit.estimates if e.fitted]
    known = sum(not e.flags for e in fitted)
    cards = []
    for score, which in ((fit.fitted, "fitted"), (fit.holdout, "held-out")):
        if score is not None:
            ratio = score.error_over_noise
            cards.append((ratio_text(ratio), f"error/noise, {which} records", ratio <= GOOD))
    cards.append((f"{known} of {len(fitted)}", "parameters determined", known == len(fitted)))
    cards.append(("yes" if fit.converged else "no", "converged", fit.converged))
    return cards


def _sentence(text: str) -> str:
    begins_with_a_name = "." in text.split()[0]
    return (text if begins_with_a_name else text[0].upper() + text[1:]) + "."


def _versions() -> str:
    return ", ".join(f"{'Python' if name == 'python' else name} {version}" for name, version in versions().items())


def _file_stem(name: str) -> str:
    return re.sub(r"[^\w.-]+", "_", Path(name).stem)[:60] or "record"


@cache
def _template() -> Template:
    from jinja2 import Environment, PackageLoader, StrictUndefined

    environment = Environment(
        loader=PackageLoader("ident.report", ""), autoescape=True, undefined=StrictUndefined, trim_blocks=True,
        lstrip_blocks=True,
    )  # fmt: skip
    return environment.get_template("report.html.j2")
