"""Fig. 11: residual stress and hysteresis together, held against the measurement.

The paper: "The experiments and theoretical/simulation show agreement with each other." Here the model of both is fitted
to four records of the measured device from rest, and then foretells what it has not seen: the settled motion at 8 V,
317 Hz and the resonance curves at 3 and 9 V.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ident.campaign import Campaign, Channel, NoiseFloor, Platform, Trace
from ident.fit import Fit, fit_data
from ident.model import build_model
from ident.report.figures.style import DATA, MODEL, RESIDUAL, label

from . import measured
from .nominal import CLOSURE, POINTS, Sine, harmonics, platform, settled, without_offset
from .sheet import Figure, names, sheet

FITTED = (Sine(8.0, 317.0), Sine(3.0, 500.0), Sine(6.0, 505.0), Sine(9.0, 510.0))
LEVELS = (3.0, 9.0)
FREQUENCIES = np.arange(470.0, 541.0, 5.0)


class Found(NamedTuple):
    """The fit; the settled period at 8 V, 317 Hz and amplitudes (levels, frequencies), measured and foretold."""

    fit: Fit
    measured_z: np.ndarray
    model_z: np.ndarray
    measured_swing: np.ndarray
    model_swing: np.ndarray


def campaign() -> Campaign:
    """Four records of 25 periods from rest."""
    floor, channels = NoiseFloor(measured.NOISE, method="given"), (Channel("V", 1.0), Channel("um", 1e-6))
    records = [
        Trace(f"{s.volts:g} V, {s.hertz:g} Hz", *measured.record(s, 25, seed=1 + i), *channels, floor, "rest")
        for i, s in enumerate(FITTED)
    ]
    return Campaign("Fig. 11", tuple(records), Platform(), settings={"residual-stress": {"closure": CLOSURE}})


def study() -> Found:
    told = campaign()
    fit = fit_data(told, build_model(told, platform().names))
    values = dict(zip((p.name for p in fit.model.parameters), fit.values.tolist(), strict=True))
    curves = [[Sine(volts, float(f)) for f in FREQUENCIES] for volts in LEVELS]
    return Found(
        fit,
        measured.record(Sine(8.0, 317.0), periods=40, settle=100)[2].reshape(-1, POINTS).mean(axis=0),
        settled([Sine(8.0, 317.0)], values)[0],
        np.array([measured.swing(volts, FREQUENCIES) for volts in LEVELS]),
        np.array([[harmonics(z).swing for z in settled(curve, values)] for curve in curves]),
    )


def check(found: Found) -> str:
    ratio = found.fit.fitted.error_over_noise
    assert 0.97 < ratio < 1.03, ratio
    apart = np.max(np.abs(found.model_swing / found.measured_swing - 1))
    assert apart < 0.005, apart
    one, other = harmonics(found.measured_z), harmonics(found.model_z)
    for a, b in ((one.mean, other.mean), (one.second, other.second)):
        assert abs(a - b) < 5 * measured.NOISE / np.sqrt(20 * POINTS), (one, other)
    return (
        f"fitted to four records the model leaves {ratio:.3f} of their noise; it foretells the settled mean as "
        f"{1e6 * other.mean:.4f} µm (measured {1e6 * one.mean:.4f}), the 2nd harmonic as {1e6 * other.second:.4f} µm "
        f"({1e6 * one.second:.4f}), and the amplitudes of the resonance curves within {100 * apart:.2f} %"
    )


def draw(found: Found) -> Figure:
    figure, (a, b, c) = sheet("Residual stress and hysteresis together: the fitted model foretells the measurement", 3)
    phase = np.arange(POINTS) / POINTS
    for axes, shape in ((a, lambda z: z), (b, lambda z: z - without_offset(z))):
        axes.axhline(0, color="#cccccc", lw=0.8)
        axes.plot(phase, 1e6 * shape(found.measured_z), color=DATA, lw=4)
        axes.plot(phase, 1e6 * shape(found.model_z), color=MODEL if axes is a else RESIDUAL, lw=1.3)
    label(a, "time (periods of the drive)", "displacement (µm)", "8 V, 317 Hz")
    label(b, "time (periods of the drive)", "offset (µm)", "what is not symmetric")
    for curve, points in zip(found.model_swing, found.measured_swing, strict=True):
        c.plot(FREQUENCIES, 1e6 * points, "o", color=DATA, ms=6)
        c.plot(FREQUENCIES, 1e6 * curve, color=MODEL, lw=1.3)
    label(c, "frequency (Hz)", "amplitude (µm)", "resonance at 3 V and 9 V, not fitted")
    names(c, [("measured", "#6f6f6f"), ("model", MODEL)])
    return figure
