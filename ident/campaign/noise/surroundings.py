"""Lines of the surroundings in what a model leaves: a pump, a fan, a supply, at no frequency of the drive.

A line is that of the surroundings if every record shows it as large, at one frequency, whatever drives them; and if two
records at least cannot have made it themselves: a device that is not linear answers at sums and differences of the
frequencies that drive it, and at no other ones.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import product
from typing import NamedTuple

import numpy as np
from scipy.ndimage import median_filter

_STANDS = 50.0  # times the power beside it, in its median: noise alone is that loud once in 10^15 times
_BESIDE = 65  # bins in which that is taken
_MOST = 3  # lines of a record, the strongest first
_ALIKE = 2.0  # times as large in one record as in another
_DRIVES = 0.01  # of the strongest line of a drive: weaker ones make no sums that stand out
_TONES, _ORDER = 2, 7  # of a drive that is told: of more tones sums and differences are everywhere
_NEAR = 1.5  # bins within which two lines are one


class Heard(NamedTuple):
    """What a model leaves of a record (n,), its drive (n,), and its sampling interval, s."""

    left: np.ndarray
    drive: np.ndarray
    step: float

    @property
    def width(self) -> float:
        """Hz, of a bin."""
        return 1.0 / (len(self.left) * self.step)


def lines_of_surroundings(records: Sequence[Heard]) -> list[float]:
    """Frequencies, Hz, of the lines that all records show alike and two cannot have made; none of fewer than two."""
    if len(records) < 2 or not all(np.all(np.isfinite(record.left)) for record in records):
        return []
    shown = [_lines(record.left, record.step)[:_MOST] for record in records]
    longest = max(range(len(records)), key=lambda i: len(records[i].left))
    found = []
    for hz, _ in shown[longest]:
        own = [
            [line for line in lines if abs(line[0] - hz) < _NEAR * (record.width + records[longest].width)]
            for lines, record in zip(shown, records, strict=True)
        ]
        if not all(own):
            continue
        sizes = [lines[0][1] for lines in own]
        clean = sum(not may_make(record, hz) for record in records)
        if max(sizes) < _ALIKE * min(sizes) and clean >= 2:
            found.append(hz)
    return found


def _lines(signal: np.ndarray, step: float) -> list[tuple[float, float]]:
    """Frequency (Hz) and amplitude of the lines that stand out of a signal (n,), the strongest first."""
    n, window = len(signal), np.hanning(len(signal))
    power = np.abs(np.fft.rfft((signal - np.mean(signal)) * window)) ** 2
    beside = median_filter(power, _BESIDE) / np.log(2)  # of noise the mean is so much more than the median
    inside = np.arange(3, len(power) - 1)
    peaks = [k for k in inside if power[k] > _STANDS * beside[k] and power[k] == power[k - 2 : k + 3].max()]
    found = []
    for k in sorted(peaks, key=lambda k: -power[k]):
        a, b, c = np.log(power[k - 1 : k + 2])
        between = 0.5 * (a - c) / min(a - 2 * b + c, -1e-12)
        found.append(((k + float(np.clip(between, -0.5, 0.5))) / (n * step), 2 * np.sqrt(power[k]) / np.sum(window)))
    return found


def may_make(record: Heard, hz: float) -> bool:
    """Whether a record's own drive may have made a line: its tones are too many, or a sum of few of them is there."""
    tones = tones_of(record)
    if tones is None:
        return True
    orders = product(range(-_ORDER, _ORDER + 1), repeat=len(tones))
    sums = [(sum(m * f for m, f in zip(order, tones, strict=True)), sum(map(abs, order))) for order in orders]
    folded = lambda f: abs(f - round(f * record.step) / record.step)  # above half the rate of samples
    return any(0 < n <= _ORDER and abs(folded(f) - hz) < _NEAR * (1 + n) * record.width for f, n in sums)


def tones_of(record: Heard) -> list[float] | None:
    """The frequencies of a drive of one or two tones, Hz; None of any other, and of a decay, of which nobody knows."""
    if not np.ptp(record.drive):
        return None
    lines = _lines(record.drive, record.step)
    tones = [line for line, size in lines if size > _DRIVES * lines[0][1]]
    return tones if 0 < len(tones) <= _TONES else None
