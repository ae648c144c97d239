"""One measured set: its campaign, what `ident` makes of it, and what is asserted."""

from __future__ import annotations

import json
import tempfile
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from experiments import public_data
from experiments.public_data import ident


@dataclass(frozen=True)
class Device:
    """A set of records under `IDENT_BENCHMARKS`.

    **Arguments:**

    - `folder`, `files`: where the tables are; `campaign`: what a user would type, knowing columns and units.
    - `baseline`: held-out error, percent of the signal, of the plain SciPy fit that goes with the set.
    - `start`, `final`: limits of the held-out error per cent, of the linear start and of the last model; `records`: of
      single records with the last model.
    - `values`: parameters of the last model that others have measured, SI, and how far off they may be, as a share.
    - `form`: the linear model that must be chosen; `first`: the effect that must be named first, or tie with the first;
      `never`: those that must not be named; `verdicts`: those that may be given.
    - `rows`: for some files the rows of the table that are kept, first and last, where others judged no more of it.
    """

    folder: str
    files: tuple[str, ...]
    campaign: str
    baseline: float
    start: float
    final: float | None = None
    records: Mapping[str, float] = field(default_factory=dict)
    values: Mapping[str, tuple[float, float]] = field(default_factory=dict)
    form: str = "oscillator"
    first: str = ""
    never: frozenset[str] = field(default_factory=frozenset)
    verdicts: frozenset[str] = frozenset({"ambiguous", "not-in-library"})
    rows: Mapping[str, tuple[int, int]] = field(default_factory=dict)

    def main(self) -> None:
        """Run, print and assert; without the files it says so and ends."""
        if not public_data.available(self.folder, self.files):
            print(f"skipped: {public_data.data_folder(self.folder)} lacks the files; set IDENT_BENCHMARKS")
            return
        with tempfile.TemporaryDirectory() as temporary:
            self.check(*self.run(Path(temporary)))

    def run(self, work: Path) -> tuple[dict[str, Any], dict[str, Any], list[tuple[str, float]]]:
        """`run.json`, `diagnosis.json`, and the held-out error in percent of the start and after every step."""
        public_data.prepare(work / "it", self.campaign, self.folder, self.files)
        for name, (first, last) in self.rows.items():
            path = work / "it" / name
            head, *lines = path.read_text(encoding="utf-8").splitlines(keepends=True)
            path.unlink()  # a link to the table as it is
            path.write_text("".join([head, *lines[first : last + 1]]), encoding="utf-8")
        ident(("discover", "it", "-o", "runs/it"), work)
        folder = work / "runs" / "it"
        run = json.loads((folder / "run.json").read_text(encoding="utf-8"))
        said = json.loads((folder / "diagnosis.json").read_text(encoding="utf-8"))
        states = [("start", said["start"]), *((step["added"], step) for step in said["steps"])]
        return run, said, [(name, 100 * state["holdout_error_over_signal"]) for name, state in states]

    def check(self, run: dict[str, Any], said: dict[str, Any], walked: list[tuple[str, float]]) -> None:
        """Print what was found and hold it to the limits."""
        verdict = said["verdict"]
        print(f"{self.folder}: {run['linear']['form']}, baseline {self.baseline} %, {verdict}")
        for name, error in walked:
            print(f"  {name:<24} {error:8.3g} %")
        assert run["linear"]["form"] == self.form, run["linear"]
        names = [name for name, _ in walked[1:]]
        assert walked[0][1] <= self.start, walked
        assert not self.never & set(names), names
        assert verdict in self.verdicts, verdict
        if self.final is not None:
            assert walked[-1][1] <= self.final, walked
        errors = {record["file"]: 100 * record["error_over_signal"] for record in run["records"]}
        for name, limit in self.records.items():
            print(f"  {name:<24} {errors[name]:8.3g} %")
            assert errors[name] <= limit, (name, errors[name])
        found = {parameter["name"]: parameter["value"] for parameter in run["parameters"]}
        for name, (value, share) in self.values.items():
            print(f"  {name:<24} {found[name]:8.4g}, published {value:.4g}")
            assert abs(found[name] / value - 1) <= share, (name, found[name])
        if self.first:
            assert names and self.first in (names[0], *said["steps"][0]["tie_set"]), names
