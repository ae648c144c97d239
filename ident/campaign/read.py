"""Reading a campaign: the TOML file with its records, a folder that holds one, or data files alone."""

from __future__ import annotations

import hashlib
import math
import os
from collections.abc import Iterator, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from pathlib import Path
from types import MappingProxyType
from typing import Any

import numpy as np

from ..errors import UserError
from ..threads import one_thread
from ..units import looks_like_quantity, parse_quantity, to_si
from .added_drive import beside, drive_column
from .campaign import MOST_MODES, Campaign, Prior
from .device import Device, Oscillator, Platform
from .device_file import of_displacement, read_device
from .document import Section, read_document, record_sections, shown
from .guess import guess_device, in_units_of, renamed
from .in_memory import document_of, is_path
from .load import load_record, read_table
from .noise.of_others import beside_others
from .noise.one_sensor import of_one_sensor
from .noise.pool import pooled
from .quality.rest_level import counted_from_rest
from .record import Record, Trace
from .said import Said
from .scale import quantity_of
from .spec import RecordSpec, parse_record
from .sweeps.rate import displaced
from .sweeps.together import seen_together
from .tables.binary import READERS
from .tables.instruments import INSTRUMENT_READERS
from .tables.opening import MOST_TEXT, check_file, exists
from .tables.table import Table

PathLike = str | os.PathLike[str]

DATA_SUFFIXES = (".csv", ".txt", ".tsv", ".dat", ".asc", ".lvm", *READERS, *INSTRUMENT_READERS)


@one_thread
def read_campaign(data: Any, columns: Mapping[str, str | int] | None = None, **told: Any) -> Campaign:
    """The campaign in a TOML file, in a folder with a `campaign.toml`, in one or more data files, or in memory.

    In memory a record is a DataFrame, a mapping of columns or an (n, 3) array of time, drive and response; several are
    a list or a mapping by name; a mapping with "record" says all that a campaign file can, tables standing under
    "data". Headers carry units as in a file ("z [um]"); without one, SI is assumed.

    **Arguments:** `columns`: which column is which ({"drive": "CH1"}); `told`: what a campaign file would say instead:
    `device`, `title`, the names of the records to `holdout`, and for all records `start`, `noise`, `skip`, `rate`, ….
    A campaign file says all this itself.

    All numbers of the result are SI. What was assumed, and what the data checks found, is in `Campaign.notes`.
    Anything unusable raises one `UserError` that says where it is and what to do.
    """
    if isinstance(data, Campaign):
        if columns or told:
            raise UserError(f"the campaign {data.title} is read already", do="say it when the data are read")
        return data
    if not is_path(data):
        campaign = _from_document(Section(document_of(data, columns, told), ""), Path())
        return replace(campaign, checksums={record.name: _fingerprint(record) for record in campaign.records})
    paths = [Path(data)] if isinstance(data, (str, os.PathLike)) else [Path(one) for one in data]
    if not paths:
        raise UserError("no campaign given", do="name a campaign.toml, a folder that holds one, or CSV files")
    for one in paths:
        if "\0" in str(one) or not exists(one):
            raise UserError("there is no such file or folder", where=str(one), do="correct the path")
    try:
        if len(paths) == 1 and (paths[0].is_dir() or paths[0].suffix.lower() == ".toml"):
            path = _in_folder(paths[0]) if paths[0].is_dir() else paths[0]
            if columns or told:
                do = "write columns = { … } and the rest under its [[record]] or [defaults]"
                raise UserError("a campaign file says itself which column is which", where=path.name, do=do)
            return _from_document(read_document(path, path.name), path.parent, path)
        return _from_files(paths, columns or {}, told)
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


def _from_files(paths: list[Path], columns: Mapping[str, str | int], told: Mapping[str, Any]) -> Campaign:
    for path in paths:
        if path.is_dir() or path.suffix.lower() == ".toml":
            what = f"a {'folder' if path.is_dir() else 'campaign file'} cannot be mixed with data files"
            raise UserError(what, where=str(path), do="name either one campaign or data files only")
        check_file(path, path.name)
    document = document_of([read_table(path, path.name) for path in paths], columns, told)
    campaign = _from_document(Section(document, ""), Path())
    return replace(campaign, checksums=_checksums(paths), files=tuple(paths))


