"""The missing term in one figure: force over its coordinate with its error, a map over two, or the loop of a memory."""

from __future__ import annotations

import textwrap
from typing import TYPE_CHECKING

import numpy as np

from ...campaign.device import Device
from ...diagnosis.unknown.find import Unknown
from ...diagnosis.unknown.picture import Picture
from ...diagnosis.unknown.splines import UNITS
from ...diagnosis.unknown.words import percent, what
from ..words.quantity import Scale, scale, show
from .style import FAINT, INK, MODEL, RESIDUAL, key, label, new_axes, new_figure

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_POINTS = 108  # size of bold letters times how many of them fill an inch
_SHADE = "#c9dcea"  # two standard errors around the curve
_INNER = (
    97  # per cent of a map that its colours tell apart: at its edges a spline knows little, and would pale the rest
)
_VAGUE = 8.0  # times the usual error of a curve
_NAMES = {"z": "displacement z", "v": "velocity v", "V": "drive V", "dV": "rate of the drive V̇/ω", "t": "time t"}


def unknown_figure(unknown: Unknown, device: Device, law: np.ndarray | None = None) -> Figure:
    """What is missing from the model as a function of what it depends on; `law`: the same curve as a fit has it that
    simulates what was written from it.

    One coordinate gives a curve with a band of two standard errors, and so does a function of one by which another is
    multiplied; two a map with its errors beside it, a memory the loop of a record's last period, a constant its value
    in words.
    """
    picture = unknown.picture
    figure = new_figure(10.6 if picture.kind == "map" else 7.4, 4.7)
    _words(figure, unknown)
    size = float(np.nanmax(np.abs(picture.value)))
    unit = scale(size, picture.unit, device)
    top = 0.72 if law is None else 0.68
    if picture.kind == "value":
        shown = show(float(picture.value[0]), float(picture.error[0]), picture.unit, device)
        figure.text(0.5, 0.4, str(shown), fontsize=18, color=INK, ha="center")
    elif picture.kind == "map":
        worst = float(np.nanmax(picture.error))
        _map(figure, (0.065, 0.125, 0.36, top - 0.125), picture, picture.value, unit, device, _what(unknown, unit))
        errors = scale(worst, picture.unit, device)
        _map(figure, (0.565, 0.125, 0.36, top - 0.125), picture, picture.error, errors, device,
             f"its standard error ({errors.unit})")  # fmt: skip
    else:
        axes = new_axes(figure, 0.11, 0.125, 0.86, top - 0.125)
        _curve(axes, picture, unit, device, _what(unknown, unit), _known(unknown))
        if law is not None:
            _simulated(axes, law / unit.factor)
            key(figure, 0.97, top + 0.075, ("along the measured motion", MODEL), ("as simulated and fitted", RESIDUAL))
    return figure


def _words(figure: Figure, unknown: Unknown) -> None:
    words = f"Missing: {what(unknown.side, unknown.coordinates, unknown.product)}"
    size = min(10.5, _POINTS * figure.get_figwidth() / len(words))
    figure.text(0.02, 0.95, words, fontsize=size, weight="bold", color=INK, va="center")
    before, after = np.sqrt(unknown.chi2_before), np.sqrt(unknown.chi2_after)
    text = f"explains {percent(unknown.share)} of the error above the noise; error/noise {before:.2f} → {after:.2f}"
    figure.text(0.02, 0.895, text, fontsize=9.5, color=FAINT, va="center")
    if unknown.formula is not None:
        share = "" if unknown.formula.complete else f"   (explains {percent(unknown.explained(unknown.formula))})"
        lines = textwrap.wrap(unknown.formula.text + share, int(12.0 * figure.get_figwidth()))[:2]
        figure.text(0.02, 0.845, "\n".join(lines), fontsize=9.5, color=MODEL, va="top" if len(lines) > 1 else "center")


def _what(unknown: Unknown, unit: Scale) -> str:
    word = "sensor error" if unknown.side == "sensor" else "missing force"
    words = f"{word}{f' ÷ {unknown.product.name}' if unknown.product else ''}"
    return f"{words} ({unit.unit})" if unit.unit else words


def _known(unknown: Unknown) -> str:
    """What the curve lacks, as the model has it."""
    product = unknown.product
    if product is None:
        return " What is proportional to the coordinate is in the model already."
    return " What is the same everywhere is in the model already." if product.known(unknown.side) else ""


def _axis(name: str, grid: np.ndarray, device: Device) -> tuple[np.ndarray, str]:
    unit = scale(float(np.max(np.abs(grid))), UNITS[name], device)
    return grid / unit.factor, f"{_NAMES[name]} ({unit.unit})"


def _curve(axes: Axes, picture: Picture, unit: Scale, device: Device, what: str, known: str) -> None:
    x, words = _axis(picture.names[0], picture.grids[0], device)
    value, error = picture.value / unit.factor, picture.error / unit.factor
    if picture.kind != "loop":
        axes.fill_between(x, value - 2 * error, value + 2 * error, color=_SHADE, lw=0)
        note = f"band: two standard errors.{known}"
    else:
        note = f"last period of {picture.record}; typical standard error {np.median(error):.2g} {unit.unit}"
    axes.plot(x, value, color=MODEL, lw=1.4)
    axes.axhline(0, color=FAINT, lw=0.6)
    axes.set_xlim(float(np.min(x)), float(np.max(x)))
    if picture.kind != "loop":
        sure = error <= _VAGUE * np.median(error)  # at its ends a spline knows little, and would flatten the rest
        axes.set_ylim(float(np.min((value - 2 * error)[sure])), float(np.max((value + 2 * error)[sure])))
    label(axes, words, what, note)


def _simulated(axes: Axes, law: np.ndarray) -> None:
    """The law as its simulation fits it, beside what it was written from."""
    x = np.asarray(axes.lines[0].get_xdata())
    axes.plot(x, law, color=RESIDUAL, lw=1.2, ls=(0, (5, 2)))
    low, high = axes.get_ylim()
    axes.set_ylim(min(low, float(np.min(law))), max(high, float(np.max(law))))


def _map(
    figure: Figure, place: tuple[float, float, float, float], picture: Picture, values: np.ndarray, unit: Scale,
    device: Device, title: str,
) -> None:  # fmt: skip
    axes = new_axes(figure, *place)
    x, x_words = _axis(picture.names[0], picture.grids[0], device)
    y, y_words = _axis(picture.names[1], picture.grids[1], device)
    signed = bool(np.nanmin(values) < 0)
    most = float(np.nanpercentile(np.abs(values), _INNER)) / unit.factor
    shown = axes.pcolormesh(x, y, values.T / unit.factor, cmap="PuOr" if signed else "Blues",
                            vmin=-most if signed else 0.0, vmax=most, shading="nearest", rasterized=True)  # fmt: skip
    label(axes, x_words, y_words, title)
    beside = figure.add_axes((place[0] + place[2] + 0.012, place[1], 0.012, place[3]))
    bar = figure.colorbar(shown, cax=beside, extend="both" if signed else "max", extendfrac=0.03)
    bar.ax.tick_params(labelsize=8, colors=INK, length=2)
    bar.outline.set_visible(False)  # type: ignore[operator]
