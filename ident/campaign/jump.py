"""Jumps of amplitude-frequency curves: where a branch ends, and what that tells about the direction of the sweep."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

_LEAST = 0.15
"""Of the largest amplitude: what a jump changes at least; noise of 2 % reaches that once in a million steps."""
_STANDS_OUT = 3.0
"""A jump, over the larger of the two steps before and after it. A resonance that is measured at three points or more
within its half-power width has neighbouring steps of about the same size: at most 2.4 times for a Lorentzian."""


@dataclass(frozen=True)
class Jump:
    """A jump between two neighbouring points of a run.

    **Arguments:**

    - `frequency`: Hz, midway; `uncertainty`: half the distance of the two points, Hz; `after`: index, in the order of
      rising frequency, of the upper of them; `rise`: whether the amplitude is larger above it than below.
    """

    frequency: float
    uncertainty: float
    after: int
    rise: bool


def find_jump(frequency: np.ndarray, amplitude: np.ndarray, phase: np.ndarray | None = None) -> Jump | None:
    """The jump of one run, or None.

    A step is a jump if it stands out from the steps beside it and nothing as steep lies on the other side of the peak.

    **Arguments:** `frequency`, `amplitude`, `phase`: (k,) of one run, in any order.
    """
    order = np.argsort(frequency, kind="stable")
    f, a = frequency[order], amplitude[order]
    if len(f) < 6:
        return None
    response = a if phase is None else a * np.exp(1j * phase[order])
    steps = np.abs(np.diff(response))
    padded = np.concatenate([[0.0], steps, [0.0]])
    beside = np.maximum(padded[:-2], padded[2:])
    change = np.diff(a)
    k = int(np.argmax(np.where(np.abs(change) > _LEAST * np.max(a), steps / np.maximum(beside, 1e-300), 0.0)))
    if abs(change[k]) <= _LEAST * np.max(a) or steps[k] < _STANDS_OUT * beside[k]:
        return None
    if phase is None and np.max(-np.sign(change[k]) * change, initial=0.0) > 0.5 * abs(change[k]):
        return None  # as steep on the other side: a resonance that is measured at too few points
    return Jump(float(f[k] + f[k + 1]) / 2, float(f[k + 1] - f[k]) / 2, k + 1, bool(change[k] > 0))


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