def _from_document(document: Section, folder: Path, path: Path | None = None) -> Campaign:
    """The campaign that a document describes; `path` of its file, unless it was made of data alone."""
    title = document.text("title", folder.resolve().name)
    given, device_path = read_device(document, folder)
    tables = [section.values.get("data") for section in record_sections(document)]
    device, notes = given or Platform(), [] if given else ["No device given: the nominal platform is assumed."]
    if given is None and path is None and all(isinstance(table, Table) for table in tables):
        chosen = document.section("defaults").section("columns").values
        device, notes = guess_device([renamed(table, chosen) for table in tables if isinstance(table, Table)])
    if isinstance(device, Oscillator) and not (device.output and device.input):
        device, told = in_units_of(device, _tables(document, folder))
        notes = [*notes, *told]
    device, measures, rate = of_displacement(device)
    notes += rate
    model = document.section("model")
    effects = model.texts("effects")
    linear = model.choice("linear", ("auto", "oscillator", "no-spring", "quasi-static"), "auto")
    modes = _modes(model, device, linear)
    effect_files = tuple(_effect_file(model, folder, name) for name in model.texts("effect_files"))
    model.check_keys()
    settings, priors = _settings(document.section("effect")), _priors(document.section("priors"))
    specs = [parse_record(section, folder, device, measures) for section in record_sections(document)]
    document.check_keys()
    if not specs:
        where = path.name if path else ""
        raise UserError("the campaign has no records", where=where, do='add [[record]] with file = "a.csv"')
    own = (device.output, device.input) if isinstance(device, Oscillator) else ()

    def loaded(spec: RecordSpec) -> tuple[list[tuple[RecordSpec, Record]], list[str]]:
        return load_record(spec, spec.table or read_table(spec.path, spec.file, own), device)

    read: list[tuple[RecordSpec, Record]] = []
    with ThreadPoolExecutor(2) as pool:  # most of the work is the noise floor's, outside the interpreter
        for found, told in pool.map(loaded, specs):
            read += found
            notes += told
    parts = [spec for spec, _ in read]
    apart = _called_apart([record for _, record in read])
    records = counted_from_rest(displaced(seen_together(apart, notes), parts, device, notes), notes)
    files = [one for one in (path, device_path, *effect_files) if one is not None]
    measured = [spec.path for spec in specs if spec.table is None]
    measured += [spec.drive_file for spec in specs if spec.drive_file is not None]
    return Campaign(
        title,
        _with_common_noise(records),
        device,
        effects,
        effect_files,
        settings,
        priors,
        tuple(dict.fromkeys(notes)),
        path,
        _checksums([*files, *measured], folder),
        () if path is None else (path,),
        linear,
        modes,
        None if path is None else Said.of(parts, device, [linear, modes], _names(measured, folder), folder),
    )


def _tables(document: Section, folder: Path) -> Iterator[Table]:
    """The tables of the records, their columns called by their roles and in the units that a sensor's sensitivity
    makes of them, up to one that cannot be read, which is said where all records are."""
    for section in record_sections(document):
        table, file = section.values.get("data"), section.text("file")
        scale = {role: quantity_of(str(text)) for role, text in section.section("scale").values.items()}
        units = dict(section.section("units").values) | {role: unit for role, unit in scale.items() if unit}
        try:
            table = table if isinstance(table, Table) else read_table(folder / file, file)
            columns = dict(section.section("columns").values)
            if other := section.text("drive_file"):
                drive = drive_column(read_table(folder / other, other), columns.pop("drive", None))
                table = beside(table, drive, units)
            yield renamed(table, columns, units)
        except (UserError, OSError, ValueError):
            return


def _modes(model: Section, device: Device, linear: str) -> int | None:
    """How many linear modes the campaign asks for; None if the records decide."""
    told = model.get("modes", int, f"a number from 1 to {MOST_MODES}")
    if told is None:
        return None
    if not 1 <= told <= MOST_MODES:
        raise model.error("modes", f"{shown(told)} modes", f"write a number from 1 to {MOST_MODES}, or leave it out")
    if told > 1 and (not isinstance(device, Oscillator) or linear not in ("auto", "oscillator")):
        raise model.error(
            "modes",
            "only an oscillator has further linear modes",
            'remove it, or write device = { kind = "oscillator" } and no other linear model',
        )
    return told


def _called_apart(records: Sequence[Record]) -> list[Record]:
    """The records, numbered where several are columns of one file: a record is known by its name."""
    found, taken = list[Record](), {record.name for record in records}
    known = set[str]()
    for record in records:
        name, again = record.name, 1
        while name in known or (again > 1 and name in taken):
            again += 1
            name = f"{record.name} ({again})"
        known.add(name)
        found.append(record if again == 1 else replace(record, name=name))
    return found


def _with_common_noise(records: list[Record]) -> tuple[Record, ...]:
    """The records, with the colour of the estimated noise shared where it agrees, and the level of what shows none."""
    own = [k for k, record in enumerate(records) if isinstance(record, Trace) and record.noise.relative_error > 0]
    traces = [record for k, record in enumerate(records) if k in own and isinstance(record, Trace)]
    floors = of_one_sensor(traces)
    kept = [k for k, trace in enumerate(traces) if floors[k] is trace.noise]
    for k, floor in zip(kept, pooled([floors[k] for k in kept], [len(traces[k].time) for k in kept]), strict=True):
        floors[k] = floor
    for k, trace, floor in zip(own, traces, beside_others(traces, floors), strict=True):
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


def _names(files: Sequence[Path], folder: Path | None) -> list[str]:
    """What files are called: relative to the campaign where they lie in its folder."""
    inside = lambda path: folder is not None and path.is_relative_to(folder)
    return [path.relative_to(folder or Path()).as_posix() if inside(path) else path.name for path in files]


def _checksums(files: Sequence[Path], folder: Path | None = None) -> Mapping[str, str]:
    sums = {}
    for name, path in zip(_names(files, folder), files, strict=True):
        with open(path, "rb") as file:
            sums[name] = hashlib.file_digest(file, "sha256").hexdigest()
    return MappingProxyType(sums)


def _fingerprint(record: Record) -> str:
    """SHA-256 of the numbers of a record that came from no file."""
    trace = isinstance(record, Trace)
    arrays = (record.time, record.drive, record.response) if trace else (
        record.frequency, record.level, record.amplitude
    )  # fmt: skip
    return hashlib.sha256(b"".join(np.ascontiguousarray(one, float).tobytes() for one in arrays)).hexdigest()
