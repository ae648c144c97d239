"""What drove a record, in the words of the laboratory: "8 V sine at 317 Hz, 40 mg on the stage"."""

from __future__ import annotations

from functools import partial

import numpy as np

from ...campaign.device import Device
from ...campaign.drive import drive_frequency
from ...campaign.drive_sine import drive_sine
from ...campaign.record import Record, Sweep, Trace
from .quantity import neat, scale

_SINE = 0.98  # share of the drive's variance in its fundamental above which it is called a sine
_NEAR = 0.1  # relative distance within which two frequencies are one
_FADED = 0.05  # of a record, at each of its ends, against leakage
_ALONE = 0.7  # share of the power of V̇ in one frequency; a triangle has 0.81


def only_frequency(record: Trace) -> float | None:
    """The one rate (Hz) at which a drive repeats, whatever its waveform, level and offset; None if it has several.

    Looked for in the rate of the voltage, where a slow change of level or offset weighs little, and in all of the
    record alike: with its ends faded out a sweep would have the frequencies of its middle only.
    """
    slope = np.diff(record.drive)
    power = np.abs(np.fft.rfft((slope - slope.mean()) * _fade(len(slope)))) ** 2
    if power.sum() == 0.0:
        return None
    at = np.arange(len(power))
    top = int(np.argmax(power))
    share = float(power[np.abs(at - top) <= max(_NEAR * top, 3)].sum() / power.sum())
    return top / (len(slope) * record.step) if share > _ALONE else None


def _fade(n: int) -> np.ndarray:
    """One but at the ends of n samples, where it falls like a cosine to zero (Tukey's window; `scipy.signal` takes
    as long to import as a page to draw)."""
    to_end = np.minimum(np.arange(n), np.arange(n)[::-1])
    return 0.5 - 0.5 * np.cos(np.pi * np.minimum(to_end / max(_FADED * (n - 1), 1.0), 1.0))


def drive_words(record: Record, device: Device) -> str:
    """Waveform, level and frequency of a record's drive, and the load."""
    level = partial(_rounded, unit="V", device=device)
    if isinstance(record, Sweep):
        return _sweep_words(record, level) + (f", {_rounded(record.load, 'kg', device)} load" if record.load else "")
    sine = drive_sine(record)
    if sine is not None:
        kind = "sine" if sine.share > _SINE else "periodic drive"
        words = f"{level(sine.amplitude)} {kind} at {neat(1 / (sine.period * record.step))} Hz"
    elif not np.any(record.drive):
        words = "no drive, a free decay"
    elif np.ptp(record.drive) == 0.0:
        words = f"constant {level(float(record.drive[0]))}"
    else:
        centre = drive_frequency(record) / (2 * np.pi)
        peak = float(np.max(np.abs(record.drive)))
        words = f"changing drive, up to {level(peak)}, around {neat(centre, 2)} Hz"
    return words + (f", {_rounded(record.load, 'kg', device)} load" if record.load else "")


def _sweep_words(record: Sweep, level: partial[str]) -> str:
    levels = sorted({run.level for run in record.runs})
    ends = f"{neat(float(np.min(record.frequency)))} to {neat(float(np.max(record.frequency)))} Hz"
    both = "" if np.all(record.up) else " down" if not np.any(record.up) else " up and down"
    many = level(levels[0]) if len(levels) == 1 else f"{len(levels)} levels, {level(levels[0])} to {level(levels[-1])}"
    return f"sweep{both}, {ends}, {many}"


def _rounded(value: float, unit: str, device: Device) -> str:
    """An SI value with three digits, no zeros behind the point."""
    chosen = scale(abs(float(f"{value:.2e}")), unit, device)  # 0.99999 V is 1 V, not 1000 mV
    return f"{neat(value / chosen.factor, 3)} {chosen.unit}".strip()
