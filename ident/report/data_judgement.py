"""What the data alone say of every record, and what the records together can and cannot tell apart."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from ..campaign.campaign import Campaign
from ..campaign.checks import clipped_fraction
from ..campaign.device import Platform
from ..campaign.drive import drive_frequency
from ..campaign.record import Record, Sweep, Trace
from .drive_words import drive_sine, drive_words
from .quantity import scale, show_in, significant
from .sheet import Column, Mark, Sheet

_PURE = 0.99  # share of a drive's variance in its fundamental above which it is a clean sine
_CLIPPED = 1e-3
_SAME = 1.05  # ratio of two levels, frequencies or loads up to which they count as one


class Judgement(NamedTuple):
    """What a record is worth.

    **Arguments:**

    - `name`, `use` ("fitted" or "held out"), `n` samples, `rate` (Hz; of a sweep 0), `drive` in words.
    - `purity`: share of the drive's variance in its fundamental; None if the drive is not periodic.
    - `peak`: largest displacement from the mean, `noise`: the noise floor (SI), found by `method`, known to `noise_error`
      (relative); `coloured`: whether neighbouring samples share noise.
    - `clipped`: share of the response that sticks to a limit; `drift`: change of the mean over the record, SI.
    - `remarks`: what is unusual, in words.
    """

    name: str
    use: str
    n: int
    rate: float
    drive: str
    purity: float | None
    peak: float
    noise: float
    noise_error: float
    method: str
    coloured: bool
    clipped: float
    drift: float
    remarks: tuple[str, ...]


def judge(record: Record, campaign: Campaign) -> Judgement:
    """Judge one record by its own numbers."""
    use = "held out" if record.holdout else "fitted"
    noise = record.noise
    if isinstance(record, Sweep):
        levels = len(np.unique(np.round(record.level, 6)))
        words = f"sweep {neat_range(record.frequency)} Hz, {levels} drive level{'s' if levels > 1 else ''}"
        peak = float(np.max(record.amplitude))
        return Judgement(record.name, use, len(record.frequency), 0.0, words, None, peak, noise.sigma,
                         noise.relative_error, noise.method, bool(noise.ar), 0.0, 0.0, ())  # fmt: skip
    sine = drive_sine(record)
    peak = float(np.max(np.abs(record.response - np.mean(record.response))))
    clipped, drift = clipped_fraction(record.response), _drift(record)
    remarks = []
    if clipped > _CLIPPED:
        remarks.append(f"{clipped:.1%} of the response sticks to a limit")
    if drift:
        share = abs(drift) / noise.sigma
        remarks.append(f"the mean drifts by {significant(share, 2)} noise floors")
    if sine is not None and sine.share < _PURE:
        remarks.append(f"only {sine.share:.1%} of the drive is its fundamental")
    if peak < 10 * noise.sigma:
        remarks.append(f"the response is only {significant(peak / noise.sigma, 2)} noise floors")
    if noise.relative_error > 0.2:
        remarks.append(f'the noise floor is known to {noise.relative_error:.0%} only; noise = "…" would settle it')
    return Judgement(record.name, use, len(record.time), 1.0 / record.step, drive_words(record, campaign.device),
                     None if sine is None else sine.share, peak, noise.sigma, noise.relative_error, noise.method,
                     bool(noise.ar), clipped, drift, tuple(remarks))  # fmt: skip


def neat_range(values: np.ndarray) -> str:
    """ "400 to 560"."""
    return f"{significant(float(np.min(values)), 3)} to {significant(float(np.max(values)), 3)}"


def _drift(record: Trace) -> float:
    """Change of the period's mean over the record, SI; 0 where it is not significant.

    A transient moves the mean too, but ever less: a drift goes on in the last third as it went in the middle.
    """
    period = record.period
    if period is None or len(record.response) < 12 * period:
        return 0.0
    count = int(len(record.response) // period)
    edges = np.round(len(record.response) - period * np.arange(count, -1, -1)).astype(int)
    means = np.array([record.response[a:b].mean() for a, b in zip(edges[:-1], edges[1:], strict=True)])
    third = count // 3
    middle, last = _trend(means[third : 2 * third]), _trend(means[2 * third :])
    lasting = middle[0] * last[0] > 0 and 0.6 < abs(last[0]) / max(abs(middle[0]), 1e-300) < 1.7
    change = last[0] * count
    certain = abs(last[0]) > 4 * last[1] and abs(change) > record.noise.sigma
    return float(change) if lasting and certain else 0.0


def _trend(means: np.ndarray) -> tuple[float, float]:
    """Slope per period of a straight line, and its standard error."""
    at = np.arange(len(means)) - (len(means) - 1) / 2
    slope = float(at @ means / (at @ at))
    rest = means - means.mean() - slope * at
    return slope, float(np.sqrt(rest @ rest / max(len(means) - 2, 1) / (at @ at)))


def what_the_records_tell(campaign: Campaign) -> tuple[str, ...]:
    """What the records together can and cannot tell apart, from how they were driven."""
    traces, fitted = campaign.traces, campaign.fitted
    if not traces:
        return ("There are sweeps only; without a trace, memory and the shape of the motion remain unseen.",)
    found = []
    drives = [_level(r) for r in fitted]
    if fitted and max(drives) <= _SAME * min(drives):
        found.append(
            "All fitted records have one drive level: what grows with amplitude (cubic stiffness, quadratic "
            "damping, saturation) can be absorbed by the linear part. A record at half the level separates them."
        )
    frequencies = [drive_frequency(r) for r in fitted if drive_sine(r) is not None and drive_frequency(r) > 0]
    if fitted and len(frequencies) == len(fitted) and max(frequencies) <= _SAME * min(frequencies):
        starts = {r.start for r in fitted}
        how = "only the transients tell the resonance" if starts != {"steady"} else "nothing tells the resonance"
        found.append(
            f"All fitted records have one drive frequency: {how}, and effects with memory cannot be told from "
            "one another. A record at another frequency separates them."
        )
    if isinstance(campaign.device, Platform) and len({round(r.load, 9) for r in traces}) == 1:
        found.append(
            "All records have one load: forces are known only relative to the mass of the stage in the device "
            "description. A record with a known extra mass fixes them."
        )
    if not campaign.heldout:
        found.append(
            "Nothing is held out, so nothing will show whether a model predicts: set holdout = true on a record "
            "taken under other conditions."
        )
    elif not any(_differs(r, fitted) for r in campaign.heldout):
        found.append(
            "Every held-out record repeats the conditions of a fitted one: it tests repeatability, not the model."
        )
    return tuple(found) or ("Levels, frequencies and a held-out record differ: the linear part, what grows with amplitude "
                            "and what has memory can be told apart in principle.",)  # fmt: skip


def _level(record: Trace) -> float:
    return float(np.sqrt(2) * np.std(record.drive)) or 1e-12


def _differs(record: Trace, others: tuple[Trace, ...]) -> bool:
    def far(a: float, b: float) -> bool:
        return max(a, b) > _SAME * min(a, b)

    return all(
        far(_level(record), _level(o)) or far(drive_frequency(record), drive_frequency(o)) or record.load != o.load
        for o in others
    )


def judgement_sheet(campaign: Campaign) -> Sheet:
    """All records in one table."""
    judged = [judge(record, campaign) for record in campaign.records]
    common = scale(max(j.noise for j in judged), "m", campaign.device)
    rows = tuple(
        (j.name, j.use, j.drive, str(j.n), significant(j.rate / 1e3, 3) if j.rate else "–",
         show_in(j.peak, None, common, 3).value, show_in(j.noise, None, common, 3).value + ("*" if j.coloured else ""),
         "; ".join(j.remarks) or "good")
        for j in judged
    )  # fmt: skip
    marks: tuple[Mark, ...] = tuple("warning" if j.remarks else "" for j in judged)
    columns = (
        Column("record", wraps=True), Column("use"), Column("drive", wraps=True), Column("n", True), Column("kHz", True),
        Column(f"peak ({common.unit})", True), Column(f"noise ({common.unit})", True), Column("judgement", wraps=True),
    )  # fmt: skip
    coloured = any(j.coloured for j in judged)
    note = (
        "* coloured noise: neighbouring samples share part of it; error bars take that into account."
        if coloured
        else ""
    )
    return Sheet("Records", columns, rows, marks, note)


def judgement_dict(campaign: Campaign) -> dict[str, Any]:
    """The same as plain numbers (SI) and words."""
    return {
        "format": 1,
        "title": campaign.title,
        "records": [judge(record, campaign)._asdict() for record in campaign.records],
        "notes": list(campaign.notes),
        "tells_apart": list(what_the_records_tell(campaign)),
    }
