"""Tables of curves brought into one form: a row per point, with an amplitude and a phase.

Analysers write the real and the imaginary part; people put levels and directions side by side, a column each.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from ...errors import UserError
from ..tables.amplitude_unit import is_amplitude_unit, split_convention
from ..tables.table import Column, Table, is_number

_REAL = frozenset(["re", "real", "realteil", "inphase"])
_IMAGINARY = frozenset(["im", "imag", "imaginary", "imaginaer", "imaginär", "quadrature", "quad"])
_PAIRS = ((_REAL, _IMAGINARY), (frozenset("x"), frozenset("y")), (frozenset("i"), frozenset("q")))
_ANGLE = frozenset(["phase", "theta", "phi", "arg", "angle"])
_WHOLE = frozenset(["r", "mag", "magnitude", "amp", "amplitude", "betrag"])

LEVEL = re.compile(r"(?<![A-Za-z0-9.,])(\d+(?:[.,p]\d+)?)[ _]?(m?[VNA])[ _]?(rms|pp|pk|peak)?(?![A-Za-z])")
"""A drive level in the name of a column or of a file, of voltage, force or current: "3V", "0.5 Vpp", "200_mV"."""
_UP = re.compile(r"(?i)(?<![a-z])(up|upwards?|fwd|forward|rising|increasing)(?![a-z])")
_DOWN = re.compile(r"(?i)(?<![a-z])(down|dn|downwards?|bwd|backward|reverse|falling|decreasing)(?![a-z])")


def direction_in(text: str) -> str:
    """ "up" or "down" where a name says one of them, else ""."""
    up, down = bool(_UP.search(text)), bool(_DOWN.search(text))
    return "" if up == down else "up" if up else "down"


def level_in(text: str) -> str:
    """The drive level that a name states, as a quantity ("3 V", "0.5 Vpp"), or ""."""
    found = LEVEL.findall(text)
    if len(found) != 1:
        return ""
    number, unit, how = found[0]
    return f"{re.sub('[,p]', '.', number)} {unit}{how}"


def curve_form(table: Table, given: Mapping[str, str | int] | None = None) -> Table:
    """The table with one amplitude (and phase) column, in rows; itself if it has that form.

    **Arguments:** `given`: per role, what the campaign says; "real" and "imaginary" name a complex response.
    """
    given = given or {}
    if "amplitude" in given:
        return table
    return _in_rows(_polar(table, given))


def _words(column: Column) -> list[str]:
    stem = re.sub(r"([a-z])([A-Z])", r"\1 \2", column.stem) if not column.stem.isupper() else column.stem
    return re.sub(r"[^a-zäöü0-9]+", " ", split_convention(stem)[0].lower().replace("in-phase", "inphase")).split()


def _polar(table: Table, given: Mapping[str, str | int]) -> Table:
    """Amplitude and phase in place of real and imaginary part."""
    pair = _given_pair(table, given) if {"real", "imaginary"} & set(given) else _pair(table)
    if pair is None:
        return table
    real, imaginary = pair
    others = tuple(column for column in table.columns if column not in pair)
    whole = [column for column in others if _WHOLE & set(_words(column))]
    if "real" not in given and whole:  # a lock-in's R and theta stand beside its X and Y
        if any(_ANGLE & set(_words(column)) for column in others):
            return replace(table, columns=others)
        others = tuple(column for column in others if column not in whole)  # R alone holds less than X and Y
    response = real.numbers() + 1j * imaginary.numbers()
    header = f"{real.header} and {imaginary.header}"
    words = [word for word in _words(real) if word not in _REAL]
    plain = real.unit if real.unit is not None else _unit_in(real.doubtful)
    amplitude = replace(
        real, header=header, stem=" ".join(["amplitude", _how(real), *[w for w in words if len(w) > 1]]).strip(),
        unit=plain, cells=np.abs(response), doubtful="", printed=(),
    )  # fmt: skip
    phase = replace(amplitude, stem="phase", unit="rad", cells=np.angle(response), position=imaginary.position)
    note = f'{table.name}: the response is complex, from "{real.header}" and "{imaginary.header}".'
    return replace(table, columns=(*others, amplitude, phase), notes=(*table.notes, note))


def _how(column: Column) -> str:
    return {"rms": "rms", "peak": "pk", "peak-to-peak": "pp", "": ""}[split_convention(column.stem)[1]]


def _unit_in(text: str) -> str | None:
    return text if text and is_amplitude_unit(text) else None


def _given_pair(table: Table, given: Mapping[str, str | int]) -> tuple[Column, Column]:
    real, imaginary = (
        next((column for column in table.columns if column.is_called(given.get(role))), None)
        for role in ("real", "imaginary")
    )
    if real is None or imaginary is None:
        what = f"a complex response needs a real and an imaginary column; the columns are {table.found}"
        raise UserError(what, where=table.name, do='write columns = { real = "Re", imaginary = "Im" }')
    return real, imaginary


def _pair(table: Table) -> tuple[Column, Column] | None:
    """The columns of real and imaginary part, if there is one such pair."""
    for first, second in _PAIRS:
        found = []
        for real in table.columns:
            words = _words(real)
            here = [k for k, word in enumerate(words) if word in first]
            for imaginary in table.columns if here else ():
                other = _words(imaginary)
                same = len(other) == len(words) and imaginary.unit == real.unit
                if same and other[here[0]] in second and [*other[: here[0]], *other[here[0] + 1 :]] == [
                    *words[: here[0]], *words[here[0] + 1 :]
                ]:  # fmt: skip
                    found.append((real, imaginary))
        if len(found) == 1:
            return found[0]
    return None


def _in_rows(table: Table) -> Table:
    """One amplitude column where the table has one for each level or direction, with columns that say which."""
    groups: dict[str, list[tuple[str, str, Column]]] = {}
    for column in table.columns:
        level, direction = level_in(column.header), direction_in(column.header)
        if (level or direction) and "freq" not in column.stem.lower():
            if is_number(column.stem):  # "3 V" is the level, not a unit of what was read
                column = replace(column, unit=None)
            kind = "phase" if re.search(r"(?i)phase|phi|theta|arg", column.header) else "amplitude"
            groups.setdefault(kind, []).append((level, direction, column))
    wide = groups.get("amplitude", [])
    keys = [(level, direction) for level, direction, _ in wide]
    if len(wide) < 2 or len(set(keys)) < len(keys) or len({column.unit for *_, column in wide}) > 1:
        return table
    frequency = [column for column in table.columns if re.search(r"(?i)^f$|freq|omega|hz", column.header)]
    if len(frequency) != 1:
        return table
    phases = {(level, direction): column for level, direction, column in groups.get("phase", [])}
    phased = bool(phases) and set(phases) == set(keys)
    parts = [_part(frequency[0], column, phases[key] if phased else None)
             for key, (*_, column) in zip(keys, wide, strict=True)]  # fmt: skip
    counts = [len(part[0].cells) for part in parts]
    columns = [_stacked([part[0] for part in parts], "frequency"), _stacked([part[1] for part in parts], "amplitude")]
    if phased:
        columns.append(_stacked([part[2] for part in parts], "phase"))
    lines = columns[0].lines
    for name, values in (("level", [k[0] for k in keys]), ("direction", [k[1] for k in keys])):
        if all(values):
            unit = values[0].split(" ", 1)[1] if name == "level" else None
            if name == "level" and len({value.split(" ", 1)[1] for value in values}) > 1:
                return table
            cells = [value.split(" ", 1)[0] for value, n in zip(values, counts, strict=True) for _ in range(n)]
            columns.append(Column(table.name, name, name, unit, 0, cells, lines))
    note = f"{table.name}: {len(wide)} curves stand side by side, {', '.join(c.header for *_, c in wide)}."
    return replace(table, columns=tuple(columns), notes=(*table.notes, note))


def _part(frequency: Column, amplitude: Column, phase: Column | None) -> tuple[Column, ...]:
    """The rows in which a curve has a point: side by side, curves need not cover the same frequencies."""
    columns = [frequency, amplitude, *([phase] if phase is not None else [])]
    kept = [row for row, cell in enumerate(amplitude.cells) if not _absent(cell)]
    return tuple(
        replace(c, cells=[c.cells[r] for r in kept], lines=[c.lines[r] for r in kept if r < len(c.lines)])
        for c in columns
    )


def _absent(cell: object) -> bool:
    text = str(cell).strip().lower()
    return text in ("", "nan", "-", "--", "n/a", "na")


def _stacked(columns: Sequence[Column], stem: str) -> Column:
    cells = [cell for column in columns for cell in column.cells]
    lines = [line for column in columns for line in column.lines]
    plain = cells if all(isinstance(cell, str) for cell in cells) else np.array([_number(cell) for cell in cells])
    unit = columns[0].unit
    return replace(columns[0], stem=stem, unit=unit, cells=plain, lines=lines, printed=())


def _number(cell: object) -> float:
    return float(str(cell)) if is_number(str(cell)) else float("nan")
