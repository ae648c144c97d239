"""What can be said of an amplitude-frequency curve before any model: its levels, its points, its jumps, its phase."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from ..record import Run, Sweep
from .jump import Jump, jump_of

FEWEST = 4.0
"""Points within a half-power width. With four, the width is read to 7 % whatever their position on a Lorentzian peak
(tests/campaign/test_judge_sweep.py), with two to 25 %."""
_SHIFT = math.radians(25)
"""Phase at frequencies far from resonance that neither 0 nor 180° explains: a delay, or a wrong reference."""


@dataclass(frozen=True)
class RunJudgement:
    """One pass: level (V), direction, points; the peak (Hz, m); points within its half-power width, its width (Hz; None
    if the curve does not come down on both sides); its jump."""

    level: float
    up: bool
    points: int
    peak_frequency: float
    peak: float
    within: int
    width: float | None
    jump: Jump | None


@dataclass(frozen=True)
class SweepJudgement:
    """One curve, judged alone (SI units); `both_ways`: whether each level was swept up and down; `remarks` in words."""

    name: str
    runs: tuple[RunJudgement, ...]
    phase: bool
    both_ways: bool
    remarks: tuple[str, ...]


def judge_sweep(record: Sweep, beside: Sequence[Sweep] = ()) -> SweepJudgement:
    """Judges a sweep by its data alone; `beside`: further sweeps of the campaign, which may have gone the other way."""
    runs = tuple(_run(record, run) for run in record.runs)
    others = [run for sweep in beside if sweep.load == record.load for run in sweep.runs]
    levels = sorted({run.level for run in runs})
    both = {run.level for run in record.runs if any(o.is_back_of(run) for o in [*record.runs, *others])}
    return SweepJudgement(
        record.name, runs, record.phase is not None, len(both) == len(levels), tuple(_remarks(record, runs, both))
    )


def _run(record: Sweep, run: Run) -> RunJudgement:
    rows = run.rows[np.argsort(record.frequency[run.rows], kind="stable")]
    f, a = record.frequency[rows], record.amplitude[rows]
    top = int(np.argmax(a))
    high = a >= a[top] / math.sqrt(2.0)
    low, end = top, top
    while low > 0 and high[low - 1]:
        low -= 1
    while end < len(a) - 1 and high[end + 1]:
        end += 1
    whole = low > 0 and end < len(a) - 1
    jump = jump_of(record, rows)
    width = _crossing(f, a, end, end + 1, a[top]) - _crossing(f, a, low, low - 1, a[top]) if whole else None
    return RunJudgement(run.level, run.up, len(rows), float(f[top]), float(a[top]), end - low + 1, width, jump)


def _crossing(f: np.ndarray, a: np.ndarray, inside: int, outside: int, peak: float) -> float:
    """Where the amplitude passes the half-power level between two points, Hz."""
    target = peak / math.sqrt(2.0)
    share = (a[inside] - target) / max(a[inside] - a[outside], 1e-300)
    return float(f[inside] + min(max(share, 0.0), 1.0) * (f[outside] - f[inside]))


def _remarks(record: Sweep, runs: tuple[RunJudgement, ...], both: set[float]) -> list[str]:
    factor, unit = record.drive_channel.factor, record.drive_channel.unit
    found = []

    def volts(level: float) -> str:
        return f"{level / factor:.4g} {unit}"

    cut = [run for run in runs if run.width is None]
    if cut:
        found.append(f"{_at(cut, volts)}: the curve does not come down on both sides of its peak: sweep further")
    thin = [run for run in runs if run.width is not None and run.within < FEWEST and run.jump is None]
    if thin:
        width = min(run.width for run in thin if run.width is not None)
        found.append(
            f"{_at(thin, volts)}: {min(run.within for run in thin)} points within the half-power width; the resonance "
            f"and its damping are read better with one every {width / FEWEST:.2g} Hz"
        )
    for run in runs:
        if run.jump is not None and run.level not in both:
            way = "up" if run.up else "down"
            found.append(
                f"{volts(run.level)}: a jump at {run.jump.frequency:.6g} ± {run.jump.uncertainty:.2g} Hz, and swept "
                f"{way} only: the direction decides on which branch its points lie; is it right? Sweep back too"
            )
    if record.noise.relative_error > 0.25:
        found.append("the noise floor is uncertain: give it in the campaign if it is known")
    faint = [run for run in runs if run.peak < 10 * record.noise.sigma]
    if faint:
        found.append(f"{_at(faint, volts)}: the peak hardly stands out of the noise")
    if (shift := _phase_shift(record)) is not None:
        found.append(
            f"the phase is {math.degrees(shift):.0f}° where the response should follow the drive: a delay, or another "
            "reference? A lag in drive or sensor would be found"
        )
    return found


def _at(runs: list[RunJudgement], volts: Callable[[float], str]) -> str:
    return ", ".join(dict.fromkeys(volts(run.level) for run in runs))


def _phase_shift(record: Sweep) -> float | None:
    """The phase at the lowest frequencies if it is near neither 0 nor 180°, and they are far below resonance."""
    if record.phase is None:
        return None
    shifts = []
    for run in record.runs:
        first = run.rows[int(np.argmin(record.frequency[run.rows]))]
        top = run.rows[int(np.argmax(record.amplitude[run.rows]))]
        if record.amplitude[first] < 0.2 * record.amplitude[top] and record.frequency[first] < record.frequency[top]:
            shifts.append(record.phase[first])
    if not shifts:
        return None
    mean = float(np.angle(np.mean(np.exp(2j * np.array(shifts))))) / 2  # 0 and 180° are alike
    return mean if abs(mean) > _SHIFT else None
