"""The picture before any fit: natural frequency against amplitude and damping against velocity, of every point."""

from __future__ import annotations

import textwrap
from typing import TYPE_CHECKING

import numpy as np

from ...campaign.campaign import Campaign
from ...campaign.record import same_level
from ...campaign.sweeps.dynamic_stiffness import DynamicStiffness, LawCurve, dynamic_stiffness
from ...units import significant
from ..words.quantity import scale
from ..words.sweeps import fit_free_words
from .style import FAINT, INK, label, new_axes, new_figure

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_WEAK, _STRONG = np.array([0.78, 0.86, 0.93]), np.array([0.0, 0.22, 0.43])  # light to dark, weakest to strongest drive

_VAGUE = 0.3  # of the height of the curve: points with larger error bars weigh in it, but would hide it


def dynamic_stiffness_figure(campaign: Campaign) -> Figure | None:
    """Both curves of the campaign's sweeps; None where no sweep has a phase."""
    seen = dynamic_stiffness(campaign.sweeps)
    if seen is None:
        return None
    figure = new_figure(9.6, 4.2)
    lines = [line for words in fit_free_words(campaign.sweeps) for line in textwrap.wrap(words, 150)]
    for place, line in enumerate(lines):
        figure.text(0.012, 0.97 - 0.042 * place, line, fontsize=8.5, color=INK, va="center")
    size = scale(float(np.max(seen.stiffness.amplitude)), "m", campaign.device)
    speed = scale(float(np.max(seen.damping.amplitude)), "m/s", campaign.device)
    axes = new_axes(figure, 0.075, 0.13, 0.39, 0.62)
    _draw(axes, seen.stiffness, size.factor)
    label(axes, f"amplitude ({size.unit})", "natural frequency (Hz)", "Re(drive/response) + ω²: restoring law")
    axes = new_axes(figure, 0.565, 0.13, 0.39, 0.62)
    _draw(axes, seen.damping, speed.factor)
    label(axes, f"velocity amplitude ({speed.unit})", "damping rate (1/s)", "Im(drive/response)/ω: damping law")
    _levels(figure, seen, campaign)
    return figure


def _colour(place: float) -> tuple[float, float, float]:
    red, green, blue = (_WEAK + place * (_STRONG - _WEAK)).tolist()
    return red, green, blue


def _draw(axes: Axes, curve: LawCurve, factor: float) -> None:
    """Points in the shade of their level, weakest last so that it is not hidden, with error bars; the common curve."""
    groups = same_level(curve.level)
    for k, rows in reversed(list(enumerate(groups))):
        shade = _colour(k / max(len(groups) - 1, 1))
        rows = rows[curve.deviation[rows] < _VAGUE * max(float(np.ptp(curve.curve)), 0.02 * abs(float(curve.curve[0])))]
        x = curve.amplitude[rows] / factor
        axes.errorbar(x, curve.value[rows], curve.deviation[rows], fmt="o", ms=2.6, lw=0.7, color=shade, zorder=2)
    axes.plot(curve.at / factor, curve.curve, color="#d55e00", lw=1.3, zorder=3)
    middle = np.quantile(curve.value, [0.02, 0.98])
    ends = np.array([min(middle[0], np.min(curve.curve)), max(middle[1], np.max(curve.curve))])
    room = 0.12 * max(float(np.ptp(ends)), 1e-12 * abs(float(ends[0])))
    axes.set_ylim(float(ends[0]) - room, float(ends[1]) + room)


def _levels(figure: Figure, seen: DynamicStiffness, campaign: Campaign) -> None:
    """The levels in their shades, from the right."""
    groups = same_level(seen.stiffness.level)
    volts = next(sweep.drive_channel for sweep in campaign.sweeps)
    right = 0.985
    for k, rows in reversed(list(enumerate(groups))):
        name = f"{significant(float(np.median(seen.stiffness.level[rows])) / volts.factor, 3)} {volts.unit}"
        shade = _colour(k / max(len(groups) - 1, 1))
        figure.text(right, 0.835, name, fontsize=9, color=shade, ha="right", va="center", weight="bold")
        right -= 0.0105 * len(name) + 0.012
    figure.text(right, 0.835, "drive", fontsize=9, color=FAINT, ha="right", va="center")
