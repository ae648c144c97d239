"""Jumps of amplitude-frequency curves: where a branch ends, and what that tells about the direction of the sweep."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..record import Sweep, same_level

LEAST = 0.15
"""Of the largest amplitude: what a jump changes at least; noise of 2 % reaches that once in a million steps."""
_STANDS_OUT = 3.0
"""A jump, over the larger of the changes before and after it, over as many points. A resonance that is measured at
three points or more within its half-power width for each of these changes about as much beside: at most 2.4 times less
for a Lorentzian."""
_WIDEST = 3
"""Intervals that a jump takes: a motion that is not given the time lingers where its branch has ended, and swings about
the other, at one point or two. For each interval, as many points within the half-power width are asked for."""
_REPEATED = 0.1
"""Of the change: as near runs both ways are where nothing lingers; where it does, they are apart by all of it."""


@dataclass(frozen=True)
class Jump:
    """A jump between two points of a run.

    **Arguments:**

    - `frequency`: Hz, midway; `uncertainty`: half the distance of the two points, Hz; `low`, `high`: their indices, in
      the order of rising frequency, with at most two points between them on which the motion was on its way; `after`:
      index of the upper point of the largest step; `rise`: whether the amplitude is larger above it than below.
    """

    frequency: float
    uncertainty: float
    low: int
    high: int
    after: int
    rise: bool


def find_jump(frequency: np.ndarray, amplitude: np.ndarray, phase: np.ndarray | None = None) -> Jump | None:
    """The jump of one run, or None.

    A change over one interval, or over a few if none does alone, is a jump if it stands out from those beside it and
    nothing as steep lies on the other side of the peak.

    **Arguments:** `frequency`, `amplitude`, `phase`: (k,) of one run, in any order.
    """
    order = np.argsort(frequency, kind="stable")
    f, a = frequency[order], amplitude[order]
    if len(f) < 6:
        return None
    response = a if phase is None else a * np.exp(1j * phase[order])
    within = int(np.count_nonzero(a >= np.sqrt(0.5) * np.max(a)))
    for width in range(1, _WIDEST + 1):
        if width > 1 and within < 3 * width:
            break
        low = _jumps_after(a, response, width)
        if low is not None:
            high = low + width
            after = low + 1 + int(np.argmax(np.abs(np.diff(response[low : high + 1]))))
            return Jump(
                float(f[low] + f[high]) / 2, float(f[high] - f[low]) / 2, low, high, after, bool(a[high] > a[low])
            )
    return None


def jump_of(sweep: Sweep, rows: np.ndarray) -> Jump | None:
    """The jump of one run of a sweep, its `rows` in any order; or None.

    A change over several points that the run the other way repeats is a steep curve: what lingers does so on one side.
    """
    f, a = sweep.frequency, sweep.amplitude
    jump = find_jump(f[rows], a[rows], None if sweep.phase is None else sweep.phase[rows])
    if jump is None or jump.high == jump.low + 1:
        return jump
    level = next(group for group in same_level(sweep.level) if rows[0] in group)
    back = level[sweep.up[level] != sweep.up[rows[0]]]
    back, own = back[np.argsort(f[back])], rows[np.argsort(f[rows])][jump.low : jump.high + 1]
    if not len(back) or f[back[0]] > f[own[0]] or f[back[-1]] < f[own[-1]]:
        return jump
    apart = np.abs(np.interp(f[own], f[back], a[back]) - a[own])
    return None if np.max(apart) < _REPEATED * abs(a[own[-1]] - a[own[0]]) else jump


def unbroken(sweep: Sweep, rows: np.ndarray) -> list[np.ndarray]:
    """The points of one run, its `rows` in the order of rising frequency, before and after its jump."""
    jump = jump_of(sweep, rows)
    return [rows] if jump is None else np.split(rows, [jump.after])


def on_two_branches(one: np.ndarray, other: np.ndarray) -> np.ndarray:
    """(k,) whether amplitudes that were read at the same frequencies are farther apart than one branch allows, or stand
    beside such ones: on a flank of a jump."""
    apart = np.abs(one - other) > LEAST * np.maximum(one, other)
    return apart | np.append(apart[1:], False) | np.append(False, apart[:-1])


def _jumps_after(a: np.ndarray, response: np.ndarray, width: int) -> int | None:
    """The point from which the response jumps within so many intervals, or None."""
    steps, change = np.abs(response[width:] - response[:-width]), a[width:] - a[:-width]
    padded = np.concatenate([np.zeros(width), steps, np.zeros(width)])
    beside = np.maximum(padded[: len(steps)], padded[2 * width :])
    large = np.abs(change) > LEAST * np.max(a)
    k = int(np.argmax(np.where(large, steps / np.maximum(beside, 1e-300), 0.0)))
    if not large[k] or steps[k] < _STANDS_OUT * beside[k]:
        return None
    if np.isrealobj(response) and np.max(-np.sign(change[k]) * change, initial=0.0) > 0.5 * abs(change[k]):
        return None  # as steep on the other side: a resonance that is measured at too few points
    return k


def loop_runs_backwards(up: Jump | None, down: Jump | None) -> bool | None:
    """Whether two runs at one level have been given each other's direction; None where the jumps do not tell.

    A branch is followed beyond the point where the other one would be reached, so that the jump of the upward run never
    lies below that of the downward run, be the resonance hardening or softening.

    Source: A. H. Nayfeh, D. T. Mook, Nonlinear Oscillations, 1979, §4.1.1.
    """
    if up is None or down is None or up.rise != down.rise:
        return None
    apart = up.uncertainty + down.uncertainty
    if abs(up.frequency - down.frequency) <= apart:
        return None
    return up.frequency < down.frequency
