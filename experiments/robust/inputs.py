"""Broken inputs by the thousand: a table, a campaign file or arrays that were right, after a few accidents."""

from __future__ import annotations

from typing import Any

import numpy as np

ROWS = 160
_NUMBERS = (
    "nan", "inf", "-inf", "1e308", "-1e308", "1e-308", "1e400", "0", "-0.0", "1_000", "٣", "1,5", "--3", "0x1F", "1e",
    "", " ", "9" * 400, "true", "None", "1;2", "\x1b[31m", "\x00", "µ", "1.2.3", "+5", "1e-300",
)  # fmt: skip
_HEADS = (
    "t", "time (s)", "time (ms)", "Zeit [s]", "u", "drive (V)", "drive (mV)", "CH1", "y", "z [um]", "displacement (nm)",
    "z (furlong)", "freq (Hz)", "amplitude (um)", "", "t", "$\\frac{", "a" * 255, "time (V)", "x (m/s^2)", "\x07",
)  # fmt: skip
_VALUES: tuple[Any, ...] = (
    None, True, 0, -1, 1e400, 10**400, "", "rest", "12 nm", "12 V", "1e-300 nm", "1e308 m", [], {}, [1, 2], {"a": 1},
    "../../etc/passwd", "\x00", "sine 8 V 317 Hz", "sine", "none", "frame", "nan", float("nan"), "𝟙 nm", "a" * 5000,
)  # fmt: skip
_KEYS = (
    "file", "kind", "start", "holdout", "load", "noise", "skip", "columns", "units", "rate", "drive", "drive_file",
    "direction", "quantity", "level", "nonsense", "data",
)  # fmt: skip


def good_columns(rng: np.random.Generator, rows: int = ROWS) -> dict[str, np.ndarray]:
    """A resonance driven by a sine, with noise: what a laboratory would send."""
    t = np.arange(rows) / 20e3
    drive = rng.uniform(1, 9) * np.sin(2 * np.pi * rng.uniform(300, 700) * t)
    lag = 2 * np.pi * 500 * t
    return {"time (s)": t, "drive (V)": drive, "z (um)": 2 * np.sin(lag) + 0.02 * rng.standard_normal(rows)}


def table_text(rng: np.random.Generator) -> str:
    """A CSV file after up to four accidents."""
    columns = good_columns(rng, int(rng.choice([3, 19, 25, ROWS, ROWS])))
    cells = [list(columns), *([f"{x:.9g}" for x in row] for row in zip(*columns.values(), strict=True))]
    for _ in range(rng.integers(0, 5)):
        _spoil_cells(rng, cells)
    separator = str(rng.choice([",", ";", "\t", " ", ", ", "|"]))
    text = str(rng.choice(["\n", "\r\n", "\r"])).join(separator.join(row) for row in cells)
    if rng.random() < 0.2:
        text = "".join(chr(rng.integers(0, 0x500)) if rng.random() < 0.01 else c for c in text)
    if rng.random() < 0.1:
        text = text[: rng.integers(0, len(text) + 1)]
    return str(rng.choice(["", "", "", "\ufeff", "# comment\n", "x" * 300 + "\n", "\n\n"])) + text


def _spoil_cells(rng: np.random.Generator, cells: list[list[str]]) -> None:
    row = int(rng.integers(0, len(cells)))
    column = int(rng.integers(0, max(len(cells[row]), 1)))
    what = int(rng.integers(0, 8))
    if what == 0 and cells[row]:
        cells[row][min(column, len(cells[row]) - 1)] = str(rng.choice(_NUMBERS))
    elif what == 1 and cells[0]:
        cells[0][min(column, len(cells[0]) - 1)] = str(rng.choice(_HEADS))
    elif what == 2:
        word = str(rng.choice(_NUMBERS))
        for other in cells[1:]:
            if column < len(other):
                other[column] = word
    elif what == 3 and len(cells) > 2:
        del cells[row]
    elif what == 4:
        cells.insert(row, list(cells[int(rng.integers(0, len(cells)))]))
    elif what == 5:
        for other in cells:
            if column < len(other):
                del other[column]
    elif what == 6:
        cells[1:] = cells[:0:-1]
    else:
        factor = float(rng.choice([1e-30, 1e30, 1e200, 0.0, -1.0]))
        for other in cells[1:]:
            if column < len(other):
                with np.errstate(all="ignore"):
                    other[column] = f"{factor * _float(other[column]):.9g}"


def _float(text: str) -> float:
    try:
        return float(text)
    except ValueError:
        return 1.0


def campaign_values(rng: np.random.Generator) -> dict[str, Any]:
    """What a campaign file would say, with a table in memory, after up to three accidents."""
    record: dict[str, Any] = {
        "data": arrays(rng) if rng.random() < 0.3 else good_columns(rng),
        "file": "a",
        "start": "rest",
    }
    document: dict[str, Any] = {"title": "t", "record": [record]}
    for _ in range(rng.integers(0, 4)):
        value = _VALUES[int(rng.integers(0, len(_VALUES)))]
        where = int(rng.integers(0, 6))
        if where < 3:
            record[str(rng.choice(_KEYS))] = value
        elif where == 3:
            document[str(rng.choice(["title", "device", "model", "effect", "priors", "defaults", "record", "x"]))] = (
                value
            )
        elif where == 4:
            document["effect"] = {
                str(rng.choice(["cubic-stiffness", "platform", "nothing"])): {"k3": value, "quality": 9.0}
            }
        else:
            document["priors"] = {"platform.quality": {"normal": [value, 1.0], "unit": "1"}}
    return document


def arrays(rng: np.random.Generator) -> Any:
    """Columns in memory after up to three accidents."""
    columns: dict[str, Any] = dict(good_columns(rng, int(rng.choice([0, 1, 19, 20, ROWS, ROWS]))))
    for _ in range(rng.integers(0, 4)):
        name = list(columns)[int(rng.integers(0, len(columns)))] if columns else "t"
        values = np.array(columns.get(name, np.zeros(3)), dtype=object)
        what = int(rng.integers(0, 7))
        if what == 0 and len(values):
            values[int(rng.integers(0, len(values)))] = rng.choice([np.nan, np.inf, 1e308, -1e308, 1e-308])
            columns[name] = values
        elif what == 1:
            columns[str(rng.choice(_HEADS))] = columns.pop(name, values)
        elif what == 2:
            columns[name] = np.full(len(values), float(rng.choice([0.0, 1.0, np.nan, 1e308])))
        elif what == 3:
            columns[name] = values[::-1]
        elif what == 4:
            columns[name] = values[: len(values) // 2]
        elif what == 5:
            columns[name] = [str(value) for value in values]
        else:
            with np.errstate(all="ignore"):
                columns[name] = np.array(values, float) * float(rng.choice([1e-200, 1e-9, 1e9, 1e200]))
    return columns
