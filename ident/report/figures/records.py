"""One figure per record: model over data, what it leaves, and the response seen against its own drive."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ...campaign.device import Device, Platform
from ...campaign.drive import drive_frequency
from ...campaign.drive_sine import DriveSine, drive_sine
from ...campaign.record import Trace
from ...fit.judge import RecordScore
from ...fit.linear.decay_curve import decay_curves
from ...units import ratio_text
from ..words.drives import drive_words
from ..words.quantity import Scale, reading_unit, scale, show_in
from ..words.tables import error_scale
from .decays import draw_decay
from .style import (
    BAND,
    DATA,
    DPI,
    FAINT,
    HELDOUT,
    INK,
    MEASURED,
    MODEL,
    RESIDUAL,
    emptied,
    envelope,
    key,
    label,
    new_axes,
    new_figure,
)

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_WHOLE = 40  # periods up to which a record is shown whole
_PIECES = (12, 8, 8)  # periods shown of the beginning, middle and end of a longer one
_BELOW, _BESIDE = 19, (36, 36, 44, 44)  # points from each axes to its names, past its numbers: there is no more room
_FOLDED = 8  # last periods that are folded on the drive's phase


Layout = tuple[str, bool]  # what stands beside: "folded", "decay" or "spectrum"; and whether the record is shown whole


def record_figure(
    record: Trace, reading: np.ndarray, score: RecordScore, device: Device, used: dict[Layout, Figure] | None = None
) -> Figure:
    """Model over data with the residual in noise floors under it, and beside it the response against the drive.

    A record with a ruling drive frequency is folded on it (against phase, and against voltage); a free decay shows its
    frequency and damping against amplitude; any other record is shown as a spectrum.

    **Arguments:** `reading` (n,) of the model, SI; `used`, figures of other records that are saved already: the one
    of the same layout is drawn on again, which is twice as fast.
    """
    size = float(np.max(np.abs(record.response)))
    unit = scale(size, reading_unit([record]), device)
    sine = drive_sine(record)
    pieces = _pieces(record, sine)
    curves = () if record.driven else decay_curves(record.response, reading, record.step, record.noise.sigma)
    layout = ("folded" if sine is not None else "decay" if curves else "spectrum", len(pieces) == 1)
    used = {} if used is None else used
    figure = used[layout] = emptied(used[layout]) if layout in used else _blank(layout)
    _title(figure, record, score, device)
    what = f"{'displacement' if isinstance(device, Platform) else 'response'} ({unit.unit})"
    top, low, *beside = figure.axes
    _over_time(top, low, record, reading, unit, pieces, what)
    key(figure, 0.631, 0.825, ("measured", MEASURED), ("model", MODEL))
    if curves:
        draw_decay(beside[0], beside[1], curves, unit)
    elif sine is None:
        _spectrum(beside[0], record, reading, device)
        key(figure, 0.985, 0.825, ("measured", MEASURED), ("residual", RESIDUAL), ("noise", INK))
    else:
        phase, loop = beside
        _phase(phase, record, reading, unit, sine, what)
        _loop(loop, record, reading, unit, sine, device, what)
    return figure


def _blank(layout: Layout) -> Figure:
    """Empty axes: over time, the residual under it, and beside them phase and loop or a spectrum."""
    beside, whole = layout
    figure = new_figure(10.6, 4.7)
    top = new_axes(figure, 0.066, 0.42, 0.565, 0.385)
    new_axes(figure, 0.066, 0.105, 0.565, 0.205)
    top.tick_params(labelbottom=not whole)
    if beside != "spectrum":
        upper = new_axes(figure, 0.71, 0.545, 0.275, 0.26)
        new_axes(figure, 0.71, 0.105, 0.275, 0.295)
        if beside == "folded":
            upper.set_xticks([0, 90, 180, 270, 360])
    else:
        spectrum = new_axes(figure, 0.71, 0.105, 0.275, 0.70)
        spectrum.set_yscale("log")
        spectrum.minorticks_off()
        spectrum.yaxis.set_major_formatter("{x:g}")  # plain text: powers of ten would go through a slow typesetter
    for axes, aside in zip(figure.axes, _BESIDE, strict=False):  # told, for to find it all numbers are set once more
        width, height = (72 / DPI * pixels for pixels in (axes.bbox.width, axes.bbox.height))
        axes.xaxis.set_label_coords(0.5, -_BELOW / height)
        axes.yaxis.set_label_coords(-aside / width, 0.5)
    return figure


def _title(figure: Figure, record: Trace, score: RecordScore, device: Device) -> None:
    words = f"{record.name}:  {drive_words(record, device)}"
    figure.text(0.012, 0.955, words, fontsize=12, weight="bold", color=INK, va="center")
    chosen = error_scale(score, device, reading_unit([record]))
    error, noise = (show_in(v, None, chosen, 3).value for v in (score.rmse, score.noise_rmse))
    use = "held out" if record.holdout else "fitted"
    ratio = ratio_text(score.error_over_noise)
    text = f"{use}:  rms error {error} {chosen.unit}, noise floor {noise} {chosen.unit},  error/noise {ratio}"
    figure.text(0.012, 0.90, text, fontsize=9.5, color=HELDOUT if record.holdout else FAINT, va="center")


def _over_time(
    top: Axes, low: Axes, record: Trace, reading: np.ndarray, unit: Scale, pieces: list[tuple[int, int]], what: str
) -> None:
    factor, name = (1e3, "ms") if record.time[-1] - record.time[0] < 2.0 else (1.0, "s")
    time = (record.time - record.time[0]) * factor
    data, model = record.response / unit.factor, reading / unit.factor
    if len(pieces) == 1:
        top.plot(time, data, color=DATA, lw=2.6, solid_capstyle="round")
        top.plot(time, model, color=MODEL, lw=0.9)
        top.set_xlim(time[0], time[-1])
    else:
        _broken(top, time, data, model, pieces)
        for start, stop in pieces:
            low.axvspan(time[start], time[stop - 1], color=BAND, lw=0)
    label(top, y=what)
    residual = (record.response - reading) / record.noise.sigma
    low.axhspan(-2, 2, color=BAND if len(pieces) == 1 else "none", lw=0)
    low.plot(*envelope(time, residual), color=RESIDUAL, lw=0.7)
    low.axhline(0, color=INK, lw=0.6)
    largest = float(np.max(np.abs(residual[record.skip :]))) if np.all(np.isfinite(residual)) else 5.0
    low.set_ylim(-1.08 * max(largest, 3.0), 1.08 * max(largest, 3.0))
    low.set_xlim(time[0], time[-1])
    shade = " (shaded: shown above)" if len(pieces) > 1 else " (shaded: ±2)"
    shade += ", grey: not counted" if record.skip else ""
    label(low, f"time ({name})", "÷ noise floor", f"residual, measured − model, in noise floors{shade}")
    if record.skip:
        for axes in (top, low) if len(pieces) == 1 else (low,):
            axes.axvspan(time[0], time[record.skip], color="#f3f3f3", lw=0)
            axes.axvline(time[record.skip], color=FAINT, lw=0.8, ls=":")


def _pieces(record: Trace, sine: DriveSine | None) -> list[tuple[int, int]]:
    """Sample ranges to show: the whole record, or its beginning, middle and end."""
    n = len(record.response)
    period = sine.period if sine is not None else 2 * np.pi / max(drive_frequency(record) * record.step, 4 * np.pi / n)
    if n <= max(_WHOLE, 1.6 * sum(_PIECES)) * period:
        return [(0, n)]
    first, middle, last = (max(int(count * period), 2) for count in _PIECES)
    start = (n - middle) // 2
    return [(0, first), (start, start + middle), (n - last, n)]


def _broken(axes: Axes, time: np.ndarray, data: np.ndarray, model: np.ndarray, pieces: list[tuple[int, int]]) -> None:
    """Pieces of a long record side by side on one axis, their true times written under them."""
    step = time[1] - time[0]
    shown = sum(stop - start for start, stop in pieces)
    gap, at = 0.025 * shown * step, 0.0
    places = max(3 - int(np.log10(max(time[-1], 1e-9))), 0)
    ticks: list[tuple[float, str]] = []
    for i, (start, stop) in enumerate(pieces):
        x = at + np.arange(stop - start) * step
        axes.plot(x, data[start:stop], color=DATA, lw=2.6)
        axes.plot(x, model[start:stop], color=MODEL, lw=0.9)
        ticks += [(x[0], f"{time[start]:.{places}f}"), (x[-1], f"{time[stop - 1]:.{places}f}")]
        if i:
            axes.axvspan(at - gap, at, color="#f0f0f0", lw=0)
        at = x[-1] + gap
    axes.set_xlim(0, at - gap)
    axes.set_xticks([x for x, _ in ticks], [text for _, text in ticks])
    for i, tick in enumerate(axes.get_xticklabels()):
        tick.set_horizontalalignment("left" if i % 2 == 0 else "right")


def _last_periods(record: Trace, sine: DriveSine) -> np.ndarray:
    """Sample numbers of the last whole periods."""
    n = len(record.response)
    count = max(min(_FOLDED, int((n - record.skip) / sine.period) // 2), 1)
    return np.arange(max(n - round(count * sine.period), 0), n)


def _phase(axes: Axes, record: Trace, reading: np.ndarray, unit: Scale, sine: DriveSine, what: str) -> None:
    samples = _last_periods(record, sine)
    turn = np.degrees(sine.angle(samples)) % 360
    axes.plot(turn, record.response[samples] / unit.factor, ".", color=DATA, ms=3)
    breaks = np.flatnonzero(np.diff(turn) < 0) + 1
    model = np.insert(reading[samples] / unit.factor, breaks, np.nan)
    axes.plot(np.insert(turn, breaks, np.nan), model, color=MODEL, lw=1.0)
    axes.axhline(0, color=FAINT, lw=0.6)
    axes.set_xlim(0, 360)
    count = round(len(samples) / sine.period)
    label(axes, "drive phase (°)", what, f"last {count} periods, against the drive's phase")


def _loop(
    axes: Axes, record: Trace, reading: np.ndarray, unit: Scale, sine: DriveSine, device: Device, what: str
) -> None:
    samples = _last_periods(record, sine)
    volt = scale(sine.amplitude, "V", device)
    drive = record.drive[samples] / volt.factor
    axes.plot(drive, record.response[samples] / unit.factor, ".", color=DATA, ms=3)
    axes.plot(drive, reading[samples] / unit.factor, color=MODEL, lw=0.9)
    axes.axhline(0, color=FAINT, lw=0.6)
    axes.axvline(0, color=FAINT, lw=0.6)
    label(axes, f"drive ({volt.unit})", what, "against the drive")


def _spectrum(axes: Axes, record: Trace, reading: np.ndarray, device: Device) -> None:
    """Amplitude spectra of data and residual beside the noise floor: where in frequency the model fails."""
    counted = slice(record.skip, None)
    measured, left = record.response[counted], (record.response - reading)[counted]
    n = len(measured)
    window = np.hanning(n)
    frequency = np.fft.rfftfreq(n, record.step)
    spectrum, remaining = (2 * np.abs(np.fft.rfft((x - x.mean()) * window)) / window.sum() for x in (measured, left))
    floor = 2 * record.noise.sigma * np.sqrt(np.sum(window**2)) / window.sum()
    unit = scale(float(np.max(spectrum)), reading_unit([record]), device)
    # As far as the response rises above the noise: what lies beyond is empty.
    last = max(int(np.max(np.flatnonzero(np.maximum(spectrum, remaining) > 5 * floor), initial=0)), 20)
    shown = slice(1, min(2 * last, len(frequency)))
    for values, colour, width in ((spectrum, DATA, 1.8), (remaining, RESIDUAL, 0.8)):
        axes.plot(*envelope(frequency[shown], values[shown] / unit.factor, 400), color=colour, lw=width)
    axes.axhline(floor / unit.factor, color=INK, lw=0.9, ls="--")
    top = max(float(np.max(spectrum)), float(np.max(remaining)), 10 * floor)
    axes.set_ylim(0.2 * floor / unit.factor, 2 * top / unit.factor)
    axes.set_xlim(frequency[shown][0], frequency[shown][-1])
    label(axes, "frequency (Hz)", f"amplitude ({unit.unit})")
