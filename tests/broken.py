"""Campaigns and CSVs that cannot be used, each for one reason: `(name, writer(folder) -> path of the campaign)`.

`SAYS[name]` holds words that the one line of the error must contain (place and matter).
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np

Writer = Callable[[Path], Path]
HEADER = "time (s),drive (V),z (um)"
SAYS: dict[str, tuple[str, ...]] = {}
_CASES: list[tuple[str, Writer]] = []


def broken() -> Iterator[tuple[str, Writer]]:
    """Every unusable campaign, by name."""
    yield from _CASES


def signals(n: int = 400) -> np.ndarray:
    """(n, 3) time, drive and response of a healthy record: 40 samples per period, a little noise."""
    time = np.arange(n) * 5e-5
    drive = 8 * np.sin(2 * np.pi * 500 * time)
    response = 3 * np.sin(2 * np.pi * 500 * time - 1) + 0.01 * np.random.default_rng(1).standard_normal(n)
    return np.column_stack([time, drive, response])


def csv_text(header: str = HEADER, values: np.ndarray | None = None, separator: str = ",") -> str:
    """A healthy CSV."""
    values = signals() if values is None else values
    return "\n".join([header, *(separator.join(f"{value:.7g}" for value in row) for row in values)]) + "\n"


def campaign_text(record: str = "", rest: str = "", file: str = "a.csv") -> str:
    """A healthy campaign of one record, with more lines in the record and after it."""
    return f'title = "t"\n[[record]]\nfile = "{file}"\nkind = "trace"\n{record}\n{rest}\n'


def _put(folder: Path, name: str, content: str | bytes) -> Path:
    path = folder / name
    path.write_bytes(content.encode() if isinstance(content, str) else content)
    return path


def _data(name: str, content: str | bytes, *says: str, file: str = "a.csv") -> None:
    """A data file that is broken, read through a healthy campaign."""

    def write(folder: Path) -> Path:
        _put(folder, file, content)
        return _put(folder, "campaign.toml", campaign_text(file=file))

    SAYS[name] = (file, *says)
    _CASES.append((name, write))


def _toml(name: str, content: str | bytes, *says: str, **more: str) -> None:
    """A campaign file that is broken, beside a healthy CSV."""

    def write(folder: Path) -> Path:
        _put(folder, "a.csv", csv_text())
        for file, text in more.items():
            _put(folder, file.replace("_toml", ".toml"), text)
        return _put(folder, "campaign.toml", content)

    SAYS[name] = says
    _CASES.append((name, write))


def _changed(row: int, column: int, value: float) -> np.ndarray:
    values = signals()
    values[row, column] = value
    return values


def _column(column: int, values: np.ndarray) -> np.ndarray:
    table = signals()
    table[:, column] = values
    return table


_rows = csv_text().split("\n")


def _with_row(index: int, row: str) -> str:
    return "\n".join([*_rows[:index], row, *_rows[index + 1 :]])


_HALF = np.where(np.arange(len(signals())) < 300, np.nan, signals()[:, 2])


# --- data files ---------------------------------------------------------------------------------------------------
_data("empty file", "", "empty")
_data("only blank lines", "\n\n  \n", "empty")
_data("only a header", HEADER + "\n", "no table")
_data("prose", "Dear colleague,\nthe data are on the other disk.\nRegards\n", "no ")
_data("binary", bytes(range(256)) * 20)
_data("utf-16 without mark", csv_text().encode("utf-16-le"), "not a text file")
_data("text in a cell", _with_row(7, "0.0003,3.1,oops"), "line 8", "column 3", "oops")
_data("nan in time", _with_row(9, "nan,1.0,0.1"), "line 10", "column 1", "nan")
_data("no number in the response", csv_text(values=_column(2, np.full(len(signals()), np.nan))), "line 2", "column 3")
_data("no number in half of the response", csv_text(values=_column(2, _HALF)), "line 2", "column 3", "nan")
_data("short row", _with_row(12, "0.00055,1.0"), "line 13", "2 columns")
_data("long row", _with_row(12, "0.00055,1.0,2.0,3.0"), "line 13", "4 columns")
_data("cut off", csv_text()[:-14], "line 401")
_data("too short", csv_text(values=signals(12)), "too few")
_data("time runs backwards", csv_text(values=_changed(50, 0, 1e-3)), "line 52", "backwards")
_data("time repeats", _with_row(52, _rows[51]), "line 53", "repeats")
_data("two runs in one file", csv_text(values=np.vstack([signals(), signals()])), "backwards", "line 402")
_often = [row for k in range(25, 390, 36) for row in range(k, k + 12)]  # longer than a quarter of a period
_data("gaps again and again", csv_text(values=np.delete(signals(), _often, axis=0)), "gap", "10 more", "line 27")
_jitter = np.random.default_rng(0).uniform(-0.4, 0.4, 400) * 5e-5
_data("jitter", csv_text(values=_column(0, signals()[:, 0] + _jitter)), "not uniform", "resample")
_data("constant time", csv_text(values=_column(0, np.ones(400))), "time repeats")
_data("constant response", csv_text(values=_column(2, np.full(400, 1.25))), "never changes")
_data(
    "drive of two samples per period",
    csv_text(values=_column(1, 8 * np.cos(3.0 * np.arange(400)))),
    "samples per period",
)
_data("response in kg", csv_text("time (s),drive (V),z (kg)"), "column 3", "kg")
_data("time in volts", csv_text("time (V),drive (V),z (um)"), "column 1", "time")
_data("drive in newton", csv_text("time (s),drive (N),z (um)"), "column 2", "drive")
_data("unit misspelt", csv_text("time (s),drive (V),z (umm)"), "umm", "column 3")
_data("no unit, metres impossible", csv_text("t,u,z"), "cannot be right", "units")
_data("metres instead of micrometres", csv_text("time (s),drive (V),z (m)"), "cannot be right")
_data("kilovolts instead of volts", csv_text("time (s),drive (kV),z (um)"), "cannot be right")
_data("hours instead of seconds", csv_text("time (h),drive (V),z (um)", _column(0, np.arange(400))), "cannot be right")
_data("volts for a platform", csv_text("t_s,u_V,y_V"), "response", "oscillator")
_data("ambiguous channels", csv_text("time (s),CH1 (V),CH2 (V)"), "CH1", "columns = {")
_data(
    "two responses",
    csv_text("time (s),drive (V),z1 (um),z2 (um)", np.c_[signals(), signals()[:, 2]]),
    "z1",
    "columns = {",
)
_data("channels without names", csv_text("t,CH1,CH2"), "CH1", "columns = { time =")
_data("no header", csv_text("").lstrip("\n"), "columns")
_data("no time column", csv_text("drive (V),z (um)", signals()[:, 1:]), "2 columns")
_data("one column", csv_text("z (um)", signals()[:, 2:]), "1 column")
_data("sweep called trace", csv_text("frequency (Hz),drive (V),amplitude (um)"), "time")
_data("broken mat", b"MATLAB 5.0 MAT-file" + bytes(200), "MATLAB", file="a.mat")
_data("text called h5", csv_text(), "HDF5", file="a.h5")
_data("text called parquet", csv_text(), "Parquet", file="a.parquet")
_data("text called tdms", csv_text(), "TDMS", file="a.tdms")

# --- campaign files -----------------------------------------------------------------------------------------------
_toml("toml syntax", 'title = "t"\n[[record]\nfile = "a.csv"\n', "campaign.toml, line 2", "TOML")
_toml("toml open quote", 'title = "t\n', "campaign.toml, line 1")
_toml("toml twice", "title = 'a'\ntitle = 'b'\n", "campaign.toml", "TOML")
_toml("toml binary", b"\x00\x01\x02", "campaign.toml")
_toml("toml empty", "", "campaign.toml", "no records")
_toml("no records", 'title = "t"\n', "no records")
_toml("title is a number", "title = 3\n" + campaign_text()[12:], "line 1", "title")
_toml("unknown key", "titel = 't'\n" + campaign_text()[12:], "line 1", "titel", "title")
_toml("unknown record key", campaign_text("hold_out = true"), "line 5", "hold_out", "holdout")
_toml("unknown model key", campaign_text(rest='[model]\neffect = ["a"]'), "line 7", "effects")
_toml("record is a table", 'record = { file = "a.csv" }\n', "record")
_toml("record without file", '[[record]]\nkind = "trace"\n', "line 1", "file")
_toml("missing file", campaign_text().replace("a.csv", "b.csv"), "line 3", "b.csv")
_toml("file is a folder", campaign_text(file="."), "line 3")
_toml("unknown kind", campaign_text().replace('"trace"', '"tracee"'), "line 4", "trace")
_toml("unknown start", campaign_text('start = "resting"'), "line 5", "rest")
_toml("holdout is a word", campaign_text('holdout = "yes"'), "line 5", "true or false")
_toml("load without unit", campaign_text('load = "40"'), "line 5", "unit")
_toml("load is a number", campaign_text("load = 40"), "line 5", "load")
_toml("load in volts", campaign_text('load = "40 V"'), "line 5", "mass")
_toml("load negative", campaign_text('load = "-40 mg"'), "line 5", "load")
_toml("load in kilograms", campaign_text('load = "40 kg"'), "line 5", "load")
_toml("noise nonsense", campaign_text('noise = "small"'), "line 5", "small")
_toml("noise zero", campaign_text('noise = "0 nm"'), "line 5", "positive")
_toml("noise in volts", campaign_text('noise = "12 mV"'), "line 5", "length")
_toml("skip negative", campaign_text("skip = -5"), "line 5", "negative")
_toml("skip too long", campaign_text('skip = "1 s"'), "skip")
_toml("skip is a fraction", campaign_text("skip = 0.5"), "line 5", "skip")
_toml("columns nonsense", campaign_text('columns = "a"'), "line 5", "columns")
_toml("columns unknown role", campaign_text('columns = { tiem = "t" }'), "line 5", "tiem", "time")
_toml("columns not in file", campaign_text('columns = { drive = "CH9" }'), "CH9", "drive (V)")
_toml("columns twice", campaign_text('columns = { drive = "z", response = "z" }'), "line 5", "twice")
_toml("units unknown", campaign_text('units = { response = "umm" }'), "line 5", "umm")
_toml("units of nothing", campaign_text('units = { velocity = "um" }'), "velocity")
_toml("units of the wrong kind", campaign_text('units = { response = "s" }'), "response")
_toml("direction in a trace", campaign_text('direction = "up"'), "line 5", "sweep")
_toml("quantity unknown", campaign_text('quantity = "peak"'), "line 5", "fundamental")
_toml("effects is a text", campaign_text(rest='[model]\neffects = "cubic-stiffness"'), "line 7", "effects")
_toml("effect file missing", campaign_text(rest='[model]\neffect_files = ["my.py"]'), "line 7", "my.py")
_toml("effect is a number", campaign_text(rest="[effect]\ncreep = 3"), "line 7", "creep")
_toml("effect unit", campaign_text(rest='[effect.creep]\ntime = "3 parsnips"'), "line 7", "parsnips")
_toml("effect value nan", campaign_text(rest="[effect.creep]\ntime = nan"), "line 7", "time")
_toml("effect value date", campaign_text(rest="[effect.creep]\ntime = 2026-01-01"), "line 7", "time")
_toml("prior is a number", campaign_text(rest='[priors]\n"a.b" = 3'), "line 7", "normal")
_toml("prior of one number", campaign_text(rest='[priors]\n"a.b" = { normal = [80] }'), "line 7", "deviation")
_toml("prior without width", campaign_text(rest='[priors]\n"a.b" = { normal = [80, 0] }'), "line 7", "positive")
_toml("prior of a strange unit", campaign_text(rest='[priors]\n"a.b" = { normal = [8, 1], unit = "MPx" }'), "MPx")
_toml("prior of an unknown law", campaign_text(rest='[priors]\n"a.b" = { uniform = [8, 1] }'), "uniform")
_toml("device missing", 'device = "d.toml"\n' + campaign_text()[12:], "line 1", "d.toml")
_toml("device is a number", "device = 3\n" + campaign_text()[12:], "line 1", "device")
_toml("device kind", 'device = { kind = "plate" }\n' + campaign_text()[12:], "line 1", "platform")
_toml("device output", 'device = { kind = "oscillator", output = "" }\n' + campaign_text()[12:], "output")
_DEVICE = 'device = "d.toml"\n' + campaign_text()[12:]
_toml("device unknown key", _DEVICE, "d.toml, line 1", "width", d_toml='widht = "1 mm"\n')
_toml("device in metres", _DEVICE, "d.toml, line 2", "cannot be right", d_toml='kind = "platform"\nwidth = 30\n')
_toml("device wrong unit", _DEVICE, "d.toml, line 1", "length", d_toml='width = "3 V"\n')
_toml("device negative", _DEVICE, "d.toml, line 1", "cannot be right", d_toml='stage_mass = "-60 mg"\n')
_toml("device closed wrongly", _DEVICE, "d.toml, line 1", "yaw", d_toml='in_plane = "clammed"\n')
_toml("device beam end", _DEVICE, "d.toml, line 1", "pair", d_toml='beam_end = "1 mm"\n')
_toml("device syntax", _DEVICE, "d.toml, line 1", "TOML", d_toml="width = 1 mm\n")
_OSCILLATOR = 'device = { kind = "oscillator", output = "V" }\n'
_toml("oscillator with load", _OSCILLATOR + campaign_text('load = "40 mg"')[12:], "load")
_toml("oscillator with lengths", _OSCILLATOR + campaign_text()[12:], "a.csv", "column 3")


def _missing_folder(folder: Path) -> Path:
    return folder / "nowhere"


def _empty_folder(folder: Path) -> Path:
    return folder


def _sweep(text: str, record: str = "") -> Writer:
    def write(folder: Path) -> Path:
        _put(folder, "s.csv", text)
        return _put(folder, "campaign.toml", f'[[record]]\nfile = "s.csv"\nkind = "sweep"\n{record}\n')

    return write


_points = np.column_stack([np.linspace(450, 550, 40), np.full(40, 3.0), np.linspace(1, 5, 40)])
_SWEEP = "frequency (Hz),drive (V),amplitude (um)"
for _name, _writer, _words in (
    ("missing path", _missing_folder, ("nowhere", "no such")),
    ("folder without campaign", _empty_folder, ("campaign.toml",)),
    ("sweep without level", _sweep(csv_text("f (Hz),amplitude (um)", _points[:, [0, 2]])), ("s.csv", "level")),
    ("sweep of negative amplitude", _sweep(csv_text(_SWEEP, _points * [1, 1, -1])), ("s.csv", "line 2", "negative")),
    ("sweep at zero frequency", _sweep(csv_text(_SWEEP, _points * [0, 1, 1])), ("s.csv", "line 2", "positive")),
    ("sweep of two points", _sweep(csv_text(_SWEEP, _points[:3])), ("s.csv", "too few")),
    ("sweep with a start", _sweep(csv_text(_SWEEP, _points), 'start = "rest"'), ("line 4", "trace")),
    ("sweep in strange direction", _sweep(csv_text(_SWEEP, _points), 'direction = "sideways"'), ("sideways",)),
    ("sweep in decibels", _sweep(csv_text("f (Hz),drive (V),amplitude (dBq)", _points)), ("s.csv", "dBq")),
):
    _CASES.append((_name, _writer))
    SAYS[_name] = _words
