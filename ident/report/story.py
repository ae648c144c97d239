"""The error falling step by step: the staircase of a lineage, as a table and as a figure."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from ..units import ratio_text
from .figures.picture import draw
from .figures.style import FAINT, HELDOUT, INK, MODEL, label, new_axes, new_figure
from .html import Section
from .words.sheet import Column, Sheet

if TYPE_CHECKING:
    from matplotlib.figure import Figure

Lineage = Sequence[Mapping[str, Any]]
_COLOURS = {"fitted": MODEL, "holdout": HELDOUT}


def change_sheet(lineage: Lineage) -> Sheet:
    """What each step changed, and error over noise before and after on fitted and on held-out records."""
    rows = []
    for entry in lineage:
        before, after = entry["before"], entry["after"]
        cells = [_step_words(entry)]
        for part in ("fitted", "holdout"):
            for errors in (before, after):
                cells.append("–" if errors[part] is None else ratio_text(_ratio(errors[part])))
        rows.append(tuple(cells))
    names = ("step", "fitted before", "after", "held out before", "after")
    columns = (Column(names[0], wraps=True), *(Column(n, number=True) for n in names[1:]))
    return Sheet("Error over noise floor, before and after", columns, tuple(rows))


def moved_sheet(entry: Mapping[str, Any]) -> Sheet | None:
    """Parameters that the missing effect had biased: those that moved by more than three of their standard errors."""
    rows = []
    for name, told in entry["parameters"].items():
        if told["before"] is None or told["after"] is None:  # not finite, which JSON has as null: moved from nowhere
            continue
        error, shift = told["standard_error"], told["after"] - told["before"]
        if error and abs(shift) > 3 * error and told["before"]:
            rows.append(
                (name, f"{told['before']:.5g}", f"{told['after']:.5g}", f"{100 * shift / told['before']:+.2g} %")
            )
    if not rows:
        return None
    columns = (Column("parameter"), Column("before", True), Column("after", True), Column("shift", True))
    return Sheet(f"Bias that the missing {_name(entry)} had caused (SI)", columns, tuple(rows))


def staircase_section(lineage: Lineage) -> Section:
    """The lineage as a part of the report."""
    picture = draw("Error over noise after each step", staircase_figure(lineage))
    moved = [sheet for sheet in (moved_sheet(entry) for entry in lineage) if sheet is not None]
    return Section("How the error fell", (), (change_sheet(lineage), *moved), (picture,))


def staircase_figure(lineage: Lineage) -> Figure:
    """Error over noise, logarithmic, from the first model to the last; a line at the noise floor."""
    first = lineage[0]
    names = [" + ".join(["linear", *_before_effects(first)]), *(_step_words(entry) for entry in lineage)]
    errors = [first["before"], *(entry["after"] for entry in lineage)]
    figure = new_figure(10.6, 3.4)
    axes = new_axes(figure, 0.07, 0.2, 0.91, 0.66)
    parts = {part: [_ratio(e[part]) for e in errors if e[part] is not None] for part in _COLOURS}
    whole = {part: heights for part, heights in parts.items() if len(heights) == len(errors)}
    for k, (part, heights) in enumerate(whole.items()):
        axes.step(range(len(heights)), heights, where="mid", color=_COLOURS[part], lw=1.4)
        axes.plot(range(len(heights)), heights, "o", color=_COLOURS[part], ms=5)
        for i, height in ((i, height) for i, height in enumerate(heights) if math.isfinite(height)):
            highest = next(name for name in whole if whole[name][i] == np.nanmax([at[i] for at in whole.values()]))
            offset = (0, 7 if part == highest else -13)  # the higher of the two has its number above it
            axes.annotate(ratio_text(height), (i, height), offset, textcoords="offset points", fontsize=9,
                          color=_COLOURS[part], ha="center")  # fmt: skip
        words = {"fitted": "fitted", "holdout": "held out"}[part]
        figure.text(0.72 + 0.06 * k, 0.93, words, fontsize=9.5, color=_COLOURS[part], weight="bold", va="center")
    axes.axhline(1, color=INK, lw=1.2)
    axes.set_yscale("log")
    low, high = axes.get_ylim()
    axes.set_ylim(min(low, 0.6) / 1.2, high * 1.7)
    axes.minorticks_off()
    axes.yaxis.set_major_formatter("{x:g}")
    axes.set_xlim(-0.5, len(names) - 0.5)
    axes.set_xticks(range(len(names)), names)
    label(axes, "", "rms error ÷ noise floor")
    figure.text(0.012, 0.93, "The error after each step", fontsize=12, weight="bold", color=INK, va="center")
    figure.text(0.985, 0.93, "line: noise floor", fontsize=9, color=FAINT, ha="right", va="center")
    return figure


def _ratio(errors: Mapping[str, Any]) -> float:
    """Error over noise as a run keeps it, where a motion without bound has none."""
    return math.nan if errors["error_over_noise"] is None else float(errors["error_over_noise"])


def _before_effects(entry: Mapping[str, Any]) -> list[str]:
    return [name for name in entry["effects"] if name != entry["added"]] + (
        [entry["removed"]] if entry["removed"] else []
    )


def _name(entry: Mapping[str, Any]) -> str:
    return str(entry["added"] or entry["removed"])


def _step_words(entry: Mapping[str, Any]) -> str:
    signs = (("+", entry["added"]), ("−", entry["removed"]))
    return " ".join(f"{sign} {name}" for sign, name in signs if name)
