"""Tables in binary files: .mat, .h5/.nc, .parquet, .tdms. The libraries for the last four are an extra."""

from __future__ import annotations

import struct
import zipfile
import zlib
from collections.abc import Callable, Iterator
from contextlib import suppress
from pathlib import Path
from typing import Any

import numpy as np

from ...errors import UserError, need
from .opening import check_unfolded
from .preamble import Told, step_of
from .sampling import with_time, without_counter, without_repeats
from .table import Column, Table, split_header, with_unit_row

Pair = tuple[str, np.ndarray, str]
"""Name, values, unit ("" if the file states none)."""


def library(module: str, name: str, extra: str = "files") -> Any:
    """The library that reads a file. **Raises:** UserError that says how to install it."""
    return need(module, "this kind of file", extra, where=name, otherwise="export the record as CSV")


def unreadable(name: str, kind: str, error: Exception) -> UserError:
    """What a reader's own error means to the user."""
    return UserError(f"not a readable {kind} file ({error})"[:200], where=name, do="export the record again, or as CSV")


def _numeric(values: Any) -> np.ndarray | None:
    array = np.asarray(values)
    if array.dtype.kind not in "fiub" or array.size < 2:
        return None
    array = np.squeeze(array)
    return array if array.ndim in (1, 2) else None


def numeric_columns(name: str, values: Any, unit: str = "") -> Iterator[Pair]:
    """An array of numbers as columns; nothing for anything else."""
    array = _numeric(values)
    if array is None:
        return
    if array.ndim == 1:
        yield name, array, unit
        return
    array = array if array.shape[0] >= array.shape[1] else array.T
    for k in range(min(array.shape[1], 50)):
        yield f"{name}:{k + 1}", array[:, k], unit


def _length(name: str, pairs: list[Pair], timed: bool) -> int:
    """The most common length of columns, of equally common ones (three make a record, two if it is `timed` without) the
    longest; the others cannot belong to the record."""
    lengths = [len(values) for _, values, _ in pairs]
    if not lengths:
        raise UserError("no columns of numbers in this file", where=name, do="a record needs time, drive and response")
    return max(set(lengths), key=lambda one: (min(lengths.count(one), 2 if timed else 3), one))


def table_of(name: str, pairs: list[Pair], step: float | None = None) -> Table:
    """The columns of the most common length, with times `step` s apart where none of them holds the time."""
    length = _length(name, pairs, step is not None)
    columns = []
    for header, values, unit in pairs:
        if len(values) == length:
            stem, own, doubtful = split_header(
                header.rsplit("/", 1)[-1] if "/" in header and "(" not in header else header
            )
            column = Column(name, header, stem, own, len(columns) + 1, values.astype(float), (), ".", doubtful)
            columns.append(with_unit_row(column, unit))
    return without_counter(without_repeats(with_time(Table(name, tuple(columns)), Told(step=step))))


def read_mat(path: Path, name: str) -> Table:
    """MATLAB files: scipy up to version 7, h5py for version 7.3."""
    with open(path, "rb") as file:
        head = file.read(520)
    if b"\x89HDF\r\n\x1a\n" in (head[:8], head[512:]):
        return read_hdf(path, name)
    from scipy.io import loadmat
    from scipy.io.matlab import MatReadError

    for count in _mat_promises(path):
        check_unfolded(count, name)
    try:
        content = loadmat(path, squeeze_me=True, struct_as_record=False)
    except (
        MatReadError,
        ValueError,
        TypeError,
        NotImplementedError,
        OSError,
        KeyError,
        IndexError,
        zlib.error,
        struct.error,
        EOFError,
        MemoryError,
        OverflowError,
        AttributeError,
        AssertionError,
    ) as error:
        raise unreadable(name, "MATLAB", error) from None
    pairs: list[Pair] = []
    steps: list[float] = []
    for key, value in content.items():
        if not key.startswith("__"):
            pairs += _mat_value(key, value, 0, steps)
    return table_of(name, pairs, steps[0] if steps else None)


def _mat_promises(path: Path) -> Iterator[int]:
    """Bytes that each compressed variable of a MATLAB 5 file says to unfold to.

    Source: MathWorks, MAT-File Format, "Level 5 MAT-File Format": a tag of type and size before each element, and
    inside an element of type 15, once it is inflated, the same again.
    """
    with open(path, "rb") as file:
        order = "<" if file.read(128)[126:128] == b"IM" else ">"
        while len(tag := file.read(8)) == 8:
            kind, size = struct.unpack(order + "II", tag)
            if kind == 15:
                with suppress(zlib.error, struct.error):
                    inner = zlib.decompressobj().decompress(file.read(min(size, 64)), 8)
                    yield struct.unpack(order + "II", inner)[1]
                file.seek(max(size - 64, 0), 1)
            elif size > 0 and kind >> 16 == 0:
                file.seek(size + -size % 8, 1)


_NAMES = ("Name", "name", "label", "Label", "title")
_UNITS = ("Unit", "unit", "Units", "units")
_VALUES = ("Data", "data", "values", "Values")
"""Fields of a structure that is one signal: dSPACE writes Name, Data and Unit, Simulink label and values."""


