"""A TOML file whose every value can say where it stands: the file, and the line if it can be found."""

from __future__ import annotations

import re
import tomllib
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from ..errors import UserError, nearest
from ..units import Dimension, parse_quantity
from .tables.opening import read_bytes
from .tables.text import decode


@dataclass(frozen=True)
class Section:
    """One table of a TOML file. `start` is the line of its header (0: the whole file)."""

    values: Mapping[str, Any]
    file: str
    lines: tuple[str, ...] = ()
    title: str = ""
    start: int = 0
    used: set[str] = field(default_factory=set)

    def where(self, key: str = "") -> str:
        """ "campaign.toml, line 12", as far as the line can be found."""
        if not key:
            return self.file + (f", line {self.start}" if self.start else "")
        pattern = re.compile(rf"""(^|[{{,\s.])["']?{re.escape(key)}["']?\s*(=|\.)|^\s*\[+.*\b{re.escape(key)}\b.*\]""")
        for number in range(max(self.start, 1), len(self.lines) + 1):
            line = self.lines[number - 1]
            if number > self.start > 0 and re.match(r"\s*\[", line) and not pattern.search(line):
                break
            if pattern.search(line):
                return f"{self.file}, line {number}"
        return self.where()

    def error(self, key: str, what: str, do: str) -> UserError:
        """An error about one key."""
        place = f"{self.title} {key}".strip()
        return UserError(f"{place}: {what}", where=self.where(key), do=do)

    def get(self, key: str, kind: type | tuple[type, ...], words: str, default: Any = None) -> Any:
        """The value of a key, of the type that `words` names; `default` if the key is absent."""
        self.used.add(key)
        if key not in self.values:
            return default
        value = self.values[key]
        kinds = kind if isinstance(kind, tuple) else (kind,)
        if not isinstance(value, kinds) or (isinstance(value, bool) and bool not in kinds):
            raise self.error(key, f"{shown(value)} does not fit here", f"write {words}")
        return value

    def text(self, key: str, default: str = "") -> str:
        return self.get(key, str, 'a text in quotes ("…")', default)

    def flag(self, key: str) -> bool:
        return self.get(key, bool, "true or false", False)

    def choice(self, key: str, choices: tuple[str, ...], default: str) -> str:
        """One word out of `choices`; `default` if the key is absent."""
        value = self.get(key, str, "one of " + ", ".join(f'"{c}"' for c in choices), default)
        if key in self.values and value not in choices:
            what = f'"{value}" is none of ' + ", ".join(f'"{c}"' for c in choices)
            raise self.error(key, what, nearest(value, choices, "use one of these words"))
        return value

    def texts(self, key: str) -> tuple[str, ...]:
        """A list of texts."""
        value = self.get(key, list, 'a list of texts (["a", "b"])', [])
        if not all(isinstance(one, str) for one in value):
            raise self.error(key, f"{shown(value)} is not a list of texts", 'write for example ["a", "b"]')
        return tuple(value)

    def quantity(self, key: str, dimension: Dimension, example: str) -> float | None:
        """A number with its unit, as an SI float."""
        value = self.get(key, str, f'a number with its unit ("{example}")')
        return None if value is None else parse_quantity(value, dimension, where=self.where(key))

    def section(self, key: str) -> Section:
        """The table under a key; empty if it is absent."""
        values = self.get(key, dict, "a table ([" + key + "] or { … })", {})
        return self.inside(key, values)

    def inside(self, key: str, values: Mapping[str, Any]) -> Section:
        """A table that belongs to this one."""
        record = self.title.startswith("[[")
        full = f"{self.title.strip('[]')}.{key}".strip(".")
        named = re.escape(full).replace(r"\.", r"\s*\.\s*")
        header = re.compile(rf"^\s*\[\s*{named}\s*\]|(^|[{{,\s]){re.escape(key)}\s*=")
        title = f"{key}:" if record else f"[{full}]"
        start = self.start
        for number in range(max(self.start, 1), len(self.lines) + 1 if values else 0):
            if header.search(self.lines[number - 1].replace('"', "").replace("'", "")):
                start = number
                break
        return Section(values, self.file, self.lines, title, start)

    def check_keys(self) -> None:
        """A `UserError` for the first key that nobody asked for."""
        for key in self.values:
            if key not in self.used:
                do = nearest(key, self.used, "the keys are " + ", ".join(sorted(self.used)))
                raise self.error(key, "this key is not known", do)


def shown(value: Any) -> str:
    """A TOML value, short, for an error message."""
    text = {True: "true", False: "false"}[value] if isinstance(value, bool) else repr(value)
    return text if len(text) <= 40 else text[:37] + "…"


def read_document(path: Path, name: str) -> Section:
    """A TOML file; a `UserError` with line and column where its syntax is broken."""
    text = decode(read_bytes(path, name), name, "write it as plain text (UTF-8)")
    try:
        values = tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        message = str(error)
        match = re.fullmatch(r"(.*) \(at line (\d+), column (\d+)\)", message, re.DOTALL)
        where = f"{name}, line {match[2]}, column {match[3]}" if match else f"{name}, at its end"
        advice = "texts stand in quotes, every key once, and every bracket is closed"
        raise UserError(f"not valid TOML: {match[1] if match else message}", where=where, do=advice) from None
    except (RecursionError, ValueError):  # nested a thousand times, or an integer of thousands of digits
        raise UserError("not valid TOML", where=name, do="see https://toml.io for the format") from None
    return Section(values, name, tuple(text.split("\n")))


def record_sections(campaign: Section) -> Iterator[Section]:
    """The `[[record]]` tables, each knowing its line."""
    records = campaign.get("record", list, "a list of [[record]] tables", [])
    common = campaign.section("defaults").values
    if own := next((key for key in ("file", "drive_file") if key in common), None):
        raise campaign.section("defaults").error(own, "belongs to one record", "write it under [[record]]")
    starts = [k for k, line in enumerate(campaign.lines, 1) if re.match(r"\s*\[\[\s*record\s*\]\]", line)]
    for index, values in enumerate(records):
        if not isinstance(values, dict):
            raise campaign.error("record", f"{shown(values)} is not a table", "write each record under [[record]]")
        start = starts[index] if index < len(starts) else 0
        values = {**common, **values}
        yield Section(values, campaign.file, campaign.lines, "[[record]]", start)
