"""What a model says that the sensor shows, as a CSV file whose columns carry their units."""

from __future__ import annotations

import os
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from ..campaign.device import Device, Oscillator
from ..campaign.record import Trace
from ..errors import UserError
from .new_folder import write_whole

PathLike = str | os.PathLike[str]


def write_model_csv(
    records: Sequence[Trace], readings: Sequence[np.ndarray], device: Device, path: PathLike, *, force: bool = False
) -> Path:
    """Write time, drive and model reading of every record; several records are told apart by a first column.

    Values are in the units of the first record's file, with nine significant digits.

    **Arguments:** `readings`: per record (n,) m; `force`: replace a file that exists.

    **Raises:** UserError if the file exists or cannot be written.
    """
    target = Path(path)
    if target.exists() and not force:
        raise UserError("this exists already", where=str(target), do="choose another name, or --force to replace it")
    drive, response = records[0].drive_channel, records[0].response_channel
    word = "response" if isinstance(device, Oscillator) else "displacement"
    head = ["record"] if len(records) > 1 else []
    head += ["time (s)", f"drive ({drive.unit})", f"{word} ({response.unit})"]
    lines = [",".join(head)]
    for record, reading in zip(records, readings, strict=True):
        first = [_quoted(record.name)] if len(records) > 1 else []
        time = np.where(np.abs(record.time) < 1e-6 * record.step, 0.0, record.time)  # zero to the last digit
        columns = (time, record.drive / drive.factor, reading / response.factor)
        lines += [",".join([*first, *(f"{x:.9g}" for x in row)]) for row in zip(*columns, strict=True)]
    try:
        target.parent.mkdir(parents=True, exist_ok=True)
        write_whole(target, "\n".join(lines) + "\n")
    except OSError as error:
        raise UserError(error.strerror or "cannot be written", where=str(target), do="choose another file") from None
    return target


def _quoted(text: str) -> str:
    return '"' + text.replace('"', '""') + '"' if any(mark in text for mark in ',"\n;') else text
