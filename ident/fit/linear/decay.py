"""Frequency and quality of a free decay, from the decay itself.

The strongest line of the stretch that holds the energy is turned back to zero frequency; what is left turns with the
error of that frequency and falls with the decay. Nothing is projected out, so nothing can be explained away.

Source: M. Feldman, "Hilbert transform in vibration analysis", Mech. Syst. Signal Process. 25 (2011) 735, §4 (free
vibration: instantaneous frequency and damping from the analytic signal).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

_ENERGY = 0.9  # of a decay: the stretch that holds it is read, for what follows may be noise alone
_CYCLES = 3  # fewer of them have no line
_ABOVE = 0.1  # of the largest amplitude: below, noise and other modes turn the phase


class Ringing(NamedTuple):
    """A decay read as a line: `frequency` (Hz), `quality`, and the number of `cycles` that were read."""

    frequency: float
    quality: float
    cycles: float


def read_ringing(response: np.ndarray, step: float) -> Ringing | None:
    """The strongest line of a free decay (n,), sampled every `step` s; None where fewer than three cycles ring."""
    response = about_rest(response)
    line = strongest_line(response)
    if line is None:
        return None
    n = len(_lively(response))
    found = turned_back(response[:n], line)
    if found is None:
        return None
    envelope = found[1]
    size = np.abs(envelope)
    if len(size) < 4 or not size.max() > 0:
        return None
    heavy = np.where(size > _ABOVE * size.max(), size, 0.0)
    time = np.arange(len(size))
    turning = np.polyfit(time, np.unwrap(np.angle(envelope)), 1, w=heavy)[0] / (2 * np.pi)
    falling = -np.polyfit(time, np.log(np.maximum(size, 1e-300)), 1, w=heavy)[0]
    frequency = line + turning
    if not 0 < frequency < 0.5:
        return None
    quality = np.pi * frequency / max(falling, np.pi * frequency / 1e6)
    return Ringing(float(frequency / step), float(quality), float(frequency * n))


def about_rest(response: np.ndarray) -> np.ndarray:
    """A decay counted from where it comes to rest."""
    return response - np.mean(response[len(response) // 2 :])


def strongest_line(response: np.ndarray) -> float | None:
    """The line of a decay about its rest, in cycles per sample; None where fewer than three cycles ring."""
    part = _lively(response)
    line = _peak(part)
    return None if line is None or line * len(part) < _CYCLES else line


def turned_back(response: np.ndarray, line: float) -> tuple[np.ndarray, np.ndarray] | None:
    """A decay turned back by a line and averaged over two of its periods, complex (n − k + 1,), half an amplitude; and
    the window (k,), for what turns with another line has gone. None if the decay is shorter."""
    window = np.hanning(max(int(2 / line), 3) + 2)[1:-1]
    if len(window) >= len(response):
        return None
    window /= window.sum()
    turned = response * np.exp(-2j * np.pi * line * np.arange(len(response)))
    return window, np.convolve(turned, window, "valid")


def _lively(response: np.ndarray) -> np.ndarray:
    """The stretch of a decay that holds its energy."""
    energy = np.cumsum(response**2)
    return response[: max(int(np.searchsorted(energy, _ENERGY * energy[-1])) + 1, 16)]


def _peak(part: np.ndarray) -> float | None:
    """The strongest line per sample, refined by the parabola through the logarithms of its neighbours."""
    power = np.abs(np.fft.rfft(part * np.hanning(len(part) + 2)[1:-1], 2 * len(part)))
    top = int(np.argmax(power[2:])) + 2
    if not 2 < top < len(power) - 1:
        return None
    low, middle, high = np.log(power[top - 1 : top + 2] + 1e-300)
    bend = low - 2 * middle + high
    return float((top + (0.5 * (low - high) / bend if bend < 0 else 0.0)) / (2 * len(part)))
