"""A beam between magnets, swept up and down at four levels: `python -m experiments.real.magnetic_oscillator`.
IDENT_BENCHMARKS names the folder above `magnetic_oscillator`. One level is fitted, three are predicted, with
jumps."""

from __future__ import annotations

import csv
import json
import tempfile
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from experiments import public_data
from experiments.public_data import ident

FITTED = 1.5


@dataclass(frozen=True)
class Pass:
    """One pass at a level: error of a model in per cent of the level's peak, over the points at which it is on the
    device's branch; `apart`, how many of the level's points are not; its jump and the device's, Hz (None: none)."""

    level: float
    up: bool
    counted: int
    apart: int
    error: float
    jump: float | None
    measured_jump: float | None


@dataclass(frozen=True)
class Curves:
    """The set and the limits that it is held to.

    **Arguments:** `first`: what may be named first from the linear start; `error`: per cent of the peak on held-out
    levels; `jump`: Hz between predicted and measured jumps of held-out levels.
    """

    folder: str
    files: tuple[str, ...]
    campaign: str
    first: frozenset[str]
    error: float
    jump: float

    def main(self) -> None:
        """Run, print and assert; without the files it says so and ends."""
        if not public_data.available(self.folder, self.files):
            print(f"skipped: {public_data.data_folder(self.folder)} lacks the files; set IDENT_BENCHMARKS")
            return
        with tempfile.TemporaryDirectory() as temporary:
            work = Path(temporary)
            public_data.prepare(work / "it", self.campaign, self.folder, self.files)
            ident(("discover", "it", "-o", "runs/it"), work)
            said, run = (
                json.loads((work / "runs" / "it" / name).read_text(encoding="utf-8"))
                for name in ("diagnosis.json", "run.json")
            )
        drives = {one["drive"]: one for one in run["own_numbers"] if one["what"] == "drive"}
        self.check([step["added"] for step in said["steps"]], passes_of(run), self.published(), drives)

    def published(self) -> list[Pass]:
        """The errors of the model that its authors fitted to the same level, from the table itself."""
        with (public_data.data_folder(self.folder) / self.files[0]).open(encoding="utf-8") as file:
            rows = [{key: float(cell or "nan") for key, cell in row.items()} for row in csv.DictReader(file)]
        found = []
        for level in sorted({row["drive_level"] for row in rows}):
            for up in (True, False):
                mine = [row for row in rows if row["drive_level"] == level and (row["sweep_dir"] > 0) == up]
                mine.sort(key=lambda row: row["freq_Hz"])
                f, a, b = (
                    np.array([row[name] for row in mine]) for name in ("freq_Hz", "amp_V", "model_published_amp_V")
                )
                found.append(_pass(level, up, f, a, b))
        return found

    def check(
        self, names: list[str], found: list[Pass], published: list[Pass], drives: dict[float, dict[str, Any]]
    ) -> None:
        """Print what was found beside what was published, and hold it to the limits: a level that asks for a drive of
        its own (`drives`, of run.json) by its error with that."""
        print(f"{self.folder}: level {FITTED} fitted, named {' > '.join(names) or 'nothing'}")
        print("level  way    error, % of peak (points)      jump, Hz                       published: error, jump")
        for one in found:
            other = next(p for p in published if (p.level, p.up) == (one.level, one.up))
            way, counted = "up" if one.up else "down", f"{one.counted} points"
            jumps = f"{_hertz(one.jump)} (measured {_hertz(one.measured_jump)})"
            print(f"{one.level:5g}  {way:5}  {one.error:5.2f} ({counted})".ljust(44) + jumps.ljust(32)
                  + f"{other.error:5.2f} %  {_hertz(other.jump)}")  # fmt: skip
        for level, own in drives.items():
            before, after = (100 * x for x in own["error_over_peak"])
            print(f"{level:5g}  answers as if driven by {100 * own['larger_by']:+.1f} %: then both ways {after:.2f} "
                  f"instead of {before:.2f} % of the peak")  # fmt: skip
        assert names and names[0] in self.first, names
        for one in (one for one in found if one.level != FITTED):
            own = drives.get(one.level)
            if one.error > self.error and own is not None:
                assert 100 * own["error_over_peak"][1] <= self.error, own
                continue  # where a device that is driven less would jump says nothing
            assert one.apart < 0.2 * 2 * one.counted and one.error <= self.error, one
            assert (one.jump is None) == (one.measured_jump is None), one
            assert one.jump is None or one.measured_jump is None or abs(one.jump - one.measured_jump) <= self.jump, one


def passes_of(run: dict[str, Any]) -> list[Pass]:
    """The passes of a run folder's `run.json`."""
    found = []
    for record in run["records"]:
        for level in record["levels"]:
            jump = level["jump"] or {"model": None, "measured": None}
            share = 100 * level["rmse"] / record["peak"]
            up = level["direction"] == "up"
            found.append(Pass(level["drive"], up, level["n"], record["apart"], share, jump["model"], jump["measured"]))
    return sorted(found, key=lambda one: (one.level, not one.up))


def _pass(level: float, up: bool, f: np.ndarray, measured: np.ndarray, model: np.ndarray) -> Pass:
    jumps = [_jump(f, values) for values in (measured, model)]
    counted = np.ones(len(f), bool)
    if jumps[0] is not None and jumps[1] is not None:  # between the two jumps they are on different branches
        counted = (f < min(jumps[0], jumps[1])) | (f > max(jumps[0], jumps[1]))
    counted &= np.isfinite(model)
    left = (measured - model)[counted]
    error = 100 * float(np.sqrt(np.mean(left**2))) / float(np.max(measured))
    return Pass(level, up, int(np.sum(counted)), int(np.sum(~counted)), error, jumps[1], jumps[0])


def _jump(f: np.ndarray, a: np.ndarray) -> float | None:
    """Midway across the largest step, if it is 15 % of the peak, as no smooth stretch of these curves has."""
    f, a = f[np.isfinite(a)], a[np.isfinite(a)]
    k = int(np.argmax(np.abs(np.diff(a))))
    return float(f[k] + f[k + 1]) / 2 if abs(a[k + 1] - a[k]) > 0.15 * np.max(a) else None


def _hertz(value: float | None) -> str:
    return "none" if value is None else f"{value:.3f}"


_RECORD = """
[[record]]
file = "frid_frf_4levels.csv"
level = "{level} V"
"""

DEVICE = Curves(
    "magnetic_oscillator",
    ("frid_frf_4levels.csv",),
    """device = { kind = "oscillator", output = "V" }

[defaults]
kind = "sweep"
columns = { direction = "sweep_dir", amplitude = "amp_V" }
"""
    + _RECORD.format(level=FITTED)
    + "".join(_RECORD.format(level=level) + "holdout = true\n" for level in (0.5, 1.0, 2.0)),
    first=frozenset({"cubic-stiffness"}),
    error=4.0,
    jump=0.3,
)

if __name__ == "__main__":
    DEVICE.main()
