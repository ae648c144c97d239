"""How figures look: few colours, told apart by the colour-blind, and cheap to draw.

Colours: M. Okabe, K. Ito, Color Universal Design, 2008.
"""

from __future__ import annotations

import io
from typing import TYPE_CHECKING, Any

import numpy as np

from ...errors import visible

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

DATA = "#9a9a9a"
MEASURED = "#6f6f6f"  # the name of the data: their own grey is too light for letters
MODEL = "#0072b2"
RESIDUAL = "#d55e00"
HELDOUT = "#e69f00"
INK = "#222222"
FAINT = "#777777"
BAND = "#e8eef2"
DPI = 100
_SIZE = 9.0
_AXES: dict[Any, Any] = {
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.edgecolor": FAINT,
    **{f"{axis}tick.labelsize": _SIZE for axis in "xy"},
    **{f"{axis}tick.labelcolor": INK for axis in "xy"},
    **{f"{axis}tick.color": FAINT for axis in "xy"},
    **{f"{axis}tick.major.size": 3 for axis in "xy"},
}


def new_figure(width: float, height: float) -> Figure:
    """An empty figure (inches), without pyplot and its global state."""
    from matplotlib.figure import Figure

    from .canvas import Canvas

    figure = Figure((width, height), dpi=DPI, facecolor="white")
    Canvas(figure)
    return figure


def new_axes(figure: Figure, left: float, bottom: float, width: float, height: float) -> Axes:
    """Axes at a place given in parts of the figure; placed by hand because automatic layouts draw everything twice."""
    from matplotlib import rc_context

    with rc_context(_AXES):  # styled as they are made: changing ticks afterwards makes all of them again
        axes = figure.add_axes((left, bottom, width, height))
    axes.locator_params(nbins=5)
    return axes


def emptied(figure: Figure) -> Figure:
    """The figure with nothing drawn on it; its axes stay, whose ticks take longer to make than all else to draw."""
    for text in list(figure.texts):
        text.remove()
    for axes in figure.axes:
        for artist in (*axes.lines, *axes.patches):
            artist.remove()
        axes.relim()
        axes.autoscale()
    return figure


def label(axes: Axes, x: str = "", y: str = "", title: str = "") -> None:
    """Names of the axes and a short heading."""
    axes.set_xlabel(x, fontsize=_SIZE, color=INK, labelpad=2)
    axes.set_ylabel(y, fontsize=_SIZE, color=INK, labelpad=3)
    if title:
        axes.set_title(title, fontsize=_SIZE, color=FAINT, loc="left", pad=4, y=1.0)  # a given y spares a search


def key(figure: Figure, right: float, y: float, *entries: tuple[str, str]) -> None:
    """Names of the lines in their colours, right-aligned: read faster than a legend, and drawn five times as fast."""
    for name, colour in reversed(entries):
        figure.text(right, y, name, fontsize=_SIZE, color=colour, ha="right", va="center", weight="bold")
        right -= 0.0085 * len(name) * 10.6 / figure.get_figwidth() + 0.012


def png(figure: Figure) -> bytes:
    """The figure as PNG."""
    from .canvas import Canvas

    canvas = figure.canvas
    assert isinstance(canvas, Canvas), "made by new_figure"
    return canvas.as_png()


def vector(figure: Figure, format: str) -> bytes:
    """The figure as "svg" or "pdf", the same bytes whenever it is drawn; text in a PDF stays text, as journals ask."""
    from matplotlib import rc_context
    from matplotlib.text import Text

    date = "Date" if format == "svg" else "CreationDate"
    with rc_context({"pdf.fonttype": 42, "svg.hashsalt": "ident"}):
        for text in figure.findobj(Text):
            text.set_parse_math(False)  # type: ignore[attr-defined]  # "$" is a sign in names of files, not a formula
        buffer = io.BytesIO()
        figure.savefig(buffer, format=format, metadata={date: None})
    return buffer.getvalue()


def shortened(name: str, most: int) -> str:
    """A file's name in at most so many characters: its middle is left out, for records differ at the ends."""
    name = visible(name.rsplit("/", 1)[-1].removesuffix(".csv"))
    return name if len(name) <= most else f"{name[: most // 2 - 1]}…{name[most // 2 - most :]}"


def envelope(time: np.ndarray, values: np.ndarray, bins: int = 900) -> tuple[np.ndarray, np.ndarray]:
    """Smallest and largest value of each of so many bins, as one line: what a screen can show of a long record."""
    if len(values) < 3 * bins:
        return time, values
    first = np.linspace(0, len(values), bins, endpoint=False).astype(int)
    both = np.stack([np.minimum.reduceat(values, first), np.maximum.reduceat(values, first)], axis=1).reshape(-1)
    return np.repeat(time[first], 2), both
