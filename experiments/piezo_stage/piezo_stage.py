"""A measured PZT stage by the commands of `docs/piezo-stage.md`: `python -m experiments.piezo_stage.piezo_stage`.

The data are not shipped. `IDENT_BENCHMARKS` names the folder that holds `piezo_stage/*.csv`; without them the script
says so and ends. It prints what the loop names and the error of every step in percent of the held-out record's
standard deviation, and asserts what is named, `HELD_OUT` and the table of the page.
"""

from __future__ import annotations

import json
import re
import tempfile
import time
from pathlib import Path

import numpy as np
import pandas as pd

from experiments import public_data
from experiments.public_data import ident

PAGE = public_data.ROOT / "docs" / "piezo-stage.md"
FILES = ("piezo_20_hz_lp.csv", "piezo_100_hz_lp.csv", "piezo_40_hz_lp.csv")
JUDGE = FILES[2]
HYSTERESES = {"prandtl-ishlinskii", "bouc-wen-drive"}
RELAXATIONS = {"creep", "viscoelastic-support"}
HELD_OUT = 1.0  # percent
TOLD = 0.02  # by how much, relative, a number of the page may differ
WARNING = "is not identified"


def percent(rmse: float) -> float:
    """An rms error (V) in percent of the standard deviation of the held-out record, its rest included."""
    table = pd.read_csv(public_data.data_folder("piezo_stage") / JUDGE)
    return 100 * rmse / float(np.std(table["y_V"]))


def walk(work: Path) -> list[tuple[str, float, float]]:
    """What is named, step by step, with the error on the fitted records (noise floors) and on the held-out one (%)."""
    public_data.prepare(work / "piezo", public_data.campaign_text(PAGE), "piezo_stage", FILES)
    said = _discover("piezo", work)
    floor = _floor(work)
    steps = [("linear oscillator", said["start"]), *((step["added"], step) for step in said["steps"])]
    found = [(name, at["error_over_noise"], percent(at["holdout_error_over_noise"] * floor)) for name, at in steps]
    for name, fitted, heldout in found:
        print(f"{name:<24} {fitted:9.3g} {heldout:9.3g} %", flush=True)
    names = [name for name, _, _ in found]
    assert names[1] in HYSTERESES, names
    assert RELAXATIONS & set(names[2:]), names
    assert found[-1][2] <= HELD_OUT, found
    told = shown()
    assert [name for name, _, _ in told] == names, told
    assert np.allclose([row[1:] for row in told], [row[1:] for row in found], rtol=TOLD), told
    return found


def shown() -> list[tuple[str, float, float]]:
    """The table of the page."""
    rows = re.findall(r"^\| ([a-z -]+) \| ([\d.]+) \| ([\d.]+) \|$", PAGE.read_text(encoding="utf-8"), re.MULTILINE)
    return [(name, float(fitted), float(heldout)) for name, fitted, heldout in rows]


def warn(work: Path) -> str:
    """The warning that the loop gives where it has the record at 20 Hz alone."""
    record = r"\[\[record\]\]\nfile = \"piezo_100.*?\n\n"
    text = re.sub(record, "", public_data.campaign_text(PAGE), flags=re.DOTALL)
    public_data.prepare(work / "alone", text, "piezo_stage", FILES)
    said = next(sentence for sentence in _discover("alone", work)["advice"] if WARNING in sentence)
    print(said)
    return said


def _discover(name: str, work: Path) -> dict:
    begun = time.perf_counter()
    ident(("discover", name, "-o", f"runs/{name}"), work)
    said = json.loads((work / "runs" / name / "diagnosis.json").read_text(encoding="utf-8"))
    print(f"{name}: {said['verdict']}, {time.perf_counter() - begun:.0f} s", flush=True)
    return said


def _floor(work: Path) -> float:
    """Noise floor (V) of the held-out record."""
    records = json.loads((work / "runs" / "piezo" / "run.json").read_text(encoding="utf-8"))["records"]
    floor = next(r for r in records if Path(r["file"]).name == JUDGE)
    return floor["noise_rmse"] * {"V": 1.0, "mV": 1e-3}[floor["unit"]]


if __name__ == "__main__":
    if not public_data.available("piezo_stage", FILES):
        print(f"skipped: {public_data.data_folder('piezo_stage')} lacks the files; set IDENT_BENCHMARKS")
    else:
        with tempfile.TemporaryDirectory() as temporary:
            walk(Path(temporary))
            warn(Path(temporary))
