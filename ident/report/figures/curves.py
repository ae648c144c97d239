"""The figure of a sweep: measured points on the model's curves, and what is left of each level in noise floors."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ...campaign.device import Platform
from ...fit.curve_reading import CurveReading, RunReading
from ...fit.result import Fit
from ...units import ratio_text
from ..run_json import jump_error
from ..words.drives import drive_words
from ..words.quantity import scale, show_in
from ..words.tables import error_scale
from .style import BAND, DATA, FAINT, HELDOUT, INK, MEASURED, MODEL, RESIDUAL, key, label, new_axes, new_figure

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_MOST_JUMPS = 4  # told in words


def curve_figure(curve: CurveReading, fit: Fit) -> Figure:
    """Amplitude over frequency, above the residuals of every point in noise floors.

    Circles: measured, filled where the frequency rose; lines: the model's curves, dashed where it is unstable; the
    thin dotted line joins the peaks of the levels (the backbone); vertical lines: where it jumps. Of a sweep that was
    run fast the line is the model as it was run, and its settled curves are grey.
    """
    device, sweep = fit.model.device, curve.sweep
    unit = scale(float(np.max(sweep.amplitude)), "m", device)
    figure = new_figure(10.6, 5.4)
    top, low = new_axes(figure, 0.066, 0.36, 0.92, 0.46), new_axes(figure, 0.066, 0.095, 0.92, 0.17)
    words = f"{sweep.name}:  {drive_words(sweep, device)}"
    figure.text(0.012, 0.955, words, fontsize=12, weight="bold", color=INK, va="center")
    figure.text(0.012, 0.905, _error_words(curve, fit), fontsize=9.5, va="center",
                color=HELDOUT if sweep.holdout else FAINT)  # fmt: skip
    figure.text(0.012, 0.865, _jump_words(curve, fit), fontsize=9.5, color=FAINT, va="center")
    _over_frequency(top, curve, unit.factor)
    label(top, "", f"{'amplitude' if isinstance(device, Platform) else 'response'} ({unit.unit})")
    model = "model (dashed: unstable)" if curve.passed is None else "model as it was run (grey: settled)"
    key(figure, 0.986, 0.84, ("measured up ●, down ○", MEASURED), (model, MODEL))
    _left(low, curve)
    low.set_xlim(*top.get_xlim())
    return figure


def _error_words(curve: CurveReading, fit: Fit) -> str:
    score = curve.score
    chosen = error_scale(score, fit.model.device)
    error, noise = (show_in(v, None, chosen, 3).value for v in (score.rmse, score.noise_rmse))
    use = "held out" if curve.sweep.holdout else "fitted"
    share = 100 * score.rmse / float(np.max(curve.sweep.amplitude))
    return (f"{use}:  rms error {error} {chosen.unit} ({share:.2g} % of the peak), noise floor {noise} {chosen.unit},  "
            f"error/noise {ratio_text(score.error_over_noise)}")  # fmt: skip


def _jump_words(curve: CurveReading, fit: Fit) -> str:
    told, drive = [], curve.sweep.drive_channel
    for run in curve.runs:
        if run.jump is None or len(told) == _MOST_JUMPS:
            continue
        level = f"{run.run.level / drive.factor:.3g} {drive.unit}"
        told.append(f"{level} {'up' if run.run.up else 'down'}: {jump_words(run, fit)}")
    return "jumps:  " + ";  ".join(told) if told else ""


def jump_words(run: RunReading, fit: Fit) -> str:
    """A jump as measured and as the model has it."""
    jump = run.jump
    assert jump is not None
    measured = "no jump measured" if jump.measured is None else f"measured {jump.measured:.2f} Hz"
    if jump.model is None:
        return f"{measured}, model none"
    error = jump_error(jump, fit)
    return f"{measured}, model {jump.model:.2f}" + (f" ± {error:.2g} Hz" if error is not None else " Hz")


def _over_frequency(axes: Axes, curve: CurveReading, factor: float) -> None:
    sweep, peaks = curve.sweep, []
    seen = set()
    for run in curve.runs:
        rows, branch = run.run.rows, run.branch
        filled = DATA if run.run.up else "none"
        axes.plot(sweep.frequency[rows], sweep.amplitude[rows] / factor, "o", ms=3.2, mfc=filled, mec=DATA, mew=0.8)
        if run.run.level not in seen and len(branch.length) > 1:
            seen.add(run.run.level)
            size = (branch.swing if sweep.quantity == "half-peak-to-peak" else np.abs(branch.tone)) / factor
            ink = MODEL if curve.passed is None else FAINT
            for part in branch.stretches:
                _curve(axes, branch.frequency[part], size[part], branch.stable[part], ink)
            peaks.append((branch.frequency[np.argmax(size)], np.max(size)))
        if curve.passed is not None:
            axes.plot(sweep.frequency[rows], run.reading / factor, color=MODEL, lw=1.1)
        if run.jump is not None and run.jump.model is not None:
            axes.axvline(run.jump.model, color=MODEL, lw=0.6, ls="-" if run.run.up else ":")
    axes.plot(*np.array(peaks).T, color=INK, lw=0.8, ls=":") if len(peaks) > 1 else None
    low, high = float(np.min(sweep.frequency)), float(np.max(sweep.frequency))
    axes.set_xlim(low - 0.02 * (high - low), high + 0.02 * (high - low))
    axes.set_ylim(bottom=0)


def _curve(axes: Axes, frequency: np.ndarray, size: np.ndarray, stable: np.ndarray, ink: str) -> None:
    """A curve in stretches, solid where it is stable."""
    ends = [0, *(np.flatnonzero(stable[1:] != stable[:-1]) + 1), len(stable) - 1]
    for first, last in zip(ends[:-1], ends[1:], strict=True):
        part = slice(first, last + 1)
        axes.plot(frequency[part], size[part], color=ink, lw=1.1, ls="-" if stable[first] else (0, (4, 2)))


def _left(axes: Axes, curve: CurveReading) -> None:
    sweep = curve.sweep
    residual = -curve.residual
    axes.axhspan(-2, 2, color=BAND, lw=0)
    for up in (True, False):
        own = sweep.up == up
        axes.plot(
            sweep.frequency[own], residual[own], "o", ms=2.6, mfc=RESIDUAL if up else "none", mec=RESIDUAL, mew=0.7
        )
    axes.axhline(0, color=INK, lw=0.6)
    largest = max(float(np.nanmax(np.abs(residual), initial=0.0)), 3.0)
    for order, left in curve.of_harmonics:
        axes.plot(sweep.frequency, -left, marker=f"${order}$", ls="", ms=4.2, mfc=FAINT, mec=FAINT, mew=0.2)
        largest = max(largest, float(np.nanmax(np.abs(left), initial=0.0)))
    axes.set_ylim(-1.08 * largest, 1.08 * largest)
    words = "residual, measured − model, in noise floors (shaded: ±2)"
    words += "; numbers: harmonics" if curve.of_harmonics else ""
    label(axes, "frequency (Hz)", "÷ noise floor", words)
