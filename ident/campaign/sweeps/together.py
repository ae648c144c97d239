"""Sweeps that lie in several files, one level or one direction each, seen together."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from scipy.special import ndtri

from ..record import Record, Run, Sweep, same_level
from .jump import jump_of, loop_runs_backwards
from .noise import sweep_noise
from .repeatability import with_repeatability
from .speed import with_speeds

_BY_CHANCE = (
    0.0124  # that the noise of one of the levels leaves the common one so far: 2.5 standard errors, were it one
)


def seen_together(records: Sequence[Record], notes: list[str]) -> list[Record]:
    """The records, with sweeps turned where only the jumps of another file tell, and with the noise that they share."""
    found = list(records)
    for group in _groups(found):
        _turn(found, group, notes)
        _share_noise(found, group, notes)
        together = [record for k in group for record in [found[k]] if isinstance(record, Sweep)]
        for k, record in zip(group, together, strict=True):
            if record.noise.relative_error > 0:  # nobody gave it
                found[k] = with_repeatability(record, together, notes)
    return with_speeds(found, notes)


def _groups(records: Sequence[Record]) -> list[list[int]]:
    """Sweeps of one device in one state: of the same quantity, load and kind of columns."""
    groups: dict[tuple, list[int]] = {}
    for k, record in enumerate(records):
        if isinstance(record, Sweep):
            key = (record.load, record.quantity, record.phase is None, record.response_channel, record.dwell is None)
            groups.setdefault(key, []).append(k)
    return list(groups.values())


def _turn(records: list[Record], group: list[int], notes: list[str]) -> None:
    """Exchanges up and down between files of one direction each where all pairs have their jumps the wrong way."""
    runs = [(k, run) for k in group for record in [records[k]] if isinstance(record, Sweep) for run in record.runs]
    found = []
    for k, run in runs:
        other = [(j, o) for j, o in runs if j != k and run.up and not o.up and abs(o.level / run.level - 1) < 0.01]
        if len(other) == 1:
            told = loop_runs_backwards(_jump(records[k], run), _jump(records[other[0][0]], other[0][1]))
            found.append((k, other[0][0], told))
    wrong = {k for a, b, told in found for k in (a, b) if told}
    single = all(len({run.up for run in record.runs}) == 1 for k in wrong
                 for record in [records[k]] if isinstance(record, Sweep))  # fmt: skip
    if not wrong or not single or any(told is False for *_, told in found):
        return
    for k in {k for a, b, _ in found for k in (a, b)}:
        record = records[k]
        assert isinstance(record, Sweep)
        records[k] = replace(record, up=~record.up)
    first = next((records[a].name, records[b].name) for a, b, told in found if told)
    notes.append(
        f"{first[0]} and {first[1]}: up and down are exchanged: the curve called up jumps below the one called down, "
        "which no device does; all files of that kind are read the other way round."
    )


def _jump(record: Record, run: Run):
    assert isinstance(record, Sweep)
    return jump_of(record, run.rows)


def _share_noise(records: list[Record], group: list[int], notes: list[str]) -> None:
    """One noise for the levels of all files whose own estimates agree with it, as a level alone tells its parts apart
    but poorly; and one of its own for each level that leaves it further than by chance."""
    own = [record for k in group for record in [records[k]]
           if isinstance(record, Sweep) and 0 < record.noise.relative_error < 1]  # fmt: skip
    levels = [
        (record.name, rows, sweep_noise(record.only(rows))) for record in own for rows in same_level(record.level)
    ]
    levels = [(name, rows, alone) for name, rows, alone in levels if alone.noise.relative_error < 1]
    if len(levels) < 2:
        return
    common = sweep_noise(_joined(own))
    farthest = -ndtri(_BY_CHANCE / (2 * len(levels)))
    for k in group:
        record = records[k]
        if not isinstance(record, Sweep) or not any(record is one for one in own):
            continue
        shared = _with_noise_of(record, common)
        apart = []
        for name, rows, alone in levels:
            if name == record.name:
                times = float(np.median(alone.deviation) / np.median(shared.deviation[rows]))
                if abs(np.log(times)) > farthest * float(
                    np.hypot(alone.noise.relative_error, common.noise.relative_error)
                ):
                    apart.append((rows, alone, times))
        records[k] = _with_levels(shared, apart, notes)


def _with_noise_of(sweep: Sweep, other: Sweep) -> Sweep:
    return replace(sweep, noise=other.noise, relative_noise=other.relative_noise, phase_noise=other.phase_noise)


def _with_levels(sweep: Sweep, apart: list[tuple[np.ndarray, Sweep, float]], notes: list[str]) -> Sweep:
    """The sweep with some levels, given by their rows, that have a noise of their own; by how many times larger than
    the common one is said."""
    if len(apart) == 1 and len(apart[0][0]) == len(sweep.frequency):
        return _with_noise_of(sweep, apart[0][1])
    if not apart:
        return sweep
    noises, volts = sweep.noises.copy(), sweep.drive_channel
    for rows, alone, _ in apart:
        noises[:, rows] = alone.noises
    told = ", ".join(
        f"{np.median(alone.level) / volts.factor:.4g} {volts.unit} {times:.2g} times" for _, alone, times in apart
    )
    notes.append(
        f"{sweep.name}: its levels scatter differently: {told} as much as all of them together; what is named has a "
        "noise floor of its own."
    )
    return replace(sweep, own_noise=noises)


def _joined(sweeps: Sequence[Sweep]) -> Sweep:
    arrays = {name: np.concatenate([getattr(sweep, name) for sweep in sweeps])
              for name in ("frequency", "level", "amplitude", "up")}  # fmt: skip
    phases = [sweep.phase for sweep in sweeps if sweep.phase is not None]
    return replace(sweeps[0], **arrays, phase=np.concatenate(phases) if phases else None, dwell=None,
                   overtones=())  # fmt: skip
