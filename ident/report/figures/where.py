"""One figure of where a model fails: a panel per question with its answer; what stands out in colour, the rest grey."""

from __future__ import annotations

import textwrap
from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np

from ...diagnosis.where.locate import ALARMS, RecordView, Where
from ...diagnosis.where.views import View
from ...diagnosis.where.whiteness import Correlation
from ...diagnosis.where.words import statements, summary
from ...units import ratio_text
from .style import BAND, DATA, FAINT, HELDOUT, INK, RESIDUAL, key, label, new_axes, new_figure, shortened

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_MOST_RECORDS = 9
_WIDTH = 0.185  # of a panel, in parts of the figure
_ERROR = "error ÷ noise floor"
_NOWHERE = "no part stands out"


def where_figure(where: Where) -> Figure:
    """A panel per question, with its answer: error over noise floor by record, time, motion, phase and harmonic of the
    drive, with the tests of whiteness."""
    figure = new_figure(10.6, 5.9)
    short = lambda words: words.removesuffix(" of the drive's phase").removeprefix("where the stage is ")
    said = {s.axis: short(s.words) for s in statements(where)}
    words = textwrap.wrap(summary(where), 138)
    for i, line in enumerate(words[:4]):
        bold = "bold" if i == 0 and not where.fails else "normal"
        figure.text(0.012, 0.968 - 0.034 * i, line, fontsize=9.5, color=INK, va="center", weight=bold)
    top, low, height = 0.505, 0.082, 0.22
    _records(new_axes(figure, 0.145, top, 0.10, height), where, said)
    panels = [
        (0.305, where.time, "time", "When in a record?", "time (0: its start, 1: its end)"),
        (0.555, where.displacement, "displacement", "Where in the motion?", where.displacement.axis),
        (0.805, where.velocity, "velocity", "At which velocity?", where.velocity.axis),
    ]
    if where.of_curves:
        panels = [
            (0.305, where.displacement, "displacement", "At which amplitude?", where.displacement.axis),
            (0.555, where.velocity, "velocity", "How far from the peak?", where.velocity.axis),
        ]
    for left, view, axis, question, x in panels:
        _bins(new_axes(figure, left, top, _WIDTH, height), view, said.get(axis), question, x)
    wide = (0.07, low, 0.42, height)
    left, right = (0.07, low, _WIDTH - 0.015, height), (0.305, low, _WIDTH, height)
    if where.of_curves:
        _bins(new_axes(figure, *wide), where.time, said.get("frequency"), "At which frequency?", where.time.axis)
    elif where.phase is None or where.harmonics is None or len(where.harmonics.ratio) == 1:
        _bands(new_axes(figure, *wide), where, said)
    else:
        phase = new_axes(figure, *left)
        _bins(phase, where.phase, said.get("phase"), "At which phase of the drive?", where.phase.axis)
        phase.set_xticks([0, 90, 180, 270, 360])
        if "frequency" in said:  # what the words name has an axis
            _bands(new_axes(figure, *right), where, said, marks=4)
        else:
            _harmonics(new_axes(figure, *right), where.harmonics, said.get("harmonic"))
    lag = "points" if where.of_curves else "samples"
    _correlation(new_axes(figure, 0.555, low, _WIDTH, height), where.whiteness, 1.0, f"later by ({lag})",
                 "Is what is left random?", ("yes: within the grey band", "no: beyond the grey band"))  # fmt: skip
    if where.drive is not None:
        _correlation(new_axes(figure, 0.805, low, _WIDTH, height), where.drive, where.resonance,
                     "drive earlier by (periods)", "Does it follow the drive?",
                     ("no: within the grey band", "yes: beyond the grey band"))  # fmt: skip
    stands = [("stands out", RESIDUAL), ("does not", DATA)] if where.fails else []
    heldout = [("held out", HELDOUT)] if any(r.holdout for r in where.records) else []
    key(figure, 0.99, 0.825, *stands, *heldout, ("dashed: noise floor", INK))
    return figure


def _head(
    axes: Axes, question: str, answer: str, loud: bool, x: str = "", y: str = "", left: float | None = None
) -> None:
    """A panel's question, with its answer below; from its left edge, or another (in parts of the figure)."""
    label(axes, x, y)
    box, figure = axes.get_position(), axes.figure
    left = box.x0 if left is None else left
    answer = textwrap.shorten(answer, round(200 * (box.x1 - left)), placeholder=" …")
    colour = RESIDUAL if loud else FAINT
    figure.text(left, box.y1 + 0.037, question, fontsize=9.5, color=INK, weight="bold")
    figure.text(left, box.y1 + 0.012, answer, fontsize=8.5, color=colour)


