"""A drive that is held: a converter puts out a value until the next one, a switch is open or closed.

Between its samples it jumps, so that a smooth curve through them rings, and is early by half a sampling interval where
the column holds what was commanded. Each jump is drawn as an edge over one step of the solver to either side,

    V̇(t) = J (1 − |t − t_k|/h)/h  for |t − t_k| < h,

the linear B-spline. Its sums over the solver's grid, those of Simpson's rule and those of the trapezium rule, are exact
for the jump and for when it happens, wherever between the points of the grid that is. What is left is as if the drive
had passed a filter 1 − (ωh)²/12.

Source: G. Strang, G. Fix, An Analysis of the Finite Element Method, 1973, ch. 3 (sums of B-splines).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

_ALIKE = 0.5  # correlation of neighbouring changes: that of six samples a period


class Edges(NamedTuple):
    """Where the drives of a campaign have edges between their samples: none, they are smooth curves; or each value is
    held from `first` sampling intervals after its sample on, `everywhere`, as a converter holds it, or only in records
    whose drive jumps, as that of a generator does which is smooth elsewhere."""

    first: float | None = None
    everywhere: bool = True

    def of(self, drive: np.ndarray) -> float | None:
        """The edge of one drive (n,), None if it is smooth (`Trace.edge`)."""
        return self.first if self.first is None or self.everywhere or jumps(drive) else None

    @property
    def numbers(self) -> int:
        """How many it needs: the clock of the samples is none."""
        return int(self.first not in (None, 0.0))


def held_drive(samples: np.ndarray, substeps: int, edge: float) -> tuple[np.ndarray, np.ndarray]:
    """The drive and its derivative per sampling interval on the half-step grid.

    **Arguments:** `samples` (n,); `substeps` of the solver per sample; `edge`: how many sampling intervals after a
    sample its value begins: −1 to 0 where the drive was measured; 0 for a converter on the clock of the samples, and
    later where what was commanded had to be computed first.

    **Returns:** (2 (n−1) `substeps` + 1,) each; before the first edge the drive is that of the first sample.
    """
    n, step = len(samples), 1.0 / substeps
    at = np.arange(2 * (n - 1) * substeps + 1) / (2 * substeps) - edge
    first = np.ceil(at - step).astype(int)  # the first edge that is not over
    voltage, slope = samples[np.clip(first - 1, 0, n - 1)].astype(float), np.zeros(len(at))
    for k in (first, first + 1, first + 2):  # further ones have not begun, in steps of a whole interval either
        jump = np.where((k > 0) & (k < n), samples[np.clip(k, 0, n - 1)] - samples[np.clip(k - 1, 0, n - 1)], 0.0)
        far = np.clip((at - k) / step, -1.0, 1.0)
        voltage += jump * np.where(far < 0, (1 + far) ** 2 / 2, 1 - (1 - far) ** 2 / 2)
        slope += jump * (1 - np.abs(far)) / step
    voltage.flags.writeable = slope.flags.writeable = False
    return voltage, slope


def beside_edge(edge: float, substeps: int, order: int) -> float:
    """What a jump would have made of a reading at the sample beside it, beyond what the edge does as it is drawn, per
    V̇ as drawn there and in steps h of the solver, where the reading is the first integral of the drive (`order` 1, a
    velocity) or the drive itself (2, an acceleration).

    With w = 1 − |t − t_k|/h the drawn ∫V dt is larger by V̇ h² w²/6 at t, and V misses V̇ h w/2 of what it is after the
    jump; at a jump itself a sample belongs to what comes. Every integral over a whole edge is right, and a displacement
    hardly sees it. One sample a step, with edges between them, is beside two: then this is that of the nearer one.
    """
    after = round(edge) - edge  # intervals from the nearest edge to the sample
    near = max(1.0 - abs(after) * substeps, 0.0)
    return (0.0, -(near**2) / 6, near / 2 if after >= 0 else -near / 2)[order]


def jumps(drive: np.ndarray) -> bool:
    """Whether a drive (n,) jumps from sample to sample, so that neighbouring changes tell nothing of one another.

    The changes of a smooth one with P samples a period correlate by cos 2π/P; those of steps, of a square wave and of
    noise not at all.
    """
    change = np.diff(drive)
    power = float(change @ change)
    return power > 0 and float(change[1:] @ change[:-1]) < _ALIKE * power