def _mat_value(key: str, value: Any, depth: int, steps: list[float]) -> Iterator[Pair]:
    """The columns in a variable, in structures and arrays of structures too; numbers that tell the time between samples
    ("Fs", "Ts") go to `steps`."""
    fields = getattr(value, "_fieldnames", None)
    if fields is not None and depth < 5:
        values = next((getattr(value, one) for one in _VALUES if one in fields), None)
        if _numeric(values) is not None:
            name = next((text for one in _NAMES if (text := _words(value, one))), key)
            unit = next((text for one in _UNITS if (text := _words(value, one))), "")
            yield from numeric_columns(name, values, unit)
        for one in fields:
            if one not in _VALUES or _numeric(values) is None:
                yield from _mat_value(one, getattr(value, one), depth + 1, steps)
    elif isinstance(value, np.ndarray) and value.dtype == object and value.size < 1000 and depth < 5:
        for k, one in enumerate(value.ravel(), 1):
            yield from _mat_value(f"{key}:{k}", one, depth + 1, steps)
    elif isinstance(value, np.ndarray):
        yield from numeric_columns(key, value)
    elif isinstance(value, (int, float, np.number)) and (step := step_of(key, repr(float(value)))) is not None:  # type: ignore[arg-type]
        steps.append(step)


def _words(structure: Any, field: str) -> str:
    text = getattr(structure, field, "")
    return text.strip() if isinstance(text, str) else ""


def read_hdf(path: Path, name: str) -> Table:
    """HDF5 and netCDF-4: every data set of numbers, with its "units" attribute."""
    h5py = library("h5py", name)
    pairs: list[Pair] = []
    promised = [0]

    def visit(key: str, item: Any) -> None:
        if isinstance(item, h5py.Dataset) and not key.startswith("#"):
            unit = item.attrs.get("units", item.attrs.get("unit", ""))
            unit = unit.decode("utf-8", "replace") if isinstance(unit, bytes) else unit
            promised[0] += int(item.size or 0) * item.dtype.itemsize
            check_unfolded(promised[0], name)
            pairs.extend(numeric_columns(key, item[()], unit if isinstance(unit, str) else ""))

    try:
        with h5py.File(path, "r") as file:
            file.visititems(visit)
    except (OSError, RuntimeError, KeyError, ValueError, TypeError) as error:
        raise unreadable(name, "HDF5", error) from None
    return table_of(name, pairs)


def read_parquet(path: Path, name: str) -> Table:
    """Apache Parquet, by pyarrow; a field's metadata may hold its "unit"."""
    parquet, arrow = library("pyarrow.parquet", name), library("pyarrow", name)
    try:
        told = parquet.read_metadata(path)
        check_unfolded(8 * told.num_rows * told.num_columns, name)
        content = parquet.read_table(path)
        pairs: list[Pair] = []
        for index, header in enumerate(content.column_names):
            metadata = content.schema.field(index).metadata or {}
            unit = metadata.get(b"unit", metadata.get(b"units", b"")).decode("utf-8", "replace")
            pairs += numeric_columns(header, content.column(index).to_numpy(), unit)
    except (arrow.ArrowException, OSError, ValueError, TypeError, NotImplementedError) as error:
        raise unreadable(name, "Parquet", error) from None
    return table_of(name, pairs)


def read_tdms(path: Path, name: str) -> Table:
    """LabVIEW TDMS, by npTDMS; time from the waveform properties where there is no time channel."""
    nptdms = library("nptdms", name)
    pairs: list[Pair] = []
    increments: list[Any] = []
    try:
        told = nptdms.TdmsFile.read_metadata(path)
        if any(len(channel) > path.stat().st_size for group in told.groups() for channel in group.channels()):
            raise ValueError("it promises more values than it has bytes")
        for group in nptdms.TdmsFile.read(path).groups():
            for channel in group.channels():
                properties = channel.properties
                unit = properties.get("unit_string", properties.get("NI_UnitDescription", ""))
                pairs += numeric_columns(channel.name, channel[:], unit if isinstance(unit, str) else "")
                increments += [properties.get("wf_increment")] * (len(pairs) - len(increments))
    except (
        OSError,
        ValueError,
        TypeError,
        KeyError,
        IndexError,
        EOFError,
        AttributeError,
        OverflowError,
        MemoryError,
        NotImplementedError,
        zipfile.BadZipFile,
        AssertionError,
        struct.error,
    ) as error:
        raise unreadable(name, "TDMS", error) from None
    length = _length(name, pairs, any(increments))  # slower channels have an increment of their own
    steps = [step for step, (_, values, _) in zip(increments, pairs, strict=True) if step and len(values) == length]
    return table_of(name, pairs, float(steps[0]) if steps else None)


READERS: dict[str, Callable[[Path, str], Table]] = {
    ".mat": read_mat,
    ".h5": read_hdf,
    ".hdf5": read_hdf,
    ".nc": read_hdf,
    ".parquet": read_parquet,
    ".tdms": read_tdms,
}
