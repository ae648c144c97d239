"""Harmonics of a sweep: columns with the amplitude of the response at multiples of the drive's frequency.

A lock-in or a spectrum shows how far a motion is from a sine. The second harmonic tells an even force from one that
softens, the third one the shape of an odd one. Phases of harmonics are not read.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from ...errors import UserError
from ...units import factor_of, find_unit
from ..record import Overtone, Sweep
from ..spec import HARMONICS
from ..tables.amplitude_unit import TO_PEAK, amplitude_unit, split_convention
from ..tables.columns import rate_of
from ..tables.table import Column, Table
from .jump import unbroken
from .rice import read_beside
from .variances import CLIP, KEPT

_WORDS = ("second", "third", "fourth", "fifth", "sixth", "seventh", "eighth")
_AMPLITUDE = r"(?:a|r|amp|ampl|amplitude|mag|magnitude|response|displacement)"
_NAMES = (
    rf"{_AMPLITUDE} ?([2-8])(?: ?[fwω])?",  # A2, R 3, amp_2f
    rf"(?:{_AMPLITUDE} )?(?:at )?([2-8]) ?[fwω](?: {_AMPLITUDE})?",  # 2f, amplitude 3f, 2f amplitude
    rf"(?:{_AMPLITUDE} )?(?:of )?(?:the )?([2-8])(?:nd|rd|th)? harmonic(?: {_AMPLITUDE})?",
    rf"(?:{_AMPLITUDE} )?(?:harm|harmonic) ?([2-8])(?: {_AMPLITUDE})?",  # H2 is an estimator
)
_ANGLE = re.compile(r"(?i)phase|phi|theta|angle|\barg\b")
_NEAR = np.array([-1, 4, -6, 4, -1]) / 6  # a cubic through two neighbours on each side, less the point itself
_NORMAL = 0.6745  # median of the modulus of a normal variable of variance one
_BY_CHANCE = 2 * (1 + 1 / np.sqrt(5))  # noise variances up to which the mean power of five points is likely noise
_ROUNDS = 8  # in which noise and what lies under it settle
_LEAST = 1e-6  # of the fundamental: a scatter below is that of rounding


def harmonic_of(column: Column) -> int | None:
    """Which harmonic a column is named after, or None."""
    text = re.sub(r"([a-zA-Z])_", r"\1 ", split_convention(column.stem)[0] or column.stem)
    words = re.sub(r"[^a-z0-9ω]+", " ", text.lower()).strip()
    for k, word in zip(HARMONICS.values(), _WORDS, strict=True):
        words = words.replace(word, str(k))
    match = next((found for name in _NAMES if (found := re.fullmatch(name, words))), None)
    per_drive = column.unit is not None and "/" in column.unit and rate_of(column.unit) is None
    return None if match is None or per_drive or _ANGLE.search(column.header) else int(match[1])


def split_harmonics(table: Table, given: Mapping[int, str | int], where: str) -> tuple[Table, dict[int, Column]]:
    """The table without the columns of harmonics, and these by their order; `given`: what the campaign says."""
    found: dict[int, Column] = {}
    for order, wanted in given.items():
        fits = [column for column in table.columns if column.is_called(wanted)]
        if len(fits) != 1:
            what = f'harmonic{order} = "{wanted}" fits {len(fits)} columns of {table.name}; they are {table.found}'
            raise UserError(what, where=where, do="name one of its columns")
        found[order] = fits[0]
    taken = set(map(id, found.values()))
    for column in table.columns:
        order = harmonic_of(column)
        if order is None or id(column) in taken:
            continue
        if order in found and order not in given:
            what = f'the {_ordinal(order)} harmonic can be "{found[order].header}" or "{column.header}"'
            raise UserError(
                what, where=table.name, do=f'say which with columns = {{ harmonic{order} = "{column.header}" }}'
            )
        if order not in found:
            found[order] = column
            taken.add(id(column))
    if not found:
        return table, {}
    rest = tuple(column for column in table.columns if id(column) not in taken)
    names = ", ".join(f'"{column.header}"' for _, column in sorted(found.items()))
    word = "are read as harmonics" if len(found) > 1 else "is read as a harmonic"
    return replace(table, columns=rest, notes=(*table.notes, f"{table.name}: {names} {word}.")), found


def overtones_of(columns: Mapping[int, Column], units: Mapping[str, str], sweep: Sweep) -> tuple[Overtone, ...]:
    """The harmonics of a sweep, with the noise that their points show.

    **Raises:** UserError for a column without a unit of the response, or with what cannot be an amplitude.
    """
    return tuple(_overtone(order, column, units, sweep) for order, column in sorted(columns.items()))


def _overtone(order: int, column: Column, units: Mapping[str, str], sweep: Sweep) -> Overtone:
    where = f'{column.file}, column {column.position} ("{column.header}")'
    told = units.get(f"harmonic{order}", units.get(column.header, units.get(column.stem, column.unit)))
    base = sweep.response_channel.unit
    do = f'write "{column.stem} ({base})" above it, or units = {{ harmonic{order} = "{base}" }} in the [[record]]'
    if told is None:
        raise UserError(f"the {_ordinal(order)} harmonic states no unit", where=where, do=do)
    meant = amplitude_unit(told, lambda unit: _same(unit, base), None)
    if meant is None or meant.per or not meant.unit:
        what = f'the {_ordinal(order)} harmonic is in "{told}", which is no unit of what the amplitude is in ({base})'
        raise UserError(what, where=where, do=do)
    convention = meant.convention or split_convention(column.stem)[1]
    factor = 1.0 if meant.convention else TO_PEAK[convention]
    numbers = column.numbers()
    if not meant.decibel and np.any(numbers < 0):
        row = int(np.flatnonzero(numbers < 0)[0])
        raise UserError("an amplitude cannot be negative", where=column.place(row), do="correct or delete the row")
    plain = sweep.response_channel.factor if meant.unit == base else factor_of(meant.unit)
    return Overtone(order, factor * meant.amplitudes(numbers) * plain, np.zeros(len(numbers)))


def _same(unit: str, base: str) -> bool:
    if unit == base:
        return True
    found, other = find_unit(unit), find_unit(base)
    return found is not None and other is not None and found.dimension == other.dimension


def with_overtone_noise(sweep: Sweep) -> Sweep:
    """The sweep with the noise of its harmonics: a constant, by how far points leave the cubic through their
    neighbours, and in proportion what the fundamental scatters by."""
    told = []
    for one in sweep.overtones:
        constant = _scatter(sweep, one.amplitude)
        least = _LEAST * float(np.max(sweep.amplitude))
        told.append(one._replace(noise=np.hypot(max(constant, least), sweep.noises[1] * one.amplitude)))
    return replace(sweep, overtones=tuple(told))


def _scatter(sweep: Sweep, amplitude: np.ndarray) -> float:
    """Standard deviation of the real part of the noise of a harmonic: what its points scatter by, which is less than
    that where they are mostly noise."""
    left, level = [], []
    for run in sweep.runs:
        for part in unbroken(sweep, run.rising):
            if len(part) >= len(_NEAR):
                left.append(np.convolve(amplitude[part], _NEAR, "valid") / np.linalg.norm(_NEAR))
                level.append(np.convolve(amplitude[part] ** 2, np.full(len(_NEAR), 1 / len(_NEAR)), "valid"))
    if not left:
        return float(sweep.noise.sigma)
    off, power = np.abs(np.concatenate(left)), np.concatenate(level)
    sigma = float(np.median(off)) / _NORMAL
    for _ in range(_ROUNDS if sigma > 0 else 0):
        beyond = np.maximum(power - _BY_CHANCE * sigma**2, 0.0)
        _, _, spread = read_beside(np.sqrt(beyond), np.full(len(power), sigma))
        sigma *= float(np.sqrt(np.mean(np.minimum(off / spread, CLIP) ** 2) / KEPT))
    return sigma


def _ordinal(order: int) -> str:
    return {2: "2nd", 3: "3rd"}.get(order, f"{order}th")
