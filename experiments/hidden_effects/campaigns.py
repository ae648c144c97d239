"""A simulated case as the campaign that the tool would read from its files, noise floors estimated from the data."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace

import numpy as np

from ident.campaign.campaign import Campaign
from ident.campaign.device import Oscillator, Platform
from ident.campaign.noise.floor import noise_floor
from ident.campaign.noise.pool import pooled
from ident.campaign.period import find_period
from ident.campaign.record import Channel, Trace

from .generator import Case, Made, draw

STEADY = 8000  # samples of a record of which only the end is kept
KEPT = 1600
NEAR_RESONANCE = 2  # which of the sines is the one that a poor campaign has


def campaign_of(case: Case) -> Campaign:
    """What `ident.campaign.read_campaign` would make of the case; the truth stays behind."""
    platform = case.device.kind == "platform"
    found = [_trace(made, "m" if platform else "V") for made in case.records]
    floors = pooled([trace.noise for trace in found], [len(trace.time) for trace in found])
    records = tuple(replace(trace, noise=floor) for trace, floor in zip(found, floors, strict=True))
    return Campaign("something hidden", records, Platform() if platform else Oscillator())


def poor_case(seed: int, effects: tuple[str, ...], size: float, noise: float) -> Case:
    """A case with a single record, of a motion that has become steady: it leaves many effects alike."""
    case = draw(seed, effects, size=size, noise=noise, length=STEADY)
    return replace(case, records=[_end_of(case.records[NEAR_RESONANCE])])


def sigma_ratios(case: Case, campaign: Campaign) -> list[float]:
    """Estimated over true standard deviation of the noise, record by record."""
    return [r.noise.sigma / made.sigma for r, made in zip(campaign.traces, case.records, strict=True)]


def _trace(made: Made, unit: str) -> Trace:
    period = find_period(made.drive)
    floor = noise_floor(made.time, made.drive, made.response, period)
    volts, response = Channel("V", 1.0), Channel(unit, 1.0)
    return Trace(f"{made.name}.csv", made.time, made.drive, made.response, volts, response, floor,
                 start=made.start, holdout=made.holdout, period=period, measures=made.measures)  # fmt: skip


def _end_of(made: Made) -> Made:
    time, drive, response, clean = (x[-KEPT:] for x in (made.time, made.drive, made.response, made.clean))
    return replace(made, time=time - time[0], drive=drive, response=response, clean=clean, start="unknown")


def rounded(values: Iterable[float]) -> list[float]:
    """Four digits are enough for a table, and keep the results readable."""
    return [float(f"{value:.4g}") for value in np.asarray(list(values), float)]
