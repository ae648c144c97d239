"""What stands above a table, or beside it: the words by which instruments tell units, channels and the sampling."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass

from ...units import plain_micro

_NUMBER = re.compile(r"([+-]?(?:\d+[.,]?\d*|[.,]\d+)(?:[eE][+-]?\d+)?)\s*([^\s\d,;]*)")
_THOUSANDS = re.compile(r"[+-]?\d{1,3}(?:(?:,\d{3}){2,}|(?:,\d{3})+(?=\.\d))(?![\d,])")
"""A number whose commas cannot be decimal ones: there are two of them, or a point behind them."""
_KEY_AND_VALUE = re.compile(r"\s*([^\W\d][^=:]*?)\s*[=:]\s*(\S.*?)\s*")

_STEP = frozenset(
    re.split(
        " ",
        "sampleinterval samplinginterval sampleperiod samplingperiod sampletime samplingtime timeinterval timestep "
        "timeincrement increment deltax deltat xinc xincr xincrement hresolution clock tinc dt ts abtastintervall",
    )
)
_RATE = frozenset(
    re.split(
        " ",
        "samplerate samplingrate samplefrequency samplingfrequency samplingfreq acquisitionrate scanrate rate fs "
        "fsample abtastrate abtastfrequenz",
    )
)
_START = frozenset(re.split(" ", "start x0 xorg xorigin xzero hoffset t0"))
_SECONDS = {"": 1.0, "s": 1.0, "sec": 1.0, "second": 1.0, "seconds": 1.0, "ms": 1e-3, "us": 1e-6, "ns": 1e-9}
_HERTZ = {"": 1.0, "hz": 1.0, "khz": 1e3, "mhz": 1e6, "sps": 1.0, "1/s": 1.0}
_HERTZ |= {f"{prefix}s{a}/s": size for prefix, size in (("", 1.0), ("k", 1e3), ("m", 1e6)) for a in ("", "a")}
_SENSITIVITY = re.compile(r"sensitivity|calibration|scale factor|scaling factor|empfindlichkeit", re.IGNORECASE)


@dataclass(frozen=True)
class Told:
    """Units of time and of the channels, names of the channels; `step` between samples and `start`, s; what is said of
    the `sensitivity` of a sensor, as it stands there."""

    horizontal: str = ""
    vertical: tuple[str, ...] = ()
    sources: tuple[str, ...] = ()
    step: float | None = None
    start: float = 0.0
    sensitivity: str = ""


def preamble_words(rows: Iterable[Sequence[str]]) -> Told:
    """What lines of a key and its values tell.

    Tektronix writes "Horizontal Units", "Vertical Units", "Source" and "Sample Interval", Keysight "X Units" and
    "XInc", LabVIEW "Y_Unit_Label" and "Delta_X", Yokogawa "HResolution", GW Instek "Sampling Period", Moku
    "Acquisition rate", Hantek "#CLOCK=", Owon "Time interval", and Rigol "t0 = …, tInc = …" among the names of columns.
    """
    horizontal, vertical, sources, sensitivity = "", (), (), ""
    step, start = None, 0.0
    for key, values in _pairs(rows):
        if re.fullmatch(r"(horizontal|x|h|time) ?(unit|units)", key):
            horizontal = "s" if values[0] == "S" else values[0]  # no axis is in siemens
        elif re.fullmatch(r"((vertical|y|v) ?)?(unit|units|unit label)", key):
            vertical = tuple(values)
        elif key in ("source", "channel", "trace", "tracename"):
            sources = tuple(values)
        elif _SENSITIVITY.search(key) and re.search(r"\d.*/", values[0]):
            sensitivity = f"{key}: {values[0]}"
        else:
            told = step_of(key, values[0], values[1] if len(values) > 1 else "")
            step = step if told is None else told
            start = _amount(values[0], _SECONDS) or 0.0 if key.replace(" ", "") in _START else start
    return Told(horizontal, vertical, sources, step, start, sensitivity)


def step_of(key: str, value: str, beside: str = "") -> float | None:
    """The time between samples, s, if that is what a key and its value tell, as an interval or as a rate; `beside`: the
    value's unit, where it stands in a cell of its own."""
    name = re.sub(r"[^a-z0-9]", "", key.lower())
    units = _SECONDS if name in _STEP else _HERTZ if name in _RATE else None
    if units is None:
        return None
    with_unit = f"{value} {beside}" if _unit(beside) in units and beside else value
    amount = _amount(with_unit, units)
    if amount is None or not 1e-15 < amount < 1e15:
        return None
    return amount if units is _SECONDS else 1.0 / amount


def _amount(text: str, units: dict[str, float]) -> float | None:
    """A number with one of the units, in the first of them; what follows may be words."""
    plain = _THOUSANDS.sub(lambda found: found[0].replace(",", ""), text.strip(), count=1)
    match = _NUMBER.match(plain)
    if match is None or (size := units.get(_unit(match[2]))) is None:
        return None
    return float(match[1].replace(",", ".")) * size


def _unit(text: str) -> str:
    return plain_micro(text.strip().strip("()[]").lower())


def _pairs(rows: Iterable[Sequence[str]]) -> Iterator[tuple[str, list[str]]]:
    """Keys in small letters with their values, at least one: "Key,value,value" or "Key: value" or "key = value"."""
    for row in rows:
        cells = [cell.strip().strip('"').strip() for cell in row]
        cells = [cell for cell in cells if cell]
        for cell in cells:
            if match := _KEY_AND_VALUE.fullmatch(cell):
                yield _plain(match[1]), [match[2]]
        if len(cells) > 1:
            yield _plain(cells[0]), cells[1:]


def _plain(key: str) -> str:
    return re.sub(r"[ _:=]+", " ", key.lower()).strip()
