"""Fig. 3, the measurement: an offset near zero displacement at 8 V, 317 Hz; a resonance that rises with the drive.

The paper: "an obvious offset near the zero point of displacement"; "an increase of resonant frequency of stage from
500 Hz to 510 Hz" from 3 V to 9 V. Here the device is the independent simulator's.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ident.report.figures.style import DATA, INK, label

from . import measured
from .nominal import POINTS, Harmonics, Sine, harmonics
from .sheet import Figure, names, offset, period, sheet

LEVELS = (3.0, 5.0, 7.0, 9.0)
FREQUENCIES = np.arange(470.0, 541.0, 2.5)
SHADES = ("#9ecae1", "#6baed6", "#3182bd", "#08519c")


class Found(NamedTuple):
    """The mean measured period at 8 V, 317 Hz, its harmonics; amplitudes (levels, frequencies), and their peaks, Hz."""

    z: np.ndarray
    parts: Harmonics
    amplitudes: np.ndarray
    peaks: tuple[float, ...]


def study() -> Found:
    _, _, z = measured.record(Sine(8.0, 317.0), periods=40, settle=100)
    z = z.reshape(-1, POINTS).mean(axis=0)
    amplitudes = np.array([measured.swing(volts, FREQUENCIES) for volts in LEVELS])
    return Found(z, harmonics(z), amplitudes, tuple(top(FREQUENCIES, a) for a in amplitudes))


def top(frequencies: np.ndarray, amplitude: np.ndarray) -> float:
    """Frequency of a curve's peak, by a parabola through its three highest points, Hz."""
    i = int(np.clip(np.argmax(amplitude), 1, len(amplitude) - 2))
    a, b, c = amplitude[i - 1 : i + 2]
    return float(frequencies[i] + (frequencies[1] - frequencies[0]) * (a - c) / (2 * (a - 2 * b + c)))


def check(found: Found) -> str:
    parts, error = found.parts, measured.NOISE / np.sqrt(40 * POINTS)
    assert abs(parts.mean) > 50 * error, parts
    assert parts.second > 50 * error, parts
    assert 0.02 < parts.offset < 0.05, parts
    assert abs(found.peaks[0] - 500) < 1 and abs(found.peaks[-1] - 510) < 1, found.peaks
    assert np.all(np.diff(found.peaks) > 0), found.peaks
    return (
        f"at 8 V, 317 Hz the mean is {1e6 * parts.mean:.3f} µm and the 2nd harmonic {1e6 * parts.second:.3f} µm of an "
        f"amplitude of {1e6 * parts.first:.2f} µm; the resonance rises from {found.peaks[0]:.1f} Hz at 3 V to "
        f"{found.peaks[-1]:.1f} Hz at 9 V"
    )


def draw(found: Found) -> Figure:
    figure, (a, b, c) = sheet("Measured: the motion is offset around zero, and the resonance rises with the drive", 3)
    period(a, found.z, DATA, "8 V, 317 Hz; dashed: symmetric part")
    offset(b, found.z)
    for _volts, curve, peak, shade in zip(LEVELS, found.amplitudes, found.peaks, SHADES, strict=True):
        c.plot(FREQUENCIES, 1e6 * curve, color=shade, lw=1.8)
        c.plot(peak, 1e6 * curve.max(), "o", color=INK, ms=4)
    told = zip(LEVELS, found.peaks, SHADES, strict=True)
    names(c, [(f"{volts:g} V: {peak:.0f} Hz", shade) for volts, peak, shade in told][::-1])
    c.set_ylim(0, 85)
    label(c, "frequency (Hz)", "amplitude (µm)", "resonance at four drive levels")
    return figure
