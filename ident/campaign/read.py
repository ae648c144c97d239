"""Reading a campaign: the TOML file with its records, a folder that holds one, or data files alone."""

from __future__ import annotations

import hashlib
import math
import os
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from types import MappingProxyType
from typing import Any

from ident.errors import UserError
from ident.units import looks_like_quantity, parse_quantity, to_si

from .binary_table import READERS
from .campaign import Campaign, Prior
from .device import Oscillator, Platform
from .device_file import of_displacement, read_device
from .document import Section, read_document, record_sections, shown
from .guess import guess_device, renamed
from .instrument_files import INSTRUMENT_READERS
from .load import load_record, read_table
from .noise_pool import pooled
from .opening import MOST_TEXT, check_file, exists
from .record import Record, Trace
from .spec import RecordSpec, parse_record

PathLike = str | os.PathLike[str]

DATA_SUFFIXES = (".csv", ".txt", ".tsv", ".dat", ".asc", ".lvm", *READERS, *INSTRUMENT_READERS)


def read_campaign(path: PathLike | Sequence[PathLike], columns: Mapping[str, str | int] | None = None) -> Campaign:
    """The campaign in a TOML file, in a folder with a `campaign.toml`, or in one or more data files.

    `columns` says for data files which column is which ({"drive": "CH1"}); a campaign says so itself.

    All numbers of the result are SI. What was assumed, and what the data checks found, is in `Campaign.notes`.
    Anything unusable raises one `UserError` that says where it is and what to do.
    """
    paths = [Path(path)] if isinstance(path, (str, os.PathLike)) else [Path(one) for one in path]
    if not paths:
        raise UserError("no campaign given", do="name a campaign.toml, a folder that holds one, or CSV files")
    for one in paths:
        if "\0" in str(one) or not exists(one):
            raise UserError("there is no such file or folder", where=str(one), do="correct the path")
    try:
        if len(paths) == 1 and paths[0].is_dir():
            return _from_toml(_in_folder(paths[0]), columns)
        if len(paths) == 1 and paths[0].suffix.lower() == ".toml":
            return _from_toml(paths[0], columns)
        return _from_files(paths, columns or {})
    except OSError as error:
        where = str(error.filename or paths[0])
        raise UserError(error.strerror or "cannot be read", where=where, do="check that the file can be read") from None


def _in_folder(folder: Path) -> Path:
    path = folder / "campaign.toml"
    if path.exists():
        return path
    data = sorted(one.name for one in folder.iterdir() if one.suffix.lower() in DATA_SUFFIXES)
    do = f"add one, or name the data files themselves ({', '.join(data[:3])})" if data else "name another folder"
    raise UserError("the folder has no campaign.toml", where=str(folder), do=do)


def _from_files(paths: list[Path], columns: Mapping[str, str | int]) -> Campaign:
    for path in paths:
        if path.is_dir() or path.suffix.lower() == ".toml":
            what = f"a {'folder' if path.is_dir() else 'campaign file'} cannot be mixed with data files"
            raise UserError(what, where=str(path), do="name either one campaign or data files only")
        check_file(path, path.name)
    tables = [read_table(path, path.name) for path in paths]
    device, notes = guess_device([renamed(table, columns) for table in tables])
    device, measures, rate = of_displacement(device)
    notes += rate
    records: list[Record] = []
    for path, table in zip(paths, tables, strict=True):
        record, found = load_record(
            RecordSpec(file=path.name, path=path, columns=columns, measures=measures), table, device
        )
        records.append(record)
        notes += found
    return Campaign(
        title=", ".join(path.stem for path in paths),
        records=_with_common_noise(records),
        device=device,
        notes=tuple(notes),
        checksums=_checksums(paths),
        files=tuple(paths),
    )


def _from_toml(path: Path, columns: Mapping[str, str | int] | None) -> Campaign:
    if columns:
        do = "write columns = { … } under its [[record]] or [defaults]"
        raise UserError("a campaign file says itself which column is which", where=path.name, do=do)
    document, folder = read_document(path, path.name), path.parent
    title = document.text("title", folder.resolve().name)
    given, device_path = read_device(document, folder)
    device, measures, rate = of_displacement(given or Platform())
    model = document.section("model")
    effects = model.texts("effects")
    linear = model.choice("linear", ("auto", "oscillator", "no-spring"), "auto")
    effect_files = tuple(_effect_file(model, folder, name) for name in model.texts("effect_files"))
    model.check_keys()
    settings, priors = _settings(document.section("effect")), _priors(document.section("priors"))
    specs = [parse_record(section, folder, device, measures) for section in record_sections(document)]
    document.check_keys()
    if not specs:
        raise UserError("the campaign has no records", where=path.name, do='add [[record]] with file = "a.csv"')
    notes = rate if given else ["No device given: the nominal platform is assumed."]
    records: list[Record] = []
    for spec in specs:
        own = (device.output, device.input) if isinstance(device, Oscillator) else ()
        record, found = load_record(spec, read_table(spec.path, spec.file, own), device)
        records.append(record)
        notes += found
    files = [path, *([device_path] if device_path else []), *effect_files, *(spec.path for spec in specs)]
    files += [spec.drive_file for spec in specs if spec.drive_file is not None]
    return Campaign(
        title,
        _with_common_noise(records),
        device,
        effects,
        effect_files,
        settings,
        priors,
        tuple(notes),
        path,
        _checksums(files, folder),
        (path,),
        linear,
    )