def _records(axes: Axes, where: Where, said: Mapping[str, str]) -> None:
    """Bars, worst first."""
    once = {(r.name, r.error): r for r in where.records}.values()  # of a record there may be several excerpts
    ranked = sorted(once, key=lambda r: (r.holdout, -r.error))[:_MOST_RECORDS]
    answer = said.get("record") or said.get("level")
    for i, r in enumerate(ranked):
        axes.barh(i, r.error, height=0.72, color=_colour(r, ranked, answer is not None))
        axes.text(r.error, i, f" {ratio_text(r.error)}", fontsize=7.5, va="center", color=INK)
    axes.axvline(1.0, color=INK, lw=0.9, ls="--")
    axes.set_yticks(range(len(ranked)), [shortened(r.name, 18) for r in ranked], fontsize=7.5)
    axes.set_ylim(len(ranked) - 0.4, -0.6)
    axes.set_xlim(0, 1.4 * max(r.error for r in ranked))
    axes.locator_params(axis="x", nbins=3)
    more = len(once) - len(ranked)
    question = f"Which record? (worst of {len(once)})" if more > 0 else "Which record?"
    _head(axes, question, answer or _NOWHERE, answer is not None, _ERROR, left=0.012)  # above the names too


def _colour(record: RecordView, ranked: list[RecordView], loud: bool) -> str:
    if record.holdout:
        return HELDOUT
    fitted = [r for r in ranked if not r.holdout]
    mean = np.mean([max(r.excess, 0.0) for r in fitted])
    return RESIDUAL if loud and record.p_value < ALARMS and record.excess > mean else DATA


def _bins(axes: Axes, view: View, answer: str | None, question: str, x: str) -> None:
    chosen = view.stands_out(ALARMS) & (answer is not None)
    width = np.diff(view.edges) * 0.92
    axes.bar(view.centres, np.nan_to_num(view.ratio), width, color=np.where(chosen, RESIDUAL, DATA).tolist())
    _floor(axes, view.ratio)
    axes.set_xlim(view.edges[0], view.edges[-1])
    _head(axes, question, answer or _NOWHERE, answer is not None, x, _ERROR)


def _floor(axes: Axes, ratio: np.ndarray) -> None:
    axes.axhline(1.0, color=INK, lw=0.9, ls="--")
    axes.set_ylim(0, 1.12 * max(float(np.nanmax(ratio)), 1.4))


def _harmonics(axes: Axes, view: View, answer: str | None) -> None:
    """On a logarithmic scale: a third harmonic of 2 % is the clue, not a detail."""
    explained = np.maximum(view.ratio**2, 0.1)
    chosen = (view.p_value * len(explained) < ALARMS) & (explained > 0.2 * float(np.max(explained)))
    colours = np.where(chosen & (answer is not None), RESIDUAL, DATA).tolist()
    axes.bar(view.centres, np.sqrt(explained), 0.72, bottom=0.0, color=colours)
    axes.set_yscale("log")
    axes.minorticks_off()
    axes.yaxis.set_major_formatter("{x:g}")
    axes.axhline(1.0, color=INK, lw=0.9, ls="--")
    axes.set_ylim(0.5, 2 * max(float(np.sqrt(np.max(explained))), 2.5))
    axes.set_xticks(view.centres)
    question, x = "At which harmonic?", "times the drive frequency (0: mean)"
    _head(axes, question, answer or _NOWHERE, answer is not None, x, _ERROR)


def _bands(axes: Axes, where: Where, said: Mapping[str, str], marks: int = 8) -> None:
    view, answer = where.spectrum, said.get("frequency")
    chosen = view.stands_out(ALARMS, 3.0) & (answer is not None)
    place = np.arange(len(view.ratio))
    axes.bar(place, np.nan_to_num(view.ratio), 0.9, color=np.where(chosen, RESIDUAL, DATA).tolist())
    _floor(axes, view.ratio)
    shown = place[:: -(-len(place) // marks)]
    largest = float(view.edges[-1]) * where.resonance
    size, unit = next((s, u) for s, u in ((1e6, "MHz"), (1e3, "kHz"), (0.0, "Hz")) if largest >= 2 * s)
    axes.set_xticks(shown - 0.5, [f"{view.edges[i] * where.resonance / (size or 1.0):.3g}" for i in shown])
    _head(axes, "At which frequency?", answer or _NOWHERE, answer is not None, f"frequency ({unit})", _ERROR)


def _correlation(axes: Axes, found: Correlation, unit: float, x: str, question: str, answers: tuple[str, str]) -> None:
    axes.axhspan(-found.band, found.band, color=BAND, lw=0)
    loud = found.p_value < ALARMS
    axes.vlines(found.lags * unit, 0.0, found.values, color=RESIDUAL if loud else DATA, lw=1.4)
    axes.axhline(0.0, color=FAINT, lw=0.6)
    size = max(float(np.max(np.abs(found.values))), 3 * found.band)
    axes.set_ylim(-1.15 * size, 1.15 * size)
    _head(axes, question, answers[loud], loud, x, "correlation")
