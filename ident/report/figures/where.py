"""One figure of where a model fails: small panels, the ones that stand out in colour, the rest in grey."""

from __future__ import annotations

import textwrap
from typing import TYPE_CHECKING

import numpy as np

from ...diagnosis.where.locate import ALARMS, RecordView, Where
from ...diagnosis.where.views import View
from ...diagnosis.where.whiteness import Correlation
from ...diagnosis.where.words import statements, summary
from .style import BAND, DATA, FAINT, HELDOUT, INK, RESIDUAL, key, label, new_axes, new_figure, shortened

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_MOST_RECORDS = 9
_WIDTH = 0.185  # of a panel, in parts of the figure


def where_figure(where: Where) -> Figure:
    """Error over noise floor by record, time, motion, phase and harmonic of the drive, with the tests of whiteness."""
    figure = new_figure(10.6, 5.4)
    said = {s.axis for s in statements(where)}
    words = textwrap.wrap(summary(where), 138)
    for i, line in enumerate(words[:4]):
        bold = "bold" if i == 0 and not where.fails else "normal"
        figure.text(0.012, 0.965 - 0.037 * i, line, fontsize=9.5, color=INK, va="center", weight=bold)
    top, low, height = 0.49, 0.085, 0.26
    _records(new_axes(figure, 0.145, top, 0.10, height), where, bool(said & {"record", "level"}))
    panels = [
        (0.305, where.time, "time", "over the records' time"),
        (0.555, where.displacement, "displacement", "by displacement"),
        (0.805, where.velocity, "velocity", "by velocity"),
    ]
    if where.of_curves:
        panels = [
            (0.305, where.displacement, "displacement", "by amplitude"),
            (0.555, where.velocity, "velocity", "by distance from the peak"),
        ]
    for left, view, axis, title in panels:
        _bins(new_axes(figure, left, top, _WIDTH, height), view, axis in said, title)
    if where.of_curves:
        _bins(new_axes(figure, 0.055, low, 0.435, height), where.time, "frequency" in said, "by frequency")
    elif where.phase is None or where.harmonics is None or len(where.harmonics.ratio) == 1:
        _bands(new_axes(figure, 0.055, low, 0.435, height), where, "frequency" in said)
    else:
        _bins(new_axes(figure, 0.055, low, _WIDTH, height), where.phase, "phase" in said, "by the drive's phase")
        _harmonics(new_axes(figure, 0.305, low, _WIDTH, height), where.harmonics, "harmonic" in said)
    lag = "lag (points)" if where.of_curves else "lag (samples)"
    _correlation(new_axes(figure, 0.555, low, _WIDTH, height), where.whiteness, 1.0, lag,
                 "with itself: noise stays in the band")  # fmt: skip
    if where.drive is not None:
        _correlation(new_axes(figure, 0.805, low, _WIDTH, height), where.drive, where.resonance,
                     "drive earlier by (periods)", "with the drive")  # fmt: skip
    key(figure, 0.99, 0.80, ("stands out", RESIDUAL), ("does not", DATA), ("held out", HELDOUT))
    return figure


def _records(axes: Axes, where: Where, loud: bool) -> None:
    """Bars, worst first."""
    ranked = sorted(where.records, key=lambda r: (r.holdout, -r.ratio))[:_MOST_RECORDS]
    for i, r in enumerate(ranked):
        axes.barh(i, r.ratio, height=0.72, color=_colour(r, ranked, loud))
        axes.text(r.ratio, i, f" {r.ratio:.3g}", fontsize=7.5, va="center", color=INK)
    axes.axvline(1.0, color=INK, lw=0.9, ls="--")
    axes.set_yticks(range(len(ranked)), [shortened(r.name, 18) for r in ranked], fontsize=7.5)
    axes.set_ylim(len(ranked) - 0.4, -0.6)
    axes.set_xlim(0, 1.3 * max(r.ratio for r in ranked))
    more = len(where.records) - len(ranked)
    label(axes, "error ÷ noise floor", title=f"worst of {len(where.records)} records" if more > 0 else "by record")


def _colour(record: RecordView, ranked: list[RecordView], loud: bool) -> str:
    if record.holdout:
        return HELDOUT
    fitted = [r for r in ranked if not r.holdout]
    mean = np.mean([max(r.excess, 0.0) for r in fitted])
    return RESIDUAL if loud and record.p_value < ALARMS and record.excess > mean else DATA


def _bins(axes: Axes, view: View, loud: bool, title: str) -> None:
    chosen = view.stands_out(ALARMS) & loud
    width = np.diff(view.edges) * 0.92
    axes.bar(view.centres, np.nan_to_num(view.ratio), width, color=np.where(chosen, RESIDUAL, DATA).tolist())
    _floor(axes, view.ratio)
    axes.set_xlim(view.edges[0], view.edges[-1])
    if view.edges[-1] == 360:
        axes.set_xticks([0, 90, 180, 270, 360])
    label(axes, view.axis, "÷ noise floor", title)


def _floor(axes: Axes, ratio: np.ndarray) -> None:
    axes.axhline(1.0, color=INK, lw=0.9, ls="--")
    axes.set_ylim(0, 1.12 * max(float(np.nanmax(ratio)), 1.4))


def _harmonics(axes: Axes, view: View, loud: bool) -> None:
    """χ² in each harmonic on a logarithmic scale: a third harmonic of 2 % is the clue, not a detail."""
    explained = np.maximum(view.ratio**2, 0.1)
    chosen = loud & (view.p_value * len(explained) < ALARMS) & (explained > 0.2 * float(np.max(explained)))
    axes.bar(view.centres, explained, 0.72, bottom=0.0, color=np.where(chosen, RESIDUAL, DATA).tolist())
    axes.set_yscale("log")
    axes.minorticks_off()
    axes.yaxis.set_major_formatter("{x:g}")
    axes.axhline(1.0, color=INK, lw=0.9, ls="--")
    axes.set_ylim(0.3, 3 * max(float(np.max(explained)), 5.0))
    axes.set_xticks(view.centres)
    label(axes, view.axis, "power ÷ noise", "by harmonic (0: constant)")


def _bands(axes: Axes, where: Where, loud: bool) -> None:
    view = where.spectrum
    chosen = view.stands_out(ALARMS, 3.0) & loud
    place = np.arange(len(view.ratio))
    axes.bar(place, np.nan_to_num(view.ratio), 0.9, color=np.where(chosen, RESIDUAL, DATA).tolist())
    _floor(axes, view.ratio)
    shown = place[:: max(len(place) // 8, 1)]
    largest = float(view.edges[-1]) * where.resonance
    size, unit = next((s, u) for s, u in ((1e6, "MHz"), (1e3, "kHz"), (0.0, "Hz")) if largest >= 2 * s)
    axes.set_xticks(shown - 0.5, [f"{view.edges[i] * where.resonance / (size or 1.0):.3g}" for i in shown])
    label(axes, f"frequency ({unit})", "÷ noise floor", "by frequency")


def _correlation(axes: Axes, found: Correlation, unit: float, x: str, title: str) -> None:
    axes.axhspan(-found.band, found.band, color=BAND, lw=0)
    colour = RESIDUAL if found.p_value < ALARMS else DATA
    axes.vlines(found.lags * unit, 0.0, found.values, color=colour, lw=1.4)
    axes.axhline(0.0, color=FAINT, lw=0.6)
    size = max(float(np.max(np.abs(found.values))), 3 * found.band)
    axes.set_ylim(-1.15 * size, 1.15 * size)
    label(axes, x, "correlation", title)