def _with_common_noise(records: list[Record]) -> tuple[Record, ...]:
    """The records, with the colour of the estimated noise shared where it agrees."""
    own = [k for k, record in enumerate(records) if isinstance(record, Trace) and record.noise.relative_error > 0]
    traces = [record for k, record in enumerate(records) if k in own and isinstance(record, Trace)]
    floors = pooled([trace.noise for trace in traces], [len(trace.time) for trace in traces])
    for k, trace, floor in zip(own, traces, floors, strict=True):
        records[k] = replace(trace, noise=floor)
    return tuple(records)


def _effect_file(model: Section, folder: Path, name: str) -> Path:
    path = folder / name
    if "\0" in name or not exists(path):
        raise model.error("effect_files", f'there is no file "{name}" in {folder}', "correct the name")
    return check_file(path, f"{model.where('effect_files')}: {name}", MOST_TEXT)


def _settings(section: Section) -> Mapping[str, Mapping[str, Any]]:
    """Per effect, its settings: quantities become SI floats, words stay words."""
    found: dict[str, Mapping[str, Any]] = {}
    for name in section.values:
        values = section.get(name, dict, f"a table ([effect.{name}])")
        table = section.inside(name, values)
        found[name] = MappingProxyType({key: _setting(table, key, value) for key, value in values.items()})
    return MappingProxyType(found)


def _setting(section: Section, key: str, value: Any) -> Any:
    if isinstance(value, list):
        return tuple(_setting(section, key, one) for one in value)
    if isinstance(value, str) and looks_like_quantity(value):
        return parse_quantity(value, where=section.where(key))
    if isinstance(value, float) and not math.isfinite(value):
        raise section.error(key, f"{value} is not a finite number", "write a number")
    if isinstance(value, (str, bool)):
        return value
    if isinstance(value, (int, float)):
        return _float(section, key, value)
    raise section.error(key, f"{shown(value)} is not a setting", 'write a number, a quantity ("80 MPa") or a word')


def _float(section: Section, key: str, value: int | float) -> float:
    try:
        return float(value)
    except OverflowError:
        raise section.error(key, "the number is too large", "write a smaller number") from None


def _priors(section: Section) -> Mapping[str, Prior]:
    """Per parameter its prior, from `{ normal = [80, 20], unit = "MPa" }`; unquoted dotted names work too."""
    found: dict[str, Prior] = {}
    for name, value in section.values.items():
        inner = value if isinstance(value, dict) else {}
        if inner and "normal" not in inner and all(isinstance(one, dict) for one in inner.values()):
            nested = section.inside(name, inner)
            for parameter, one in inner.items():
                found[f"{name}.{parameter}"] = _prior(nested, parameter, one)
        else:
            found[name] = _prior(section, name, value)
    return MappingProxyType(found)


def _prior(section: Section, name: str, value: Any) -> Prior:
    example = 'write { normal = [80, 20], unit = "MPa" }'
    if not isinstance(value, dict):
        raise section.error(name, f"{shown(value)} is not a prior", example)
    table = Section(value, section.file, section.lines, f"prior of {name}:", section.start)
    numbers = table.get("normal", list, "a mean and a standard deviation ([80, 20])")
    unit = table.text("unit", "1")
    table.check_keys()
    plain = isinstance(numbers, list) and len(numbers) == 2
    if not plain or any(isinstance(one, bool) or not isinstance(one, (int, float)) for one in numbers):
        raise section.error(name, f"normal = {shown(numbers)} is not a mean and a standard deviation", example)
    where = section.where(name)
    mean, deviation = (to_si(_float(section, name, one), unit, where=where) for one in numbers)
    if max(abs(mean), deviation) > 1e100 or 0 < deviation < 1e-100:  # their squares are numbers no more
        raise section.error(name, f"normal = {shown(numbers)} is beyond any physics", example)
    if not deviation > 0:
        raise section.error(name, f"a standard deviation of {shown(numbers[1])} is not positive", example)
    return Prior(mean, deviation)


def _checksums(files: Sequence[Path], folder: Path | None = None) -> Mapping[str, str]:
    sums = {}
    for path in files:
        inside = folder is not None and path.is_relative_to(folder)
        name = path.relative_to(folder).as_posix() if inside and folder is not None else path.name
        with open(path, "rb") as file:
            sums[name] = hashlib.file_digest(file, "sha256").hexdigest()
    return MappingProxyType(sums)
