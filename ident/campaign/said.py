"""What a campaign file says that decides the result of a fit, apart from how it is written.

A comment, another order, a quantity in another unit or a default that is written out change nothing here; nor do a
title, and the effects to start with, which a run has of its own.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping, Sequence
from dataclasses import MISSING, dataclass, fields, is_dataclass
from pathlib import Path
from typing import Any

from .device import Device
from .spec import RecordSpec

_PLACES = ("path", "where", "table")  # of a record: where it lies is not what is said of it


@dataclass(frozen=True)
class Said:
    """Fingerprints of what is said: `records` by name, in order; the `device`; the linear part of the `model`; and the
    names of the `data` files, whose content has checksums."""

    records: tuple[tuple[str, str], ...]
    device: str
    model: str
    data: tuple[str, ...]

    @classmethod
    def of(cls, specs: Sequence[RecordSpec], device: Device, model: Any, data: Sequence[str], folder: Path) -> Said:
        """The fingerprints of what was read."""
        records = tuple((spec.name, fingerprint(_plain(spec, folder))) for spec in specs)
        return cls(records, fingerprint(_plain(device, folder)), fingerprint(model), tuple(data))


def fingerprint(value: Any) -> str:
    """A checksum of plain values: tables in any order, numbers to twelve digits."""
    text = json.dumps(_rounded(value), sort_keys=True, ensure_ascii=True)
    return hashlib.sha256(text.encode()).hexdigest()[:16]


def _plain(value: Any, folder: Path) -> Any:
    """A dataclass as a table without its defaults, so that a key that a later version adds changes nothing."""
    if isinstance(value, Path):
        return value.relative_to(folder).as_posix() if value.is_relative_to(folder) else value.as_posix()
    if not is_dataclass(value) or isinstance(value, type):
        return {k: _plain(v, folder) for k, v in value.items()} if isinstance(value, Mapping) else value
    table: dict[str, Any] = {"": type(value).__name__}
    for field in fields(value):
        own = getattr(value, field.name)
        default = field.default if field.default_factory is MISSING else field.default_factory()
        if field.name not in _PLACES and own != default:
            table[field.name] = _plain(own, folder)
    return table


def _rounded(value: Any) -> Any:
    if isinstance(value, Mapping):
        return {str(key): _rounded(one) for key, one in value.items()}
    if isinstance(value, (list, tuple)):
        return [_rounded(one) for one in value]
    if isinstance(value, (int, float)) and not isinstance(value, bool):
        return f"{value:.12g}"
    return value
