"""How far two passes over the same frequencies differ where both lie on one branch: what no steady model explains.

Neighbouring points of a pass are taken within seconds, the two passes minutes or hours apart. What has drifted between
them (temperature, a drive, a clamp) is smooth along each pass, so that the scatter of neighbours does not show it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from ..record import Run, Sweep
from .jump import on_two_branches

_FEWEST = 8  # points on one branch, so that a median means something
_USUAL = 0.9  # share of the points that counts: beside a fold a small drift makes a large difference
CLEAR = 2.0
"""Times the variance that the noise explains, beyond which passes are called different."""


def with_repeatability(sweep: Sweep, group: Sequence[Sweep], notes: list[str]) -> Sweep:
    """The sweep with what up and down differ by as noise in proportion to the amplitude, said in `notes`.

    **Arguments:** `group`: the sweeps of the same device in the same state, this one among them, one of which may hold
    the other direction.
    """
    if sweep.dwell is not None:  # a fast sweep differs from its way back by physics
        return sweep
    shares = []
    for run in sweep.runs:
        for other in group:
            for back in other.runs:
                if back.is_back_of(run):
                    shares.append(_excess(sweep, run, other, back))
    excess = float(np.median([share for share in shares if share is not None] or [0.0]))
    if excess <= 0.0:
        return sweep
    total, own = float(np.hypot(sweep.relative_noise, np.sqrt(excess))), sweep.own_noise
    if own is not None:
        own = np.stack([own[0], np.hypot(own[1], np.sqrt(excess)), own[2]])
    notes.append(
        f"{sweep.name}: up and down differ by {100 * np.sqrt(2 * excess):.2g} % where both lie on one branch, more "
        "than neighbouring points scatter; that counts as noise."
    )
    method = f"{sweep.noise.method}; and {100 * np.sqrt(excess):.2g} % by which up and down differ"
    return replace(sweep, relative_noise=total, own_noise=own, noise=replace(sweep.noise, method=method))


def _excess(sweep: Sweep, run: Run, other: Sweep, back: Run) -> float | None:
    """Variance of one pass, relative to its amplitude squared, that the scatter leaves open; None with few points."""
    here, there = (rows[np.argsort(s.frequency[rows])] for s, rows in ((sweep, run.rows), (other, back.rows)))
    f, a, deviation = sweep.frequency[here], sweep.amplitude[here], sweep.deviation[here]
    inside = (f >= other.frequency[there][0]) & (f <= other.frequency[there][-1])
    f, a, deviation = f[inside], a[inside], deviation[inside]
    nearest = np.abs(other.frequency[there][:, None] - f).min(0)
    b = np.interp(f, other.frequency[there], other.amplitude[there])
    size = np.maximum(a, b)
    step = float(np.median(np.diff(f))) if len(f) > 1 else 0.0
    kept = ~on_two_branches(a, b) & (nearest < 0.05 * step) & (size > 0)
    if np.sum(kept) < _FEWEST:
        return None
    difference, expected = ((a - b) / size)[kept] ** 2, (2 * deviation**2 / size**2)[kept]
    usual = difference <= np.quantile(difference, _USUAL)
    ratio = float(np.mean(difference[usual]) / np.mean(expected[usual]))
    return float(np.mean(difference[usual])) / 2 * (1 - 1 / ratio) if ratio > CLEAR else 0.0
