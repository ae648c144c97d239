"""Records that are arrays already: a DataFrame, a mapping of columns, or an (n, 3) array, as a campaign's document."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from ..errors import UserError, nearest
from .tables.table import Column, Table, split_header

_DO = 'give a DataFrame, or a mapping of columns: {"time (s)": t, "drive (V)": u, "displacement (um)": y}'
_PLAIN = ("time", "drive", "response")


def is_path(data: Any) -> bool:
    """Whether something names a file or folder, or several."""
    if isinstance(data, (list, tuple)):
        return all(is_path(one) for one in data)
    return isinstance(data, (str, os.PathLike))


def document_of(data: Any, columns: Mapping[str, str | int] | None, told: Mapping[str, Any]) -> dict[str, Any]:
    """What a campaign file would say of records in memory, whose tables stand under "data".

    **Arguments:** `data`: one record, a list of them, a mapping of them by name, or such a document; `told`: its
    `device` and `title`, the names that are `holdout`, and what `[defaults]` may say.
    """
    own = dict(told) | ({"columns": dict(columns)} if columns else {})
    held = own.pop("holdout", ())
    outer = {key: own.pop(key) for key in ("device", "title") if key in own}
    if _is_document(data):
        records = [_with_table(record, f"record {k}") for k, record in enumerate(data["record"], 1)]
        common = data.get("defaults", {})
        common = {**common, **own} if isinstance(common, Mapping) else common
        return {**data, **outer, "record": _held_out(records, held), "defaults": common}
    records = [{"file": table.name, "data": table} for table in tables_of(data)]
    title = ", ".join(Path(record["file"]).stem for record in records)
    return {"title": title, **outer, "record": _held_out(records, held), "defaults": own}


def _held_out(records: list[Any], held: Any) -> list[Any]:
    """The records, those of some names held out, or all. **Raises:** UserError for a name that none has."""
    names = [str(record.get("file", "")) for record in records]
    held = names if held is True else [held] if isinstance(held, str) else list(held or ())
    for name in held:
        if name not in names:
            do = nearest(name, names, f"the records are {', '.join(names)}")
            raise UserError(f"there is no record {name!r} to hold out", do=do)
    return [
        {**record, "holdout": True} if name in held else record for name, record in zip(names, records, strict=True)
    ]


def _is_document(data: Any) -> bool:
    records = data.get("record") if isinstance(data, Mapping) else None
    return isinstance(records, (list, tuple)) and all(isinstance(one, Mapping) for one in records)


def _with_table(record: Any, name: str) -> Any:
    if not isinstance(record, Mapping) or "data" not in record:
        return record
    name = str(record.get("file", name))
    return {**record, "file": name, "data": table_of(record["data"], name)}


def tables_of(data: Any) -> list[Table]:
    """The table of every record."""
    if isinstance(data, (list, tuple)) and data and all(isinstance(one, Table) or _is_record(one) for one in data):
        return [one if isinstance(one, Table) else table_of(one, f"record {k}") for k, one in enumerate(data, 1)]
    if isinstance(data, Mapping) and data and all(_is_record(one) for one in data.values()):
        return [table_of(one, str(name)) for name, one in data.items()]
    return [table_of(data, "record")]


def _is_record(data: Any) -> bool:
    return _is_frame(data) or isinstance(data, Mapping) or (isinstance(data, np.ndarray) and data.ndim == 2)


def _is_frame(data: Any) -> bool:
    return hasattr(data, "columns") and hasattr(data, "iloc")


def table_of(data: Any, name: str) -> Table:
    """One record as a table; headers may state units, as in a file. **Raises:** UserError if it is none."""
    if isinstance(data, Table):
        return data
    if _is_frame(data):
        frame = data.reset_index() if data.index.name is not None else data
        named: list[tuple[Any, Any]] = [(header, frame.iloc[:, k]) for k, header in enumerate(frame.columns)]
    elif isinstance(data, Mapping):
        named = list(data.items())
    elif isinstance(data, np.ndarray) and data.dtype.names:
        named = [(header, data[header]) for header in data.dtype.names]
    elif isinstance(data, np.ndarray) and data.ndim == 2 and data.shape[1] in (2, 3):
        headers = _PLAIN if data.shape[1] == 3 else (_PLAIN[0], _PLAIN[2])
        named = list(zip(headers, data.T, strict=True))
    else:
        raise UserError(f"a {type(data).__name__} is no record", where=name, do=_DO)
    columns = tuple(_column(name, str(header), values, k) for k, (header, values) in enumerate(named, 1))
    lengths = {len(column.cells) for column in columns}
    if len(lengths) != 1:
        what = f"its columns have {', '.join(str(n) for n in sorted(lengths)) or 'no'} samples"
        raise UserError(what, where=name, do="give columns of one length" if lengths else _DO)
    return Table(name, columns)


def _column(name: str, header: str, values: Sequence[Any] | np.ndarray, position: int) -> Column:
    stem, unit, doubtful = split_header(header)
    try:
        complex_ones = np.iscomplexobj(np.asarray(values))
        cells = np.zeros((0, 0)) if complex_ones else np.array(values, dtype=float)
    except (TypeError, ValueError, OverflowError):
        cells = np.zeros((0, 0))
    if cells.ndim != 1:
        raise UserError("this is no column of numbers", where=f'{name}, column {position} ("{header}")', do=_DO)
    return Column(name, header, stem, unit, position, cells, doubtful=doubtful)
