"""Long records are ranked and confirmed on excerpts of themselves; the model at the end is fitted to all of them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import lru_cache

import numpy as np

from ...campaign.campaign import Campaign
from ...campaign.record import Trace
from ...fit import Fit, fit
from ...fit.linear.guess import guess_linear
from ...model import linear_part
from ...response import steps_of

CRAWLS = 60
"""Steps of a fit that others are compared with, or that is: one that needs more crawls along a valley and comes no
nearer."""

_MOST = 300_000  # solver steps of all fitted records together, with which a refit takes a minute at most
_STEPS = 120  # of the solver per period of the resonance, as most laws with a kink or a loop take
_KEPT = 9_000  # samples of longer ones: enough to name an effect, few enough to try several
_BEFORE = 0.25  # of a stretch, simulated before it and not counted, to build up memory
_QUIETER = 0.6  # a second stretch must move less than this, so that what grows with the amplitude shows
_BLOCKS = 200  # of a record, to see where it moves
_MOVES = 0.02  # of the liveliest block: below, the device rests
_RESTS = 0.15  # of the samples kept are of the rest before the motion: it says what level the motion starts from


def is_long(campaign: Campaign) -> bool:
    """Whether the fitted records are too long to try several models on all of them.

    What counts is the steps that a law with a kink takes: few samples per period need many between them, and a quiet
    record some more.
    """
    records = [record for record in campaign.fitted if not record.excerpt]
    if sum(len(record.time) for record in records) * _STEPS < _MOST:
        return False
    linear = linear_part(campaign.device)
    resonance = guess_linear(campaign.fitted, linear.nominal_frequency, mass=linear.mass)
    taken = (len(r.time) * steps_of(r, resonance.frequency, resonance.quality, _STEPS) for r in records)
    return sum(taken) > _MOST


@lru_cache(maxsize=8)  # the walk comes back to a fit
def working(fitted: Fit) -> Fit:
    """The model fitted to shortened records, from the fit's values, without the held-out ones; the fit itself if its
    records are short."""
    campaign = shortened(fitted.campaign)
    return fitted if campaign is fitted.campaign else fit(fitted.model, campaign, initial=fitted.values, most=CRAWLS)


def shortened(campaign: Campaign) -> Campaign:
    """Excerpts of the fitted records in the place of all records; the campaign itself if these are short."""
    if not is_long(campaign):
        return campaign
    parts = (part for moving in _moving_parts(campaign) for part in _excerpts(*moving))
    return replace(campaign, records=tuple(parts))


def one_stretch_each(fitted: Fit) -> Fit:
    """The model fitted to one stretch of each fitted record, where that moves most, beside the held-out ones and
    without sweeps; the fit itself if its records are short. Of records that may be faulty two stretches of one would
    bear each other out."""
    if not is_long(fitted.campaign):
        return fitted
    parts = _moving_parts(fitted.campaign)
    liveliest = (_liveliest(record, _sizes(record, span, length), length) for record, span, length in parts)
    held_out = (record for record in fitted.campaign.traces if record.holdout)
    told = replace(fitted.campaign, records=(*liveliest, *held_out))
    return fit(fitted.model, told, initial=fitted.values, most=CRAWLS)


def _moving_parts(campaign: Campaign) -> list[tuple[Trace, tuple[int, int], int]]:
    """Each fitted record, where it moves, and how many samples of that are kept."""
    spans = [_moving(record) for record in campaign.fitted]
    lengths = _shares([stop - first for first, stop in spans])
    return list(zip(campaign.fitted, spans, lengths, strict=True))


def _moving(record: Trace) -> tuple[int, int]:
    """The stretch of the counted samples in which the device moves: a lab may wait long before it drives."""
    counted = record.response[record.skip :]
    size = max(len(counted) // _BLOCKS, 2)
    moves = np.array([np.std(counted[i : i + size]) for i in range(0, len(counted) - size + 1, size)])
    lively = np.flatnonzero(moves > _MOVES * moves.max())
    return record.skip + int(lively[0]) * size, min(record.skip + (int(lively[-1]) + 1) * size, len(record.time))


def _shares(lengths: Sequence[int]) -> list[int]:
    """How many samples of each record are kept: short ones whole, the others as much as is left."""
    kept, left = [0] * len(lengths), _KEPT
    for done, i in enumerate(sorted(range(len(lengths)), key=lambda i: lengths[i])):
        kept[i] = min(lengths[i], left // (len(lengths) - done))
        left -= kept[i]
    return kept


def _excerpts(record: Trace, span: tuple[int, int], length: int) -> list[Trace]:
    """The stretch that moves most; where the record has one that moves much less, that one too; the rest before."""
    resting = min(int(_RESTS * length), span[0] - record.skip)
    rest = [_part(record, span[0] - resting, resting)] if resting > 1 else []
    length -= resting
    whole, half = _sizes(record, span, length), _sizes(record, span, length // 2)
    loudest = max(whole.values())
    middle = min(half, key=lambda i: abs(half[i] / loudest - _QUIETER / 2))
    if length == span[1] - span[0] or abs(half[middle] / loudest - _QUIETER / 2) > _QUIETER / 2:
        return [*rest, _liveliest(record, whole, length)]
    return [*rest, *(_part(record, i, length // 2) for i in (max(half, key=lambda i: half[i]), middle))]


def _liveliest(record: Trace, sizes: dict[int, float], length: int) -> Trace:
    """The stretch that moves most."""
    return _part(record, max(sizes, key=lambda i: sizes[i]), length)


def _sizes(record: Trace, span: tuple[int, int], length: int) -> dict[int, float]:
    """How much the response moves in stretches of a length, by their first sample."""
    starts = range(span[0], span[1] - length + 1, max(length // 4, 1))
    return {i: float(np.std(record.response[i : i + length])) for i in starts}


def _part(record: Trace, first: int, length: int) -> Trace:
    """A stretch of a record, and what leads up to it."""
    before = min(first, int(_BEFORE * length))
    part = slice(first - before, first + length)
    start = record.start if part.start == 0 else "unknown"
    return replace(
        record,
        time=record.time[part],
        drive=record.drive[part],
        response=record.response[part],
        masked=None if record.masked is None else record.masked[part],
        start=start,
        skip=before,
        period=None,
        excerpt=True,
        floats=False,  # it is read by the zero that the fit to all of the record found
        into=record.into + record.step * part.start,
        begun=record.begun or record.start,
    )
