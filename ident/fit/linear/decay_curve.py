"""Frequency and damping of a free decay against its amplitude, with no model: what bends them is the physics.

Source: M. Feldman, "Hilbert transform in vibration analysis", Mech. Syst. Signal Process. 25 (2011) 735, §4 (FREEVIB).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from .decay import about_rest, strongest_line, turned_back

_CYCLES = 4.0  # of a stretch: less, and noise turns the phase; more, and what changes is averaged
_STRETCHES = 24  # at most: more would hide the curve in its points
_ABOVE = 20.0  # noise floors of the envelope: its phase is then known to 3°


class DecayCurve(NamedTuple):
    """Per stretch of a decay: `amplitude` in the unit of the response, `frequency` Hz, and `rate` 1/s at which the
    amplitude dies out, (k,) each."""

    amplitude: np.ndarray
    frequency: np.ndarray
    rate: np.ndarray


def decay_curves(response: np.ndarray, reading: np.ndarray, step: float, sigma: float) -> tuple[DecayCurve, ...]:
    """The curves of a decay and of a model's reading of it over the same stretches; none if it does not ring.

    **Arguments:** `response`, `reading`: (n,); `step`, s; `sigma`: noise of the response.
    """
    response = about_rest(response)
    line = strongest_line(response)
    both = None if line is None else [turned_back(x, line) for x in (response, about_rest(reading))]
    if line is None or both is None or both[0] is None or both[1] is None:
        return ()
    (window, envelope), (_, other) = both[0], both[1]
    loud = np.flatnonzero(np.abs(envelope) > _ABOVE * sigma * float(np.sqrt(np.sum(window**2))))
    last = int(loud[-1]) if len(loud) else 0
    length = max(_CYCLES / line, last / _STRETCHES)
    edges = np.arange(0, last, length).astype(int)
    if len(edges) < 3:
        return ()
    stretches = list(zip(edges[:-1], edges[1:], strict=True))
    return tuple(_curve(one, stretches, line, step) for one in (envelope, other))


def _curve(envelope: np.ndarray, stretches: list[tuple[int, int]], line: float, step: float) -> DecayCurve:
    phase, size = np.unwrap(np.angle(envelope)), np.log(np.maximum(np.abs(envelope), 1e-300))
    rows = []
    for first, last in stretches:
        time = step * np.arange(last - first)
        turning, falling = (np.polyfit(time, part[first:last], 1)[0] for part in (phase, size))
        rows.append((2 * np.exp(np.mean(size[first:last])), line / step + turning / (2 * np.pi), -falling))
    return DecayCurve(*np.array(rows).T)
