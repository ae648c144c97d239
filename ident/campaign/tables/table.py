"""A table as it lies in a file: named columns, each with the unit that its header states."""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from ...errors import UserError
from ...units import plain_micro
from .amplitude_unit import is_amplitude_unit, split_convention


@dataclass(frozen=True, eq=False)
class Column:
    """One column of a table.

    **Arguments:**

    - `header`: as written in the file; `stem`: the header without its unit; `unit`: None if none is stated.
    - `doubtful`: what stands in brackets in the header but is no unit.
    - `position`: 1 for the first column; `cells`: (n,) texts or numbers; `lines`: (n,) line of each cell in the file;
      `printed`: some of the cells as they were printed, where `cells` are numbers.
    """

    file: str
    header: str
    stem: str
    unit: str | None
    position: int
    cells: Sequence[str] | np.ndarray
    lines: Sequence[int] = ()
    decimal: str = "."
    doubtful: str = ""
    printed: Sequence[str] = ()

    def is_called(self, wanted: str | int | None) -> bool:
        """Whether a header, with its unit or without, or a number means this column."""
        return wanted in (self.header, self.stem, self.position)

    def place(self, row: int) -> str:
        """Where a cell is, for an error message."""
        line = f"line {self.lines[row]}" if row < len(self.lines) else f"row {row + 1}"
        return f'{self.file}, {line}, column {self.position} ("{self.header}")'

    def at(self, rows: np.ndarray) -> Column:
        """The column with only those rows."""
        cells = self.cells[rows] if isinstance(self.cells, np.ndarray) else [self.cells[row] for row in rows]
        lines = [self.lines[row] for row in rows] if len(self.lines) else ()
        return replace(self, cells=cells, lines=lines, printed=())

    def numbers(self, missing: bool = False) -> np.ndarray:
        """(n,) the cells as finite numbers, in the unit of the file; a `UserError` at the first cell that is none.

        If some may be `missing`, what stands for a number that is not there, or nothing, becomes NaN.
        """
        values = np.asarray(self.cells, float) if isinstance(self.cells, np.ndarray) else _plain(self.cells)
        if values is None:
            cells = self.cells if self.decimal == "." else [cell.replace(",", ".") for cell in self.cells]
            empty = missing and any(is_number(cell) for cell in cells)
            found = [
                float(cell)
                if is_number(cell)
                else math.nan
                if no_finite(cell) or (empty and not cell.strip())
                else None
                for cell in cells
            ]
            if None in found:
                raise self._bad_cell(found.index(None))
            values = np.array(found, dtype=float)
        bad = np.flatnonzero(~(np.abs(values) < MOST))
        if missing:
            bad = bad[np.isfinite(values[bad])]
            values = np.where(np.isfinite(values), values, math.nan)
        if len(bad):
            raise self._bad_cell(int(bad[0]), len(bad))
        return np.where(np.abs(values) < 1 / MOST, 0.0, values)

    @property
    def counts(self) -> bool:
        """Whether the column only counts the samples; those that were lost it counts, too."""
        first = [str(cell) for cell in self.cells[:50]]
        if len(first) < 3 or not all(is_number(cell) for cell in first):
            return False
        numbers = np.array([float(cell) for cell in first])
        if not np.all(np.isfinite(numbers)):
            return False
        steps = np.diff(numbers)
        return bool(np.median(steps) == 1.0 and np.min(steps) >= 1.0 and np.all(steps == np.round(steps)))

    def _bad_cell(self, row: int, count: int = 1) -> UserError:
        cell = str(self.cells[row]).strip()
        what = f'"{cell}" is not a number' if cell else "the cell is empty"
        if is_number(cell) or no_finite(cell):
            what = f'"{cell}" is not a finite number' + (" whose square is one" if is_number(cell) else "")
        if count > 1:
            what += f" (and {count - 1} more like it)"
        advice = "correct the cell, or cut the record there: a record needs a number in every row"
        return UserError(what, where=self.place(row), do=advice)


@dataclass(frozen=True, eq=False)
class Table:
    """The columns of one file; `name` is the file as the campaign names it, `notes` what was assumed in reading it."""

    name: str
    columns: tuple[Column, ...]
    notes: tuple[str, ...] = ()

    @property
    def found(self) -> str:
        """The columns in words, for error messages."""
        return ", ".join(f'"{column.header}"' for column in self.columns)


MOST = 1e100  # whatever was measured is less, and its square still a number; what is less than its inverse is zero


_NO_FINITE = frozenset(re.split(" ", "nan inf infinity \u221e 1.#inf 1.#ind 1.#qnan #n/a n/a #inf over overrange ovr"))


def no_finite(cell: str) -> bool:
    """Whether a text is how instruments print a number that they do not have."""
    return str(cell).strip().lower().lstrip("+-") in _NO_FINITE


def _plain(cells: Sequence[str]) -> np.ndarray | None:
    """(n,) the cells, if each `is_number`: to ask them one by one takes four times as long."""
    text = "".join(cells)
    if not text.isascii() or "_" in text:
        return None
    try:
        values = np.array([float(cell) for cell in cells])
    except ValueError:
        return None
    return None if np.any(np.isnan(values)) else values


