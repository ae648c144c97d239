"""Which sweeps went faster than the motion settles, as far as the curves themselves tell.

A motion settles in τ = Q/(π f), and its curve is W = 1/(π τ) wide at half power. Held at a frequency for a time t it
has not made e^(−t/τ) of the last step by then; of a frequency that glides at a rate r the response is off by 2π r τ² of
the peak. A curve that was run fast is wider than W, never narrower, and a bent one is, too: the narrowest one says how
long τ is at the least. Where what is missing so far is more than a share of the noise, the sweep is simulated as it was
run (`ident.response.passage`); else every point had settled.

Source: D. J. Ewins, Modal Testing, 2000, §3.7.2 (the fastest sweep); the second is the next term of the response to a
chirp, H(ω) − ½ i ω̇ H″(ω), at the peak.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from ..record import Record, Run, Sweep
from .judge import judge_sweep

_SHARE = 0.1  # of the noise at the peak: so much a point may be off for what it had not settled
_MOST = 30_000  # periods of all passes together, which take a second or two each time that a fit looks at them


def with_speeds(records: Sequence[Record], notes: list[str]) -> list[Record]:
    """The records, those sweeps `fast` that have to be simulated as they were run."""
    told = [record for record in records if isinstance(record, Sweep) and record.dwell is not None]
    settles = _settles(told)
    if settles is None:
        return list(records)
    late = {id(sweep): off for sweep in told if (off := lag(sweep, settles)) > _SHARE * _noise(sweep)}
    fast = [sweep for sweep in told if id(sweep) in late]
    shaped = [sweep for sweep in fast if sweep.quantity != "fundamental"]
    periods = sum(periods_of(sweep) for sweep in fast if sweep.quantity == "fundamental")
    where = ", ".join(dict.fromkeys(sweep.name for sweep in fast))
    if shaped:
        notes.append(
            f"{shaped[0].name}: swept faster than the motion settles, which is simulated for the quantity "
            '"fundamental" only; its half peak-to-peak values are taken as settled.'
        )
    if periods > _MOST:
        notes.append(
            f"{where}: points had not settled by up to {100 * max(late.values()):.2g} % of the peak, but {periods:.3g} "
            f"periods are too many to be simulated (at most {_MOST}); they are taken as settled. Leave out levels, or "
            "points far from the resonance."
        )
        return list(records)
    for sweep in fast:
        if sweep not in shaped:
            notes.append(_words(sweep, late[id(sweep)]))
            if sweep.overtones:
                notes.append(f"{sweep.name}: harmonics of a sweep that was run fast are not fitted.")
    return [
        replace(record, fast=True) if isinstance(record, Sweep) and id(record) in late and record not in shaped
        else record for record in records
    ]  # fmt: skip


def _words(sweep: Sweep, off: float) -> str:
    assert sweep.dwell is not None  # it is told
    turns = sweep.turns_read(float(np.median(sweep.frequency)))
    read = (
        f"the mean over {sweep.averaging:.3g} s before it, {turns} periods"
        if sweep.averaging
        else 'the mean over the last period (averaging = "20 ms" would tell how long the instrument averaged)'
    )
    how = "the frequency glides" if sweep.swept else "each frequency is held for a short time"
    return (
        f"{sweep.name}: {how}, and a settled motion would differ by up to {100 * off:.2g} % of the peak; it is "
        f"simulated as it was run. A point is taken for what a lock-in reads: {read}, of the response times the phase "
        "of the drive."
    )


def lag(sweep: Sweep, settles: float) -> float:
    """By what part of the peak points are off, at most, that were taken as settled; `settles`: τ, s."""
    return max((_lag(sweep, run, settles) for run in sweep.runs), default=0.0)


def _lag(sweep: Sweep, run: Run, settles: float) -> float:
    assert sweep.dwell is not None  # it is told
    times, steps = sweep.dwell[run.rows][1:], np.abs(np.diff(sweep.frequency[run.rows]))
    if sweep.swept:
        rates = steps / np.maximum(times, 1e-300)
        return min(float(np.median(rates)) * 2 * np.pi * settles**2, 1.0)
    return float(np.max(np.exp(-times / settles) * np.minimum(2 * np.pi * settles * steps, 1.0), initial=0.0))


def periods_of(sweep: Sweep) -> int:
    """Periods of the drive in all passes."""
    assert sweep.dwell is not None
    return int(sum(float(np.sum(sweep.dwell[run.rows] * sweep.frequency[run.rows])) for run in sweep.runs))


def _settles(sweeps: Sequence[Sweep]) -> float | None:
    """The time in which the motion settles, s, by the narrowest of the curves; None where none comes down on both
    sides of its peak."""
    widths = [run.width for sweep in sweeps for run in judge_sweep(sweep).runs if run.width]
    return 1.0 / (np.pi * min(widths)) if widths else None


def _noise(sweep: Sweep) -> float:
    """Relative noise of the largest amplitude."""
    top = int(np.argmax(sweep.amplitude))
    return float(sweep.deviation[top] / sweep.amplitude[top])
