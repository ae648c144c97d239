"""What the data alone say of every record, and what the records together can and cannot tell apart."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict
from typing import Any

import numpy as np

from ...campaign.campaign import Campaign
from ...campaign.device import Platform
from ...campaign.drive import drive_frequency
from ...campaign.quality.judge import judge
from ...campaign.record import SAME_LEVEL, Record, Sweep, Trace
from ...units import significant
from .drives import drive_words, only_frequency
from .quantity import Scale, reading_unit, scale, show_in
from .sheet import Column, Mark, Sheet, file_words
from .sweeps import sweep_dict, sweep_remarks, sweep_words, what_the_sweeps_tell

_SAME_FREQUENCY = 1.01  # a third of the half-width of a resonance of quality 15: nearer ones tell it no better

_NOTHING_HELD_OUT = (
    "Nothing is held out, so nothing will show whether a model predicts: set holdout = true on a record taken under "
    "other conditions."
)


_DECAYS = (
    "All fitted records are free decays. Each passes through every amplitude below its first, so that stiffness and "
    "damping which change with amplitude can be told; in decays from one amplitude a drift with time looks like them: "
    "let go from others too. Of the drive, its gain and its hysteresis, they say nothing."
)


def what_the_records_tell(campaign: Campaign) -> tuple[str, ...]:
    """What the records together can and cannot tell apart, from how they were driven."""
    traces, fitted = campaign.traces, campaign.fitted
    found = list(what_the_sweeps_tell(campaign))
    if not traces:
        return (*found, *([_NOTHING_HELD_OUT] if not any(sweep.holdout for sweep in campaign.sweeps) else []))
    driven = [record for record in fitted if record.driven]
    drives = [_level(r) for r in driven]
    if fitted and not driven:
        found.append(_DECAYS)
    if driven and max(drives) <= SAME_LEVEL * min(drives) and len(driven) == len(fitted):
        found.append(
            "All fitted records have one drive level: what grows with amplitude (cubic stiffness, quadratic "
            "damping, saturation) can be absorbed by the linear part. A record at half the level separates them."
        )
    if one_frequency(fitted) is not None:
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
    if not any(record.holdout for record in campaign.records):
        found.append(_NOTHING_HELD_OUT)
    elif campaign.heldout and not any(_differs(r, fitted) for r in campaign.heldout):
        found.append(
            "Every held-out record repeats the conditions of a fitted one: it tests repeatability, not the model."
        )
    good = "Levels, frequencies and a held-out record differ: the linear part, what grows with amplitude and what has "
    return tuple(found) or (good + "memory can be told apart in principle.",)


def one_frequency(records: Sequence[Trace]) -> float | None:
    """The frequency (Hz) at which all records were driven, if it is one."""
    found = [only_frequency(record) for record in records]
    known = [frequency for frequency in found if frequency]
    return known[0] if known and len(known) == len(found) and max(known) <= _SAME_FREQUENCY * min(known) else None


def _level(record: Trace) -> float:
    return float(np.sqrt(2) * np.std(record.drive)) or 1e-12


def _begins_at(record: Trace) -> float:
    """How large a free motion begins."""
    return float(np.max(np.abs(record.response - np.mean(record.response)))) or 1e-300


def _differs(record: Trace, others: tuple[Trace, ...]) -> bool:
    def far(a: float, b: float, same: float = SAME_LEVEL) -> bool:
        return max(a, b) > same * min(a, b)

    return all(
        record.driven != o.driven
        or far(*((_level(record), _level(o)) if record.driven else (_begins_at(record), _begins_at(o))))
        or far(drive_frequency(record), drive_frequency(o), _SAME_FREQUENCY)
        or record.load != o.load
        for o in others
    )


def judgement_sheet(campaign: Campaign) -> Sheet:
    """All records in one table: how long each is, and its size beside its noise floor."""
    unit = reading_unit(campaign.records)
    common = scale(max(record.noise.sigma for record in campaign.records), unit, campaign.device)
    rows = tuple(_row(record, common, campaign) for record in campaign.records)
    marks: tuple[Mark, ...] = tuple("" if row[-1] == "good" else "warning" for row in rows)
    columns = (
        Column("record", wraps=True), Column("use"), Column("samples", True), Column("kHz", True),
        Column(f"rms ({common.unit})", True), Column(f"noise ({common.unit})", True), Column("judgement"),
    )  # fmt: skip
    coloured = any(record.noise.ar for record in campaign.records)
    note = "* coloured noise: neighbouring samples share part of it; error bars take that into account."
    return Sheet("Records", columns, rows, marks, note if coloured else "")


def _row(record: Record, common: Scale, campaign: Campaign) -> tuple[str, ...]:
    use = "held out" if record.holdout else "fitted"
    if isinstance(record, Sweep):
        size, n, rate = float(np.sqrt(np.mean(record.amplitude**2))), len(record.frequency), "–"
    else:
        size, n, rate = float(np.std(record.response)), len(record.time), significant(1e-3 / record.step, 3)
    noise = show_in(record.noise.sigma, None, common, 3).value + ("*" if record.noise.ar else "")
    verdict = "see below" if remarks(record, campaign) else "good"
    return (file_words(record.name), use, str(n), rate, show_in(size, None, common, 3).value, noise, verdict)


def about(record: Record, campaign: Campaign) -> str:
    """How a record was driven and how its noise floor was found, in one line."""
    drive = sweep_words(record) if isinstance(record, Sweep) else drive_words(record, campaign.device)
    more = ""
    if isinstance(record, Sweep) and record.overtones:
        sizes = [float(np.median(one.noise)) for one in record.overtones]
        unit = scale(max(sizes), "m", campaign.device)
        pairs = zip(record.overtones, sizes, strict=True)
        told = [f"{show_in(size, None, unit, 2).value} {unit.unit} of harmonic {one.order}" for one, size in pairs]
        more = f", {' and '.join(told)}"
    return f"{file_words(record.name)}: {drive}. Noise floor: {record.noise.method}{more}."


def remarks(record: Record, campaign: Campaign) -> tuple[str, ...]:
    """What is unusual about a record, in words."""
    if isinstance(record, Sweep):
        return sweep_remarks(record, campaign)
    found = judge(record)
    clipped = (f"{found.clipped:.1%} of the response sticks to a limit",) if found.clipped > 0 else ()
    return (*clipped, *found.remarks)


def judgement_dict(campaign: Campaign) -> dict[str, Any]:
    """What is said of the records of a campaign, as plain numbers (SI) and words."""
    return {
        "format": 1,
        "title": campaign.title,
        "records": [_as_dict(record, campaign) for record in campaign.records],
        "notes": list(campaign.notes),
        "tells_apart": list(what_the_records_tell(campaign)),
    }


def _as_dict(record: Record, campaign: Campaign) -> dict[str, Any]:
    common = {"file": record.name, "holdout": record.holdout, "noise": asdict(record.noise)}
    if isinstance(record, Sweep):
        return {**common, "kind": "sweep", **sweep_dict(record)}
    judged = asdict(judge(record))
    own = {key: value for key, value in judged.items() if key not in ("name", "noise")}
    return {**common, "kind": "trace", "drive": drive_words(record, campaign.device), **own}
