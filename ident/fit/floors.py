"""Noise floors in the light of what a model leaves: lowered where the data alone give a bound, or raised by mains hum.

Beside a broadband drive or the blow of a hammer no frequency is free of motion, and a floor read off the response is
too high by as much as moves there. In what a model leaves there is less motion, so that the same estimate gives less:
it stays a bound, and is the noise once the model lacks nothing. Where only the frequencies above the drive tell it,
those below do, too. And a floor read off other frequencies than those of the motion does not know of hum among these,
which stands out of what a model leaves.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from ..campaign.campaign import Campaign
from ..campaign.noise.floor import EXTRAPOLATED, extrapolated, noise_floor
from ..campaign.noise.hum import (
    FEWEST,
    HUM,
    HUMS,
    SURROUNDINGS,
    Apart,
    Line,
    hum_lines,
    knows,
    mains_of,
    standing,
    told_apart,
    tuned_beside_level,
    with_lines,
)
from ..campaign.noise.interpolated import interpolated
from ..campaign.noise.surroundings import Heard, lines_of_surroundings, may_make, tones_of
from ..campaign.record import VAGUE, NoiseFloor, Trace
from ..model import FREQUENCY, QUALITY
from .result import Fit

_MANY = 8.0  # periods of hum that no level follows as it bends from one end to the other
_SAME = 0.05  # relative: floors that differ by less leave a model adequate or not (`diagnosis.enough`)
_HIGHER = 5.0  # of its errors: of floors that were extrapolated few were as far too low (`experiments.hidden_noise`)
_RINGING = ("oscillator", "base", "shaken")  # forms with a resonance
_LOWER = 0.8  # of the floor so far: up to a fifth above one in doubt a model is adequate (`diagnosis.enough`)


def sharpened(found: Fit, complete: bool = True) -> Campaign | None:
    """The campaign of a fit with other noise floors where its own are in doubt, and higher ones where the records hum;
    None if no floor changes. `complete`: whether the model has all that was found; one that lacks an effect may miss a
    level that bends as a few periods of hum do, and is asked for longer ones only."""
    readings = iter(found.readings)
    told = lambda record, reading: (complete and _interpolated(record, reading, found)) or _lowered(record, reading)
    records = [told(r, next(readings)) if isinstance(r, Trace) else r for r in found.campaign.records]
    traces = [record for record in records if isinstance(record, Trace)]
    hum = iter(_with_hum(found, traces, FEWEST if complete else _MANY))
    records = [next(hum) if isinstance(record, Trace) else record for record in records]
    changed = [new for old, new in zip(found.campaign.records, records, strict=True) if new is not old]
    if not changed:
        return None
    why = "it stands out of what a model leaves, whatever drives them"
    notes = [
        f"{line.capitalize()} counts as noise in {', '.join(loud)}: {why}."
        for line in (HUMS, SURROUNDINGS)
        if (loud := [record.name for record in changed if line in record.noise.lines])
    ]
    return replace(found.campaign, records=tuple(records), notes=(*found.campaign.notes, *notes))


def _interpolated(record: Trace, reading: np.ndarray, found: Fit) -> Trace | None:
    """The record with the noise floor between what a model leaves below and above the band of the drive, where its own
    is extrapolated and another one."""
    left = (record.response - reading)[record.skip :]
    if not extrapolated(record.noise) or record.masked is not None or not np.all(np.isfinite(left)):
        return None
    resonance, quality = (float(found.values[i]) for i in (FREQUENCY, QUALITY))
    at = resonance * record.step if found.model.form in _RINGING else -1.0
    width = at / quality if at > 0 else 0.0
    fit = interpolated(record.drive[record.skip :], left, record.noise.unseen, at, width)
    if fit is None or fit.relative_error >= EXTRAPOLATED:
        return None
    higher = float(np.log(fit.sigma / record.noise.sigma))
    if abs(higher) < _SAME or higher > _HIGHER * record.noise.relative_error:
        return None
    method = "what the model leaves below and above the drive's frequencies"
    return replace(record, noise=NoiseFloor(fit.sigma, fit.ar, method, fit.relative_error))


def _lowered(record: Trace, reading: np.ndarray) -> Trace:
    """The record with the noise floor of what the model leaves of it, if it has a higher one that is in doubt or was
    read off frequencies beside those of the motion: a law that jumps moves at all of them."""
    told, left = record.noise, record.response - reading
    if (told.relative_error < VAGUE and not extrapolated(told)) or not np.all(np.isfinite(left)):
        return record
    if told.lines:  # raised by what a model left: else there were no end of it
        return record
    later = slice(record.skip, None)
    masked = None if record.masked is None else record.masked[later]
    floor = noise_floor(record.time[later], record.drive[later], left[later], record.period, masked, record.stuck == 0)
    if not floor.sigma < _LOWER * told.sigma:
        return record
    return replace(record, noise=replace(floor, method=f"{floor.method}, in what the model leaves"))


def _with_hum(found: Fit, traces: list[Trace], periods: float) -> list[Trace]:
    """The records with the lines in their noise floors that are none of the device: the mains frequencies that two of
    them show beside their drive, or the only one, in so many `periods` or more; and those of the surroundings, that all
    show.

    No device hums in one record as in another at the frequency of the mains, whatever drives it. Where two do, others
    that are driven at it too hum with them. Under many tones a device that lacks a law answers at any frequency: where
    some records have one or two tones, which cannot have made the line, only these bear witness.
    """
    pairs = list(zip(traces, found.readings, strict=True))
    heard = [Heard((r.response - told)[r.skip :], r.drive[r.skip :], r.step) for r, told in pairs]
    few = [tones_of(one) is not None for one in heard]
    places_of, shown = [], []
    for (record, reading), one in zip(pairs, heard, strict=True):
        mains = _mains_of(record, reading, found)
        at = {line.nominal: line for line in hum_lines(mains, len(one.left), record.step)}
        lines = _hum_of(record, reading, found, [at[hz] for hz in HUM if hz >= periods * one.width], apart=True)
        places_of.append(at)
        shown.append({hz for hz in lines if not (any(few) and may_make(one, at[hz].hz))})
    needed = min(2, sum(few) or len(traces))
    common_hum = [hz for hz in HUM if sum(hz in one for one in shown) >= needed]
    others = lines_of_surroundings(heard) if all(r.masked is None for r in traces) else []
    for what, common in ((HUMS, common_hum), (SURROUNDINGS, others)):
        humming = []
        for (record, reading), at in zip(pairs, places_of, strict=True):
            places = {hz: at[hz] if what == HUMS else Line(float(hz), float(hz)) for hz in common}
            own = _hum_of(record, reading, found, list(places.values()), apart=False) if common else {}
            lines = [
                places[hz] for hz, power in own.items()
                if power > (record.noise.sigma**2 if _has(record, places[hz].hz, what) else 0.0)
                and not knows(record.noise, power, 2 * np.pi * places[hz].hz * record.step)
            ]  # fmt: skip
            if lines:
                floor = with_lines(record.noise, [own[line.nominal] for line in lines], lines, record.step, what)
                record = replace(record, noise=floor)
            humming.append((record, reading))
        pairs = humming
    return [record for record, _ in pairs]


def _has(record: Trace, hz: float, what: str) -> bool:
    """Whether a line, or one that its samples do not tell from it, is a part of a record's floor already; of floors
    that were kept before they said where, whether any of `what` it is one of."""
    width, known = 1 / (len(record.time) * record.step), record.noise.heard
    near = any(abs(hz - other) < 1.5 * width for _, other in known)
    return near if known else what in record.noise.lines


def _mains_of(record: Trace, reading: np.ndarray, found: Fit) -> tuple[float, ...]:
    """Hz of each of the mains while a record was taken: as its noise floor knows, or what a model leaves says."""
    left = (record.response - reading)[record.skip :]
    if HUMS in record.noise.lines or record.masked is not None or not np.all(np.isfinite(left)):
        return mains_of(record.noise)
    return tuned_beside_level(left, record.step, _apart(record, found, len(left)))


def _apart(record: Trace, found: Fit, n: int) -> Apart:
    """Whether lines are none of the drive, and not near the resonance, where transients ring; n samples count."""
    rate = 2 * np.pi / record.period if record.period is not None else None
    resonance, width = float(found.values[FREQUENCY]), 1 / (n * record.step)
    if found.model.form == "oscillator":
        width += resonance / float(found.values[QUALITY])
    at = 2 * np.pi * record.step
    return lambda rates: told_apart(rates, rate, n, FEWEST) & (abs(rates - at * resonance) >= 3 * at * width)


def _hum_of(record: Trace, reading: np.ndarray, found: Fit, tried: Sequence[Line], apart: bool) -> dict[float, float]:
    """Mean squares, m², of the lines, of those that are `tried`, that stand out of what a model leaves of a record, by
    their nominal Hz; if `apart`, without those of the drive and near the resonance."""
    left = (record.response - reading)[record.skip :]
    n = len(left)
    if record.masked is not None or not np.all(np.isfinite(left)):
        return {}
    rates = 2 * np.pi * record.step * np.array([line.hz for line in tried])
    told = _apart(record, found, n)(rates) if apart else told_apart(rates, None, n, FEWEST)
    lines = [line for line, alone in zip(tried, told, strict=True) if alone]
    powers = standing(left, record.step, lines) if lines else []
    return {line.nominal: power for line, power in zip(lines, powers, strict=True) if power > 0}
