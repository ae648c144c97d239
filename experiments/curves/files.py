"""Curves in folders, written as laboratories write them: one style per case."""

from __future__ import annotations

import json
from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np

from experiments.simulator.files import Column, write_campaign, write_csv

from .generator import Case, Curve

STYLES = ("plain", "lock-in", "analyser", "complex", "side by side")

_Written = list[dict[str, object]]


def write(case: Case, folder: Path, style: str = "plain", phase: bool = True, holdout: float | None = None) -> None:
    """Write a campaign of the case's curves.

    **Arguments:** `style`: one of `STYLES`; `phase`: whether phases were recorded; `holdout`: a level (V) that is held
    out, in a file of its own.
    """
    folder.mkdir(parents=True, exist_ok=True)
    platform = case.device.kind == "platform"
    parts = [("", [curve for curve in case.curves if curve.level != holdout])]
    if holdout is not None:
        parts.append(("_judge", [curve for curve in case.curves if curve.level == holdout]))
    records: _Written = []
    for suffix, curves in parts:
        held = {"holdout": True} if suffix else {}
        records += [
            entry | held for entry in _WRITERS[style](folder, suffix, curves, "um" if platform else "mV", phase)
        ]
    head: dict[str, object] = {"title": "A device with something hidden"}
    if not platform:
        head["device"] = {"kind": "oscillator", "output": "V"}
    write_campaign(folder / "campaign.toml", head, (), {}, records)


def write_truth(case: Case, path: Path) -> None:
    """What is true, which should not lie beside the campaign."""
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(json.dumps(case.truth, indent=1, default=float) + "\n", encoding="utf-8")


def _per_si(unit: str) -> float:
    return 1e6 if unit == "um" else 1e3


def _digits(values: np.ndarray) -> int:
    """Decimals that keep rounding three orders below the smallest size."""
    return max(0, int(np.ceil(-np.log10(max(float(np.min(np.abs(values))), 1e-12)))) + 4)


def _joined(curves: Sequence[Curve]) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Frequencies, levels, responses and directions (±1) of several passes, one after the other."""
    return (
        np.concatenate([c.frequency for c in curves]),
        np.concatenate([np.full(len(c.frequency), c.level) for c in curves]),
        np.concatenate([c.response for c in curves]),
        np.concatenate([np.full(len(c.frequency), 1.0 if c.up else -1.0) for c in curves]),
    )


def _degrees(response: np.ndarray) -> np.ndarray:
    return np.degrees(np.angle(response))


def _plain(folder: Path, suffix: str, curves: Sequence[Curve], unit: str, phase: bool) -> _Written:
    """All levels and directions in one file, each in a column."""
    f, level, response, way = _joined(curves)
    size = np.abs(response)
    columns = [Column("freq_Hz", 1, _digits(f) + 2), Column("drive_V", 1, 6), Column("direction", 1, 0),
               Column(f"amplitude_{unit}", _per_si(unit), _digits(size * _per_si(unit)))]  # fmt: skip
    values = [f, level, way, size]
    if phase:
        columns.append(Column("phase_deg", 1, 4))
        values.append(_degrees(response))
    write_csv(folder / f"sweeps{suffix}.csv", tuple(columns), tuple(values))
    return [{"file": f"sweeps{suffix}.csv", "kind": "sweep"}]


def _lock_in(folder: Path, suffix: str, curves: Sequence[Curve], unit: str, phase: bool) -> _Written:
    """A file per level, up and then down, effective values; the level stands in the campaign."""
    entries: _Written = []
    for level in dict.fromkeys(c.level for c in curves):
        f, _, response, _ = _joined([c for c in curves if c.level == level])
        size = np.abs(response) / np.sqrt(2)
        columns = [Column("Frequency [Hz]", 1, _digits(f) + 2),
                   Column(f"R [{unit} rms]", _per_si(unit), _digits(size * _per_si(unit)))]  # fmt: skip
        values = [f, size]
        if phase:
            columns.append(Column("Theta [deg]", 1, 4))
            values.append(_degrees(response))
        name = f"lockin_{len(entries) + 1}{suffix}.csv"
        write_csv(folder / name, tuple(columns), tuple(values))
        entries.append({"file": name, "kind": "sweep", "level": f"{level:.6g} V"})
    return entries


def _analyser(folder: Path, suffix: str, curves: Sequence[Curve], unit: str, phase: bool) -> _Written:
    """A file per level and direction: a response per drive in decibels, `;` and decimal commas; the names tell."""
    entries: _Written = []
    for curve in curves:
        ratio = 20 * np.log10(np.abs(curve.response) * _per_si(unit) / curve.level)
        head = f"Frequency (Hz);Gain: Magnitude (dB re 1 {unit}/V)" + (";Gain: Phase (deg)" if phase else "")
        rows = [
            ";".join(f"{x:.{n}f}".replace(".", ",") for x, n in zip(row, (6, 5, 3), strict=False))
            for row in zip(curve.frequency, ratio, *([_degrees(curve.response)] if phase else []), strict=True)
        ]
        way = "up" if curve.up else "down"
        name = f"sweep_{curve.level:.6g}V_{way}{suffix}.csv"
        (folder / name).write_text("\n".join(["* exported", head, *rows]) + "\n", encoding="utf-8")
        entries.append({"file": name, "kind": "sweep", "direction": way})
    return entries


def _complex(folder: Path, suffix: str, curves: Sequence[Curve], unit: str, phase: bool) -> _Written:
    """Real and imaginary part, the drive from peak to peak; without phase there is no such table."""
    if not phase:
        return _plain(folder, suffix, curves, unit, phase)
    f, level, response, way = _joined(curves)
    size = _digits(np.abs(response) * _per_si(unit)) + 1
    columns = (Column("f_Hz", 1, _digits(f) + 2), Column("Drive (Vpp)", 2, 6), Column("up", 1, 0),
               Column(f"Re(z) [{unit}]", _per_si(unit), size),
               Column(f"Im(z) [{unit}]", _per_si(unit), size))  # fmt: skip
    write_csv(
        folder / f"response{suffix}.csv", columns, (f, level, (way + 1) / 2, np.real(response), np.imag(response))
    )
    return [{"file": f"response{suffix}.csv", "kind": "sweep"}]


def _side_by_side(folder: Path, suffix: str, curves: Sequence[Curve], unit: str, phase: bool) -> _Written:
    """A column per level and direction beside one column of frequencies; amplitudes from peak to peak."""
    f = np.sort(curves[0].frequency)
    columns, values = [Column("f (Hz)", 1, _digits(f) + 2)], [f]
    for curve in curves:
        response = curve.response if curve.up else curve.response[::-1]
        way, size = "up" if curve.up else "down", 2 * np.abs(response)
        columns.append(Column(f"{curve.level:.6g}V {way} ({unit} pp)", _per_si(unit), _digits(size * _per_si(unit))))
        values.append(size)
        if phase:
            columns.append(Column(f"phase {curve.level:.6g}V {way} (deg)", 1, 4))
            values.append(_degrees(response))
    write_csv(folder / f"table{suffix}.csv", tuple(columns), tuple(values))
    return [{"file": f"table{suffix}.csv", "kind": "sweep"}]


_WRITERS: dict[str, Callable[[Path, str, Sequence[Curve], str, bool], _Written]] = {
    "plain": _plain, "lock-in": _lock_in, "analyser": _analyser, "complex": _complex, "side by side": _side_by_side,
}  # fmt: skip
