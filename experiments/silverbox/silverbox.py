"""The Silverbox benchmark by the commands of `docs/silverbox.md`: `python -m experiments.silverbox.silverbox`.

The data are not shipped. `IDENT_BENCHMARKS` names the folder that holds `silverbox/*.csv`; without them the script
says so and ends. It prints the error of every model in mV and asserts the bounds of `STEPS`.
"""

from __future__ import annotations

import json
import re
import tempfile
import time
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pandas as pd

from experiments import public_data
from experiments.public_data import ident

PAGE = public_data.ROOT / "docs" / "silverbox.md"
FILES = ("silverbox_train_multisine.csv", "silverbox_test_multisine.csv", "silverbox_test_arrow.csv")


class Step(NamedTuple):
    """One command, the run it writes, and the most that its error (mV) on the two test records may be."""

    arguments: tuple[str, ...]
    run: str
    arrow: float
    multisine: float = float("inf")


STEPS = (
    Step(("fit", "silverbox", "-o", "runs/linear"), "runs/linear", 14.5),
    Step(("add", "runs/linear", "cubic-stiffness", "-o", "runs/cubic"), "runs/cubic", 0.46),
    Step(("add", "runs/cubic", "quadratic-stiffness", "-o", "runs/quadratic"), "runs/quadratic", 0.40),
    Step(("add", "runs/quadratic", "quadratic-damping", "-o", "runs/damped"), "runs/damped", 0.32, 0.29),
)


ARROW_ALONE, INSIDE_ALONE = 0.29, 0.25  # mV, the most that the loop by itself may leave of the arrow, and of its inside
SKIPPED, INSIDE = 50, 32_000  # samples that the benchmark does not count, and those before the arrow's widest part


class Outcome(NamedTuple):
    """Errors of one run in mV: fitted record, test multisine, test arrow."""

    train: float
    multisine: float
    arrow: float


def prepare(work: Path, name: str = "silverbox", text: str | None = None) -> None:
    """Make the campaign folder of the page, or one of another `text`."""
    public_data.prepare(work / name, text or public_data.campaign_text(PAGE), "silverbox", FILES)


def outcome(run: Path) -> Outcome:
    """The errors that a run folder holds."""
    records = json.loads((run / "run.json").read_text(encoding="utf-8"))["records"]
    per_unit = {"V": 1e3, "mV": 1.0}
    errors = {Path(r["file"]).name: r["rmse"] * per_unit[r["unit"]] for r in records}
    return Outcome(*(errors[name] for name in FILES))


def walk(work: Path) -> list[Outcome]:
    """All steps, each held to its bounds."""
    prepare(work)
    found = []
    for step in STEPS:
        ident(step.arguments, work)
        errors = outcome(work / step.run)
        assert errors.arrow <= step.arrow, (step, errors)
        assert errors.multisine <= step.multisine, (step, errors)
        print(f"{step.run:<16} {errors.train:9.4f} {errors.multisine:9.4f} {errors.arrow:9.4f}", flush=True)
        found.append(errors)
    return found


def discover(work: Path) -> tuple[list[str], Outcome]:
    """What `ident discover` names in the linear oscillator, knowing nothing, and the errors at the end."""
    without_model = re.sub(r"\[model\]\n.*?\n\n", "", public_data.campaign_text(PAGE), flags=re.DOTALL)
    prepare(work, "blind", without_model)
    begun = time.perf_counter()
    ident(("discover", "blind", "-o", "runs/discovered"), work)
    seconds = time.perf_counter() - begun
    said = json.loads((work / "runs/discovered/diagnosis.json").read_text(encoding="utf-8"))
    names, errors = [step["added"] for step in said["steps"]], outcome(work / "runs/discovered")
    heldout = [said["start"], *said["steps"]]
    assert names[0] == "cubic-stiffness", names
    assert errors.arrow <= ARROW_ALONE, errors
    assert all(
        b["holdout_error_over_noise"] < a["holdout_error_over_noise"]
        for a, b in zip(heldout, heldout[1:], strict=False)
    ), heldout
    print(f"{'runs/discovered':<16} {errors.train:9.4f} {errors.multisine:9.4f} {errors.arrow:9.4f}")
    print(f"discovered: {', '.join(names)}; verdict {said['verdict']}; {seconds:.0f} s")
    return names, errors


def without_extrapolation(work: Path, run: str) -> float:
    """The error (mV) on the arrow up to the amplitudes that the training record has, the benchmark's third score."""
    arrow = FILES[2]
    ident(("simulate", run, "--record", arrow, "-o", "arrow.csv"), work)
    told = pd.read_csv(work / "arrow.csv", comment="#")["response (V)"]
    measured = pd.read_csv(work / "silverbox" / arrow, comment="#")["y_V"]
    error = 1e3 * float(np.sqrt(np.mean((told - measured)[SKIPPED:INSIDE] ** 2)))
    assert error <= INSIDE_ALONE, error
    print(f"discovered, the arrow's first {INSIDE} samples: {error:.4f} mV")
    return error


if __name__ == "__main__":
    if not public_data.available("silverbox", FILES):
        print(f"skipped: {public_data.data_folder('silverbox')} lacks the files; set IDENT_BENCHMARKS")
    else:
        with tempfile.TemporaryDirectory() as temporary:
            print(f"{'run':<16} {'train':>9} {'multisine':>9} {'arrow':>9}   mV")
            walk(Path(temporary))
            discover(Path(temporary))
            without_extrapolation(Path(temporary), "runs/discovered")
