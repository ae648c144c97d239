"""Files as instruments store them: oscilloscopes (RigolWFM), modal analysers (pyuff), and arrays of NumPy.

RigolWFM reads Rigol, Tektronix (.wfm, .isf), LeCroy (.trc), Keysight (.bin), Siglent, Rohde & Schwarz and Yokogawa;
pyuff the data sets 58 of universal files. Both are optional.
"""

from __future__ import annotations

import zipfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from .binary import Pair, library, numeric_columns, table_of, unreadable
from .opening import check_unfolded
from .table import Table

_UNITS = {"v": "V", "a": "A", "s": "s", "volts": "V", "amps": "A"}
_QUANTITIES = {8: "m", 11: "m/s", 12: "m/s^2", 9: "N", 13: "N"}
"""Ordinates of a data set 58 that have a unit of their own (SI): displacement, velocity, acceleration, forces."""


def read_scope(path: Path, name: str) -> Table:
    """The waveform file of an oscilloscope: time, and a column "CH1", "CH2", … for each channel that was on."""
    scope = library("RigolWFM.wfm", name, "instruments")
    try:
        channels = [
            c for c in scope.Wfm.from_file(str(path)).channels if c.volts is not None and c.enabled_and_selected
        ]
    except Exception as error:  # a reader of thirty formats meets broken files in as many ways
        raise unreadable(name, "oscilloscope", error) from None
    pairs: list[Pair] = []
    for channel in channels:
        if not pairs:
            pairs.append(("time", np.asarray(channel.times, dtype=float), "s"))
        unit = getattr(channel.unit, "name", str(channel.unit)).strip().lower()
        pairs.append(
            (str(channel.name or f"CH{channel.channel_number}"), np.asarray(channel.volts), _UNITS.get(unit, "V"))
        )
    return table_of(name, pairs)


def read_universal(path: Path, name: str) -> Table:
    """A universal file: the responses over time of its data sets 58, by their names, on the time of the first."""
    pyuff = library("pyuff", name, "instruments")
    try:
        found = pyuff.UFF(str(path)).read_sets()
    except Exception as error:  # as above
        raise unreadable(name, "universal", error) from None
    pairs: list[Pair] = []
    for one in found if isinstance(found, list) else [found]:
        if one.get("type") != 58 or one.get("func_type") not in (0, 1) or np.iscomplexobj(one["data"]):
            continue
        if not pairs:
            pairs.append(("time", np.asarray(one["x"], dtype=float), "s"))
        pairs.append((_set_name(one, len(pairs)), np.asarray(one["data"], dtype=float), _set_unit(one)))
    return table_of(name, pairs)


def _set_name(one: dict[str, Any], number: int) -> str:
    words = [str(one.get(key, "") or "").strip() for key in ("id1", "rsp_ent_name")]
    return next((word for word in words if word and word.upper() != "NONE"), f"channel {number}")


def _set_unit(one: dict[str, Any]) -> str:
    told = str(one.get("ordinate_axis_units_lab", "") or "").strip()
    return (
        told if told and told.upper() != "NONE" else _QUANTITIES.get(int(one.get("ordinate_spec_data_type") or 0), "")
    )


def read_numpy(path: Path, name: str) -> Table:
    """The arrays of an .npz file by their names, or the columns of an .npy file; never a pickle."""
    try:
        if path.suffix.lower() == ".npz":
            with zipfile.ZipFile(path) as archive:
                check_unfolded(sum(member.file_size for member in archive.infolist()), name)
        with open(path, "rb") as file:
            content = np.load(file, allow_pickle=False)
            arrays = dict(content.items()) if isinstance(content, np.lib.npyio.NpzFile) else {"column": content}
    except (
        OSError,
        ValueError,
        EOFError,
        KeyError,
        zipfile.BadZipFile,
        MemoryError,
        SyntaxError,
        AssertionError,
        TypeError,
        OverflowError,
        RuntimeError,
    ) as error:
        raise unreadable(name, "NumPy", error) from None
    return table_of(name, [pair for key, values in arrays.items() for pair in numeric_columns(key, values)])


INSTRUMENT_READERS: dict[str, Callable[[Path, str], Table]] = {
    ".npz": read_numpy,
    ".npy": read_numpy,
    ".uff": read_universal,
    ".unv": read_universal,
    ".wfm": read_scope,
    ".isf": read_scope,
    ".trc": read_scope,
    ".bin": read_scope,
}
