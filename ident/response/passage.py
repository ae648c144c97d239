"""A sweep as it was run in time: its drive, and what the instrument reads off the motion.

    V = U cos φ(t),   φ̇ = 2π f(t),   Y = 1/(πN) ∫ z e^{−iφ} dφ over the last N turns of the drive

The frequency glides from point to point at an even rate, or steps to the next one and is held; the phase of the drive
goes on without a break. A point is read when the frequency reaches it, or at the end of its dwell, as a lock-in reads
it that averages over as many whole turns as fit into its averaging time, one at the least. Before its first point the
motion has settled.

In which phase of the drive a pass began, no table tells, and where the motion changes within a period (at a jump that
is passed fast) a reading depends on it, by e^{2iφ₀}. Each pass is therefore run from two phases a right angle apart:
their mean is the reading, and what they differ by is what nobody knows.

Source: lock-in detection as of P. Horowitz, W. Hill, The Art of Electronics, 2015, §8.14, with a rectangular window;
P. J. Davis, P. Rabinowitz, Methods of Numerical Integration, 1984, §2.8 (Gregory's sum).
"""

from __future__ import annotations

import itertools
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ..campaign.record import Run, Sweep
from .lane import Lane
from .tape import BLOCK, Span, Tape, lay

_BEGUN = (0.0, np.pi / 2)  # phases of the drive in which a pass begins
_ENDS = np.array([3 / 8, 7 / 6, 23 / 24])  # weights of a sum over equal steps at its ends, for an error of h⁴
_CUBIC = np.linalg.inv(np.vander(np.arange(4.0), increasing=True))  # powers of a cubic through four values


@dataclass(frozen=True, eq=False)
class Passages:
    """All passes of some sweeps on one tape.

    **Arguments:** `runs`: which sweep each pass is of, and its run; the `tape` has all passes from one phase, then all
    from the other; `preludes`: one period of the drive of each before its first point; `rows`, (points,): of which
    point of its sweep each reading is; `index`, `weights`: samples of the tape, and what each adds to its reading;
    `first`: where the samples of each reading begin among them.
    """

    runs: tuple[tuple[int, Run], ...]
    tape: Tape
    preludes: tuple[Tape, ...]
    rows: np.ndarray
    index: np.ndarray
    weights: np.ndarray
    first: np.ndarray

    def read(self, samples: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """(…, points) complex fundamental relative to the drive, of what a sensor shows, (…, samples), and by how much
        it may be off for the phase in which the pass began."""
        both = np.add.reduceat(self.weights * samples[..., self.index], self.first, axis=-1)
        one, other = np.split(both, 2, axis=-1)
        return 0.5 * (one + other), 0.5 * (one - other)

    @cached_property
    def pass_of(self) -> np.ndarray:
        """(points,) of which pass each reading is."""
        return np.repeat(np.arange(len(self.runs)), [len(run.rows) for _, run in self.runs])


def lay_passages(sweeps: tuple[Sweep, ...], steps: int) -> Passages:
    """The passes of sweeps in so many solver steps a period of the highest frequency."""
    runs = tuple((k, run) for k, sweep in enumerate(sweeps) for run in sweep.runs)
    lanes, preludes, index, weights, first, done, taken = [], [], [], [], [], 0, 0
    for begin, (k, run) in itertools.product(_BEGUN, runs):
        sweep = sweeps[k]
        lane, phase, pace, ends = _lane(sweep, run, steps, begin)
        lanes.append(lane)
        preludes.append(_prelude(sweep, run, steps, begin))
        for end, f in zip(ends, sweep.frequency[run.rows], strict=True):
            periods = sweep.turns_read(f)
            begun = float(np.interp(phase[end] - 2 * np.pi * periods, phase, np.arange(len(phase))))
            inside = np.arange(int(begun), end + 1)
            turning = pace[inside] if sweep.swept else 2 * np.pi * f
            first.append(taken)
            index.append(done + inside)
            mixed = np.exp(-1j * phase[inside]) * turning * lane.step / (np.pi * periods)
            weights.append(_sum(len(inside), begun - int(begun)) * mixed)
            taken += len(inside)
        done += len(phase)
    rows = np.concatenate([run.rows for _, run in runs])
    tape = lay(lanes, [1] * len(lanes))
    return Passages(runs, tape, tuple(preludes), rows, np.concatenate(index), np.concatenate(weights), np.array(first))


def _lane(sweep: Sweep, run: Run, steps: int, begun: float) -> tuple[Lane, np.ndarray, np.ndarray, np.ndarray]:
    """The drive of a pass; its phase and how fast that turns, (samples,), at every step; and the step (points,) at
    which each point is read."""
    assert sweep.dwell is not None  # of a fast sweep it is told
    frequency, times = sweep.frequency[run.rows], sweep.dwell[run.rows]
    step = 1.0 / (steps * float(np.max(frequency)))
    longest = sweep.turns_read(frequency[0]) / frequency[0] + step  # before the first point is read
    first = max(longest, 0.0 if sweep.swept else times[0])
    ends = int(np.ceil(first / step)) + np.round(np.append(0.0, np.cumsum(times[1:])) / step).astype(int)
    counts = np.diff(ends, prepend=0)
    half = np.arange(2 * int(ends[-1]) + 1) * (0.5 * step)
    if sweep.swept:
        knots, values = step * np.concatenate([[0], ends]), np.concatenate([frequency[:1], frequency])
        now = np.interp(half, knots, values)
        turned = np.concatenate([[0.0], np.cumsum(0.5 * (now[1:] + now[:-1]))]) * (0.5 * step)  # exact: f is piecewise
    else:  # linear, with its corners on the grid
        held = np.repeat(frequency, 2 * counts)
        turned, now = np.concatenate([[0.0], np.cumsum(held)]) * (0.5 * step), np.append(held, frequency[-1])
    phase, omega = begun + 2 * np.pi * turned, 2 * np.pi * now
    level = float(np.median(sweep.acting[run.rows]))
    blocks = -(-(int(ends[-1]) + 1) // BLOCK)
    # A force that goes by the frequency of the drive, as the polynomial hysteresis, sees that of its block.
    local = omega[np.minimum(BLOCK * (2 * np.arange(blocks) + 1), len(omega) - 1)]
    lane = Lane(step, level * np.cos(phase), -level * omega * np.sin(phase), local, sweep.load, 1.0, sine=1.0)
    return lane, phase[::2], omega[::2], ends


def _prelude(sweep: Sweep, run: Run, steps: int, begun: float) -> Tape:
    """One period of the drive at the first frequency, which ends where the pass begins."""
    frequency, level = float(sweep.frequency[run.rows][0]), float(np.median(sweep.acting[run.rows]))
    blocks = -(-steps // BLOCK)
    angle = begun + np.pi / (BLOCK * blocks) * np.arange(2 * BLOCK * blocks + 1)
    omega = 2 * np.pi * frequency
    voltage, rate = level * np.cos(angle), -level * omega * np.sin(angle)
    lane = Lane(1.0 / (frequency * BLOCK * blocks), voltage, rate, omega, sweep.load, 1.0, sine=1.0)
    return Tape((lane,), (Span(0, blocks, 1, BLOCK * blocks),))


def _sum(count: int, begun: float) -> np.ndarray:
    """Weights (count,) with which values at equal steps add up to their integral over steps from `begun`, between the
    first two, to the last."""
    found = np.ones(count)
    found[:3], found[-3:] = _ENDS, _ENDS[::-1]
    found[:4] -= (begun ** np.arange(1, 5) / np.arange(1, 5)) @ _CUBIC
    return found