def is_number(cell: str) -> bool:
    """Whether a text is a number as instruments print it: digits of this script, no underscores."""
    try:
        return not math.isnan(float(cell)) and cell.isascii() and "_" not in cell
    except ValueError:
        return False


# What may follow an underscore or a blank: a short list, so that "V_in" is not taken for inches.
_SUFFIX_UNITS = frozenset(
    re.split(
        " ",
        "s ms us ns min V mV uV kV m cm mm um nm pm micron Hz kHz MHz rad deg A mA uA kA N mN uN kN Nm mNm uNm kNm "
        "Pa kPa MPa K C kg mg dB dBV dBm volt volts second seconds hertz m/s mm/s rad/s rpm m/s^2 m/s2",
    )
)
_IN_CAPITALS = {"MV": "mV", "UV": "uV", "HZ": "Hz", "KHZ": "kHz", "KV": "kV", "KN": "kN", "KA": "kA"}


def _suffix_unit(text: str) -> bool:
    """Whether what follows an underscore is a unit, of a sine's amplitude too: "mV", "mVrms", "umpp"."""
    return plain_micro(text) in _SUFFIX_UNITS or plain_micro(split_convention(text)[0]) in _SUFFIX_UNITS


# Rates without a slash, as names of columns need them: "acc_m_s2", "v_mm_per_s", "speed_mps", "a_ms2".
_RATE = re.compile(r"(.*\w)[_ ]([um]?m|rad|deg)(?:_per_|_|per|p|(?=s-?2))s(?:ec)?_?(-?2)?")


def split_header(header: str, own_unit: str = "") -> tuple[str, str | None, str]:
    """A header as (stem, unit or None, doubtful text): "z [um]" is ("z", "um", ""). The g of a signal is that of the
    Earth, not a gram.

    `own_unit` is a unit that exists for this campaign only (an oscillator's "counts").
    """
    stem, unit, doubtful = _split(header, own_unit)
    if own_unit == "g":
        return stem, unit, doubtful
    if (gravity := re.fullmatch(r"(.*acc.*?)[_ ]+g", header.strip(), re.IGNORECASE)) is not None:
        return gravity[1], GRAVITY, ""
    return stem, signal_unit(unit, stem), doubtful


GRAVITY = "g_n"
_WEIGHED = re.compile(r"mass|weight|load|force|kraft|gewicht", re.IGNORECASE)


def signal_unit(unit: str | None, stem: str) -> str | None:
    """The unit of a column, where a bare g is that of the Earth: nobody drives a device in grams, or reads them, but
    off a scale."""
    return GRAVITY if unit in ("g", "G") and not _WEIGHED.search(stem) else unit


def _split(header: str, own_unit: str) -> tuple[str, str | None, str]:
    text = header.strip().strip("\"'").strip()

    def known(name: str, rare: bool = False) -> bool:
        return is_amplitude_unit(name, rare) or (own_unit != "" and name == own_unit)

    match = re.fullmatch(r"(.*?)[\s_,]*[(\[{<]\s*([^()\[\]{}<>]*?)\s*[)\]}>]", text)
    if match and match[2]:
        unit = match[2].removeprefix("in ").strip()
        return (match[1].strip(), unit, "") if known(unit, True) else (match[1].strip(), None, unit)
    match = _RATE.fullmatch(text)
    if match:
        return match[1].strip(" _"), f"{match[2]}/s{'^2' if match[3] else ''}", ""
    match = re.fullmatch(r"(.+?)[_ .:-]([^\s_.:-]+/[^\s_.:-]+)", text)
    if match and not match[1].endswith(" in") and plain_micro(match[2]) in _SUFFIX_UNITS:  # "acceleration_m/s^2"
        return match[1].strip(" _"), match[2], ""
    for pattern in (r"(.*\S)\s+in\s+(\S+)", r"(.*\S)\s*/\s*(\S+)", r"(.*\S)\s*,\s*(\S+)"):
        match = re.fullmatch(pattern, text)
        if match and known(match[2]):
            return match[1].strip(), match[2], ""
    match = re.fullmatch(r"(.+)([_ .:-])([^\s_.:-]+)", text)
    if match and (match[2] != " " or len(match[3]) > 1 or match[3] in "sV"):  # "Channel A" is not in amperes
        stem, _, unit = match.groups()
        if _suffix_unit(unit) or unit == own_unit:
            return stem.strip(" _"), unit, ""
        written = _IN_CAPITALS.get(unit, unit.lower())
        if text.isupper() and _suffix_unit(written):  # TIME_MS, DRIVE_MV
            return stem.strip(" _"), written, ""
    return text, None, ""


def with_unit_row(column: Column, unit: str) -> Column:
    """The column with the unit that a separate row of units states."""
    unit = unit.strip().strip("\"'").strip(" ()[]{}")
    if not unit or column.unit is not None:
        return column
    return replace(column, unit=unit) if is_amplitude_unit(unit) else replace(column, doubtful=unit)
