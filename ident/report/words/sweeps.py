"""Amplitude-frequency curves in words: how they were taken, what is unusual, and what they can and cannot tell."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict
from typing import Any

import numpy as np

from ...campaign.campaign import Campaign
from ...campaign.record import SAME_LEVEL, Sweep
from ...campaign.sweeps.dynamic_stiffness import LawCurve, dynamic_stiffness
from ...campaign.sweeps.judge import RunJudgement, judge_sweep
from ...units import significant
from ..figures.style import shortened
from .quantity import scale, show_in
from .sheet import Column, Sheet

_NARROW = 2.0
"""Ratio of the strongest to the weakest level below which laws are hard to tell: a² and a³ differ by it only."""
_APART = 1.5  # noise floors from the common curve beyond which the levels do not fall on it
_BENT = 5.0  # noise floors by which a curve bends, to be called bent


def sweep_words(record: Sweep) -> str:
    """How a sweep was taken, in a phrase."""
    low, high = (f"{float(f(record.frequency)):.6g}" for f in (np.min, np.max))  # a band may be narrow
    runs = record.runs
    levels = {run.level for run in runs}
    volts = record.drive_channel
    drive = (
        f"{len(levels)} drive levels"
        if len(levels) > 1
        else f"{significant(runs[0].level / volts.factor, 3)} {volts.unit}"
    )
    ways = {run.up for run in runs}
    way = "up and down" if len(ways) == 2 else "up" if True in ways else "down"
    dwell = "" if record.dwell is None else f", {significant(float(np.median(record.dwell)), 2)} s a point"
    dwell += ", simulated as it was run" if record.fast else ""
    phase = "with phase" if record.phase is not None else "without phase"
    if record.overtones:
        phase += f", with {'harmonics' if len(record.overtones) > 1 else 'harmonic'} "
        phase += " and ".join(str(one.order) for one in record.overtones)
    return f"sweep {low} to {high} Hz, {drive}, {way}, {phase}{dwell}"


def sweep_remarks(record: Sweep, campaign: Campaign) -> tuple[str, ...]:
    """What is unusual about a sweep, in words."""
    return judge_sweep(record, campaign.sweeps).remarks


def run_sheet(campaign: Campaign) -> Sheet:
    """Every pass of every sweep: its peak, how many points it has there, its jump."""
    runs = [(record, run) for record in campaign.sweeps for run in judge_sweep(record).runs]
    unit = scale(max(run.peak for _, run in runs), "m", campaign.device)
    volts = campaign.sweeps[0].drive_channel
    columns = (
        Column("record"), Column(f"drive ({volts.unit})", True), Column("way"), Column("n", True),
        Column("peak (Hz)", True), Column(f"peak ({unit.unit})", True), Column("at peak", True),
        Column("jump (Hz)", True),
    )  # fmt: skip
    rows = tuple(
        (
            shortened(record.name, 24), significant(run.level / volts.factor, 3), "up" if run.up else "down",
            str(run.points),
            f"{run.peak_frequency:.6g}", show_in(run.peak, None, unit, 3).value, str(run.within), _jump(run),
        )
        for record, run in runs
    )  # fmt: skip
    note = "n: points of the pass; at peak: those within the half-power width."
    return Sheet("Curves", columns, rows, note=note)


def _jump(run: RunJudgement) -> str:
    return "–" if run.jump is None else f"{run.jump.frequency:.6g} ± {run.jump.uncertainty:.2g}"


def what_the_sweeps_tell(campaign: Campaign) -> tuple[str, ...]:
    """What the fitted sweeps can and cannot tell apart, from how they were taken."""
    sweeps = [record for record in campaign.sweeps if not record.holdout]
    if not sweeps:
        return ()
    levels = sorted({run.level for sweep in sweeps for run in sweep.runs})
    found = []
    if not all(sweep.phase is not None for sweep in sweeps):
        which = "All sweeps" if not any(sweep.phase is not None for sweep in sweeps) else "Some sweeps"
        found.append(
            f"{which} have amplitudes alone: most laws of damping, a lag, a feed-through and a second mode then look "
            "like one another or like the linear part. Recording the phase separates them."
        )
    if levels[-1] <= SAME_LEVEL * levels[0]:
        found.append(
            "All sweeps have one drive level: what grows with amplitude (stiffness, damping, saturation) can be "
            "absorbed by the linear part. A sweep at half the level separates them."
        )
    elif levels[-1] < _NARROW * levels[0]:
        found.append(
            f"The drive levels span a factor of {levels[-1] / levels[0]:.2g}: laws that differ in their power of the "
            "amplitude hardly separate. Three levels over a factor of three do."
        )
    if not all(judge_sweep(sweep, campaign.sweeps).both_ways for sweep in sweeps):
        found.append(
            "Not every level was swept both ways: between the two jumps only one of two possible motions was seen."
        )
    held = (
        "Curves hold the {} of settled motion: constant forces and offsets, drifts and a force by the square of the "
        "drive do not "
    )
    if any(one.order == 2 for sweep in sweeps for one in sweep.overtones):
        found.append(
            f"{held.format('fundamental and harmonics')}show in them; an even force shows by its second harmonic."
        )
    else:
        more = "." if campaign.traces else "; a trace, or the second harmonic (a column A2), would tell."
        softens = "a quadratic stiffness only softens, as a negative cubic one would"
        found.append(f"{held.format('fundamental')}show in them, and {softens}{more}")
    return (*found, *fit_free_words(sweeps))


def fit_free_words(sweeps: Sequence[Sweep]) -> tuple[str, ...]:
    """What the dynamic stiffness of the measured points shows before any fit; nothing without phase."""
    seen = dynamic_stiffness(sweeps)
    if seen is None:
        return ()
    return (
        _law_words(seen.stiffness, "natural frequency", "amplitude", "Hz", 5),
        _law_words(seen.damping, "damping rate", "velocity", "1/s", 3),
    )


def _mean(curve: LawCurve, part: np.ndarray) -> tuple[float, float]:
    """The weighted mean of some points, and its error with the misfit of the common curve."""
    weights = curve.deviation[part] ** -2.0
    error = max(curve.misfit, 1.0) * float(np.sum(weights) ** -0.5)
    return float(weights @ curve.value[part] / np.sum(weights)), error


def _course(curve: LawCurve) -> list[float]:
    """Where the law goes from weak to strong amplitudes: from the mean of the weakest third to the value at the
    strongest, over a turning point if there is one; a single value if it does not change."""
    weak, weak_error = _mean(curve, curve.amplitude < np.quantile(curve.amplitude, 1 / 3))
    strong, strong_error = _mean(curve, curve.amplitude > np.quantile(curve.amplitude, 2 / 3))
    last = float(curve.curve[-1])
    beyond = np.maximum(np.minimum(weak, last) - curve.curve, curve.curve - np.maximum(weak, last))
    # Among the weakest, whose mean it would be compared with, the law has not turned.
    k = int(np.argmax(np.where(curve.at < np.quantile(curve.amplitude, 1 / 3), 0.0, beyond)))
    near = np.abs(curve.amplitude - curve.at[k]) < (curve.at[-1] - curve.at[0]) / 20
    if beyond[k] > 0 and np.count_nonzero(near) > 1:
        there, error = _mean(curve, near)
        out = min(abs(there - weak), abs(there - last)) if (there - weak) * (there - last) > 0 else 0.0
        if out > _BENT * float(np.hypot(error, max(weak_error, strong_error))):
            return [weak, there, last]
    bent = abs(strong - weak) > _BENT * float(np.hypot(weak_error, strong_error))
    return [weak, last] if bent else [float(np.median(curve.curve))]


def _apart(curve: LawCurve) -> str:
    if curve.misfit <= _APART:
        return "all levels fall on one curve"
    return (
        f"the levels do not fall on one curve ({curve.misfit:.2g} noise floors): something depends on the drive, on "
        "the frequency or on the past"
    )


def _law_words(curve: LawCurve, what: str, coordinate: str, unit: str, digits: int) -> str:
    first, *others = _course(curve)
    if others:
        ways = ["rises" if b > a else "falls" for a, b in zip([first, *others], others, strict=False)]
        law = f"{ways[0]} with the {coordinate}, from {first:.{digits}g} to {others[0]:.{digits}g} {unit}"
        law += f", and {ways[1]} to {others[1]:.{digits}g} {unit}" if others[1:] else ""
    else:
        law = f"does not change with the {coordinate}, {first:.{digits}g} {unit}"
    return f"Before any fit, the {what} {law}; {_apart(curve)}."


def sweep_dict(record: Sweep) -> dict[str, Any]:
    """The judgement of a sweep as plain numbers (SI) and words."""
    judged = asdict(judge_sweep(record))
    own = {key: value for key, value in judged.items() if key != "name"}
    noise = {"relative_noise": record.relative_noise, "phase_noise": record.phase_noise}
    noise |= {"harmonics": [{"order": one.order, "noise": float(np.median(one.noise))} for one in record.overtones]}
    how = {"drive": sweep_words(record), "simulated_in_time": record.fast}
    return {**how, "samples": len(record.frequency), **noise, **own}
