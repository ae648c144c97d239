"""How the paper's figures are laid out, and how a script shows its own: study, check, draw."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from types import ModuleType

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure as Figure

from ident.report.figures.style import INK, RESIDUAL, label, new_axes, new_figure, png

from .nominal import POINTS, without_offset

FOLDER = Path(__file__).resolve().parents[2] / "docs" / "figures" / "paper"


def sheet(
    title: str, columns: int, rows: int = 1, width: float = 10.0, height: float = 3.0
) -> tuple[Figure, list[Axes]]:
    """A figure with a claim over it and a grid of axes, row by row; `height` of a row in inches."""
    whole = height * rows + 0.45
    figure = new_figure(width, whole)
    figure.text(0.008, 1 - 0.24 / whole, title, fontsize=11, color=INK, weight="bold", va="center")
    wide, tall = 1 / columns, height / whole
    left, bottom = 0.72 / width, 0.52 / whole
    return figure, [
        new_axes(
            figure, c * wide + left, (rows - 1 - r) * tall + bottom, wide - left - 0.12 / width, tall - 0.85 / whole
        )
        for r in range(rows)
        for c in range(columns)
    ]


def period(axes: Axes, z: np.ndarray, colour: str, title: str) -> None:
    """Displacement (m) over one period of the drive, and thinly what it would be without its offset."""
    phase = np.arange(len(z)) / len(z)
    axes.axhline(0, color="#cccccc", lw=0.8)
    axes.plot(phase, 1e6 * without_offset(z), color=INK, lw=0.9, ls=(0, (4, 3)))
    axes.plot(phase, 1e6 * z, color=colour, lw=1.8)
    label(axes, "time (periods of the drive)", "displacement (µm)", title)


def offset(axes: Axes, z: np.ndarray, colour: str = RESIDUAL, title: str = "what is not symmetric") -> None:
    """The part of a period that symmetric physics has none of."""
    phase = np.arange(POINTS) / POINTS
    axes.axhline(0, color="#cccccc", lw=0.8)
    axes.plot(phase, 1e6 * (z - without_offset(z)), color=colour, lw=1.8)
    label(axes, "time (periods of the drive)", "offset (µm)", title)


def names(axes: Axes, entries: Sequence[tuple[str, str]]) -> None:
    """Names of the lines in their colours, upper left."""
    for k, (text, colour) in enumerate(entries):
        axes.text(0.03, 0.93 - 0.09 * k, text, color=colour, transform=axes.transAxes, fontsize=9, weight="bold")


def show(script: ModuleType) -> str:
    """Run one script: its statement, asserted, and its picture in docs/figures/paper."""
    found = script.study()
    words = script.check(found)
    FOLDER.mkdir(parents=True, exist_ok=True)
    name = script.__name__.rsplit(".", 1)[-1]
    (FOLDER / f"{name}.png").write_bytes(png(script.draw(found)))
    return words
