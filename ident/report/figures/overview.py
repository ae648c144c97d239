"""The overview: how far every record is from its noise floor, in one glance."""

from __future__ import annotations

from typing import TYPE_CHECKING

from ...fit.result import Fit
from ...units import ratio_text
from ..words.drives import drive_words
from .style import FAINT, HELDOUT, INK, MODEL, label, new_axes, new_figure, shortened

if TYPE_CHECKING:
    from matplotlib.figure import Figure


_ROOM = 58  # characters beside the bars
_MOST_BARS = 60  # a picture of two pages: more are not compared by eye, and their labels take seconds


def overview_figure(fit: Fit) -> Figure:
    """Error over noise of each record as a bar, fitted ones above held-out ones, with a line at 1; of very many records
    those held out and the worst."""
    every = list(zip(fit.scores, fit.campaign.records, strict=True))
    worst = sorted(range(len(every)), key=lambda k: (not every[k][0].holdout, -every[k][0].error_over_noise))[
        :_MOST_BARS
    ]
    pairs = sorted([every[k] for k in sorted(worst)], key=lambda pair: pair[0].holdout)
    ratios = [score.error_over_noise for score, _ in pairs]
    height = 0.36 * len(pairs) + 1.1
    figure = new_figure(10.6, height)
    axes = new_axes(figure, 0.42, 0.55 / height, 0.53, 1 - 1.05 / height)
    places = [-i for i in range(len(pairs))]
    wide = max(ratios) > 12
    low = min(0.5, 0.8 * min(ratios)) if wide else 0.0
    colours = [HELDOUT if score.holdout else MODEL for score, _ in pairs]
    axes.barh(places, [r - low for r in ratios], left=low, height=0.62, color=colours)
    if wide:
        axes.set_xscale("log")
        axes.minorticks_off()
        axes.xaxis.set_major_formatter("{x:g}")
    axes.set_xlim(low, max(ratios) * (1.6 if wide else 1.12) if max(ratios) > 1.2 else 1.4)
    axes.set_ylim(places[-1] - 0.6, 0.6)
    axes.axvline(1, color=INK, lw=1.2)
    axes.text(1, 0.62, " noise floor", fontsize=9, color=INK, ha="left", va="bottom")
    drives = [f"  ({drive_words(trace, fit.model.device)})" for _, trace in pairs]
    names = [
        shortened(score.name, max(_ROOM - len(drive), 12)) for (score, _), drive in zip(pairs, drives, strict=True)
    ]
    axes.set_yticks(places, [name + drive for name, drive in zip(names, drives, strict=True)])
    axes.tick_params(axis="y", length=0)
    for place, ratio in zip(places, ratios, strict=True):
        at = (1.0 if 0.8 < ratio < 1.0 else ratio, place)  # not across the line
        axes.annotate(ratio_text(ratio), at, (4, 0), textcoords="offset points", fontsize=9, va="center")
    label(axes, "rms error ÷ noise floor" + (" (logarithmic)" if wide else ""))
    top = 1 - 0.22 / height
    figure.text(0.012, top, "Error over noise", fontsize=12, weight="bold", color=INK, va="center")
    figure.text(0.18, top, "■", fontsize=11, color=MODEL, va="center")
    figure.text(0.195, top, "fitted", fontsize=9.5, color=FAINT, va="center")
    if any(score.holdout for score, _ in pairs):
        figure.text(0.25, top, "■", fontsize=11, color=HELDOUT, va="center")
        figure.text(0.265, top, "held out: only judged", fontsize=9.5, color=FAINT, va="center")
    if len(pairs) < len(every):
        words = f"held-out and worst ones: {len(pairs)} of {len(every)} records"
        figure.text(0.985, top, words, fontsize=9.5, color=FAINT, va="center", ha="right")
    return figure
