"""Writing a campaign folder: CSV files in laboratory style, `campaign.toml`, `truth.toml`."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np


@dataclass(frozen=True)
class Column:
    """A CSV column: its heading (with the unit), file units per SI unit, and decimals written."""

    heading: str
    per_si: float
    decimals: int


def write_csv(path: Path, columns: tuple[Column, ...], values: tuple[np.ndarray, ...], comment: str = "") -> None:
    """Write columns given in SI units, rounded to the decimals of each column."""
    lines = [f"# {comment}"] if comment else []
    lines.append(",".join(c.heading for c in columns))
    scaled = [np.round(v * c.per_si, c.decimals) + 0.0 for c, v in zip(columns, values, strict=True)]
    lines += [
        ",".join(f"{x:.{c.decimals}f}" for c, x in zip(columns, row, strict=True)) for row in zip(*scaled, strict=True)
    ]
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")


def toml_value(value: object) -> str:
    """One value as TOML: text, truth, number, list or inline table."""
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, str):
        return '"' + value.replace("\\", "\\\\").replace('"', '\\"') + '"'
    if isinstance(value, Mapping):
        return "{ " + ", ".join(f"{k} = {toml_value(v)}" for k, v in value.items()) + " }"
    if isinstance(value, (list, tuple)):
        return "[" + ", ".join(toml_value(v) for v in value) + "]"
    if isinstance(value, int):
        return str(value)
    if isinstance(value, (float, np.floating)):
        return repr(float(value))
    raise TypeError(f"No TOML form for {type(value).__name__}.")


def write_truth(path: Path, parameters: Mapping[str, float], extra: Mapping[str, object]) -> None:
    """Write `truth.toml`: the table `[parameters]` in SI units, and what else is known about the data."""
    lines = [f"{k} = {toml_value(v)}" for k, v in extra.items()]
    lines += ["", "[parameters]  # SI units"]
    lines += [f'"{name}" = {toml_value(float(value))}' for name, value in parameters.items()]
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")


def write_campaign(
    path: Path,
    head: Mapping[str, object],
    effects: tuple[str, ...],
    settings: Mapping[str, Mapping[str, object]],
    records: list[dict[str, object]],
) -> None:
    """Write `campaign.toml`."""
    lines = [f"{k} = {toml_value(v)}" for k, v in head.items()]
    lines += ["", "[model]", f"effects = {toml_value(list(effects))}"]
    for name, table in settings.items():
        lines += ["", f"[effect.{name}]"] + [f"{k} = {toml_value(v)}" for k, v in table.items()]
    for record in records:
        lines += ["", "[[record]]"] + [f"{k} = {toml_value(v)}" for k, v in record.items()]
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")
