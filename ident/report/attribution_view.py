"""Which mechanism explains the offset, to look at: a bar per mechanism, record and measure; `attribution.json`."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from ..campaign.device import Device
from ..campaign.record import Trace
from ..posterior.attribution import Attributed, Attribution, Share
from ..posterior.offset import EVEN, MEASURES
from ..units import plain_micro
from .figures.picture import draw_kept
from .figures.style import FAINT, HELDOUT, INK, MODEL, RESIDUAL, new_axes, new_figure, shortened
from .html import Section
from .words.drives import drive_words
from .words.quantity import Scale, show_in
from .words.sheet import Column, Mark, Sheet

if TYPE_CHECKING:
    from matplotlib.figure import Figure

# Told apart by the colour-blind (Okabe & Ito), the first three as elsewhere in the report.
_COLOURS = (MODEL, RESIDUAL, HELDOUT, "#009e73", "#cc79a7", "#56b4e9", "#f0e442", INK)
_SHOWN = tuple(MEASURES[i].name for i in EVEN)
_NARROW = 0.001  # width of a share from which its interval is told
_BROAD = 0.02  # and from which whole percents tell it
_FIXED = {"rad": Scale(np.pi / 180, "deg"), "1": Scale(0.01, "%")}


def attribution_dict(found: Attribution, device: Device) -> dict[str, Any]:
    """An attribution as plain numbers, format 1; lengths in the unit in which the record was read."""
    return {
        "format": 1,
        "verdict": found.verdict,
        "words": found.words,
        "reasons": list(found.reasons),
        "mechanisms": list(found.mechanisms),
        "leading": list(found.leading),
        "overall": [_share(s) for s in found.overall],
        "within": [_share(s) for s in found.within],
        "records": [
            {
                "file": r.record.name,
                "drive": drive_words(r.record, device),
                "holdout": r.record.holdout,
                "measures": [_measure(m, r.record) for m in r.measures],
            }
            for r in found.records
        ],
    }


def _measure(one: Attributed, record: Trace) -> dict[str, Any]:
    channel = record.response_channel
    unit = _FIXED.get(one.measure.unit) or Scale(channel.factor, plain_micro(channel.unit))
    data, model = one.offset.data, one.offset.model
    return {
        "measure": one.measure.name,
        "unit": unit.unit,
        "data": data.value / unit.factor,
        "data_error": data.error / unit.factor,
        "model": model.value / unit.factor,
        "beyond_symmetry": one.beyond.value / unit.factor,
        "beyond_symmetry_error": one.beyond.error / unit.factor,
        "counts": one.counts,
        "shares": [_share(s) for s in one.shares],
    }


def _share(share: Share) -> dict[str, Any]:
    return {
        "mechanism": share.mechanism,
        "share": share.share,
        "interval90": [share.low, share.high],
        "alone": share.alone,
    }


def attribution_sheet(document: Mapping[str, Any]) -> Sheet:
    """The shares of every measure that decides, from `attribution.json`."""
    names, rows = document["mechanisms"], []
    for record in document["records"]:
        for one in record["measures"]:
            if one["counts"]:
                unit = one["unit"].replace("um", "µm")
                value = show_in(one["beyond_symmetry"], one["beyond_symmetry_error"], Scale(1.0, unit))
                shares = {s["mechanism"]: s for s in one["shares"]}
                rows.append((record["file"], one["measure"], f"{value.value} ± {value.error} {unit}",
                             *(_percent(shares[name]) for name in names)))  # fmt: skip
    if document["overall"]:
        rows.append(("all together", "", "", *(_percent(s) for s in document["overall"])))
    marks: list[Mark] = ["total" if row[0] == "all together" else "" for row in rows]
    columns = (
        Column("record", wraps=True),
        Column("measure", wraps=True),
        Column("offset", True, True),
        *(Column(n, True, True) for n in names),
    )
    note = (
        "The offset is what the record has beyond a motion that symmetric physics could make. Share of each mechanism "
        "with its 90 % interval, but where that is narrower than 0.1 %; shares of a measure add up to 100 %. Beyond "
        "100 % a mechanism alone would make more than the offset, and one below 0 works against it."
    )
    return Sheet("Which mechanism explains the offset", columns, tuple(rows), tuple(marks), note)


def _percent(share: Mapping[str, Any]) -> str:
    """ "97 % (95…99)", with a decimal where the interval would not show without."""
    low, high = share["interval90"]
    if not high - low >= _NARROW:
        return f"{round(100 * share['share']):d} %"
    digits = 0 if high - low >= _BROAD else 1
    middle, low, high = (f"{100 * value + 0.0:.{digits}f}" for value in (share["share"], low, high))
    return f"{middle} % ({low}…{high})"


def attribution_figure(document: Mapping[str, Any]) -> Figure:
    """Records down, measures across; in each cell one bar per mechanism, from none to all of the offset."""
    names: Sequence[str] = document["mechanisms"]
    records = [r for r in document["records"] if any(m["counts"] for m in r["measures"])] or document["records"]
    row = 0.24 * max(len(names), 2) + 0.42
    height = 1.25 + row * len(records) + 0.45
    figure = new_figure(10.6, height)
    sure = document["verdict"] != "undecided"
    heading = {"one mechanism": "One mechanism explains the zero-point offset", "several": "Several mechanisms explain "
               "the zero-point offset", "undecided": "Undecided what explains the zero-point offset"}  # fmt: skip
    figure.text(0.012, 1 - 0.24 / height, heading[document["verdict"]], fontsize=12, weight="bold", va="center",
                color=INK if sure else RESIDUAL)  # fmt: skip
    at = 0.012
    overall = {s["mechanism"]: f"  {round(100 * s['share']):d} %" for s in document["overall"]}
    for name, colour in zip(names, _COLOURS, strict=False):
        words = f"■ {name}{overall.get(name, '')}"
        figure.text(at, 1 - 0.55 / height, words, fontsize=10.5, weight="bold", color=colour, va="center")
        at += 0.012 + 0.0098 * len(words)
    for column, measure in enumerate(_SHOWN):
        left = 0.21 + 0.198 * column
        figure.text(left, 1 - 0.92 / height, measure, fontsize=9.5, weight="bold", color=INK, va="center")
        for line, record in enumerate(records):
            bottom = 1 - (1.15 + row * (line + 1)) / height
            if not column:
                middle = bottom + 0.5 * row / height
                figure.text(0.012, middle + 0.07 / height, shortened(record["file"], 22), fontsize=9.5, color=INK)
                figure.text(0.012, middle - 0.09 / height, record["drive"][:32], fontsize=8, color=FAINT)
            one = next(m for m in record["measures"] if m["measure"] == measure)
            _cell(figure, (left, bottom + 0.06 / height, 0.175, (row - 0.34) / height), one, names,
                  last=line == len(records) - 1)  # fmt: skip
    return figure


def _cell(
    figure: Figure, place: tuple[float, float, float, float], one: Mapping[str, Any], names: Sequence[str], last: bool
) -> None:
    left, bottom, _, high = place
    unit = one["unit"].replace("um", "µm")
    size, error = one["beyond_symmetry"], one["beyond_symmetry_error"]
    value = show_in(size, error, Scale(1.0, unit))
    words = f"{value.value} ± {value.error} {unit}"
    if not one["counts"]:
        words += "  (none)" if abs(size) <= 3 * error else "  (unclear)"
    figure.text(left, bottom + high + 0.004, words, fontsize=8.5, color=INK if one["counts"] else FAINT, va="bottom")
    axes = new_axes(figure, *place)
    axes.set_xlim(-0.25, 1.25)
    axes.set_ylim(-len(names) + 0.5, 0.5)
    axes.set_yticks([])
    axes.spines["left"].set_visible(False)
    axes.spines["bottom"].set_visible(last)
    axes.axvline(0, color=INK, lw=0.8)
    axes.axvline(1, color=FAINT, lw=0.8, ls=":")
    axes.set_xticks([0, 0.5, 1], ["0", "50", "100 %"] if last else ["", "", ""])
    axes.tick_params(length=3 if last else 0)
    if not one["counts"]:
        return
    for k, share in enumerate(one["shares"]):
        axes.barh(-k, np.clip(share["share"], -0.25, 1.25), height=0.72, color=_COLOURS[k % len(_COLOURS)])
        axes.plot(np.clip(share["interval90"], -0.25, 1.25), [-k, -k], color=INK, lw=1.6, solid_capstyle="butt")


def attribution_section(document: Mapping[str, Any]) -> Section:
    """The part of the report about the offset's causes, from `attribution.json`."""
    caption = "Share of the offset that each mechanism explains; line: 90 % interval"
    picture = draw_kept(caption, attribution_figure(document))
    sheets = (attribution_sheet(document),)
    return Section("What explains the zero-point offset", (document["words"],), sheets, (picture,))
