"""What a run on one's own data costs: `python -m experiments.benchmarks.first_run`

Campaigns of 7 records of 2400 samples with one effect hidden (`experiments/hidden_effects`), given to the command line
as a user would, with an empty cache of compiled programs, and with one that a campaign of another size, device and
effect has left. CPU seconds are user and system time of the whole process, reading, figures and report included.
`--against FOLDER` runs the same commands in another checkout of ident, turn by turn; `--long` adds the same device with
4 and 16 times as many samples; `--whole` a record of 100,000; `--check` asserts the targets.

Reached, CPU seconds with an empty and with a filled cache, on a machine that others used: `fit` 4.4 and 3.5 (targets 6
and 2), where 9ca4946 took 5.1 and 4.2 in the same run; `discover` 21.1 and 11.6 (20 and 5), where it took 20.8 and
12.6. On a quieter one 18.7 and 11.1, with friction 18.5 and 7.7 (30 and 10); 100,000 samples 68 and 49 with a filled
cache (60). At the end of November 2026, on a slower machine, 4.9 and 3.5, 29 and 17, with friction 29 and 17, where
cf3b15d took 5.8 and 4.1, 29 and 20, 27 and 18 in the same run. On a busy one ddc9a92 took 31 and 20 (6e1f3b1:
36 and 29), with friction 39 and 20 (38 and 21). So `--check` fails, and `docs/speed.md` says why. Before
records came on one tape `discover` took 105 and 47 s.
"""

from __future__ import annotations

import argparse
import json
import os
import resource
import subprocess
import sys
import tempfile
from dataclasses import replace
from pathlib import Path
from typing import NamedTuple

import numpy as np

from experiments.hidden_effects.generator import draw, measure_again, write
from experiments.simulator.signals import Chirp

ROOT = Path(__file__).resolve().parents[2]
SEED, OTHER = 8101, 8102
RECORDS, SAMPLES = 7, 2400
SMOOTH, SHARP, BEFORE = "cubic-stiffness", "coulomb-friction", "sensor-nonlinearity"
LONG = 100_000


class Run(NamedTuple):
    """CPU seconds of a command, with an empty cache and with another campaign's; what it named, and its error."""

    what: str
    cold: float
    warm: float
    named: tuple[str, ...]
    error: float


def campaign(folder: Path, seed: int, effect: str, records: int = RECORDS, samples: int = SAMPLES, **more) -> Path:
    """Write a campaign; the truth lies beside its folder."""
    case = draw(seed, (effect,), size=0.02, noise=0.003, records=records, length=samples, **more)
    write(case, folder, folder.with_suffix(".json"))
    return folder


def single(folder: Path, seed: int, effect: str, samples: int) -> Path:
    """One long record, a chirp through the resonance of a device, and a held-out sine."""
    case = draw(seed, (effect,), size=0.02, noise=0.003, records=4, length=SAMPLES)
    device, step = case.device, case.records[0].time[1] - case.records[0].time[0]
    time = step * np.arange(samples)
    drive = Chirp(0.9 * device.volts, 0.5 * device.frequency, 1.2 * device.frequency, float(time[-1]))
    heldout = next(made for made in case.records if made.holdout)
    write(
        replace(case, records=[measure_again(case, "long", drive, time), heldout]), folder, folder.with_suffix(".json")
    )
    return folder


def seconds(checkout: Path, cache: Path, command: list[str], output: Path) -> float:
    """CPU seconds of `ident COMMAND -o OUTPUT` of a checkout."""
    environment = os.environ | {"IDENT_CACHE": str(cache), "PYTHONPATH": str(checkout), "OPENBLAS_NUM_THREADS": "1"}
    environment.pop("PYTHONDONTWRITEBYTECODE", None)  # a user's Python keeps the bytecode of what it has imported
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    call = [sys.executable, "-m", "ident.cli.main", *command, "-o", str(output), "--force"]
    done = subprocess.run(call, env=environment, cwd=checkout, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def told(output: Path) -> tuple[tuple[str, ...], float]:
    """Effects and error over noise of a run folder."""
    run = json.loads((output / "run.json").read_text(encoding="utf-8"))
    return tuple(run["effects"]), run["fitted"]["error_over_noise"]


def measure(checkout: Path, work: Path, data: Path, other: Path, command: str) -> Run:
    """One command with an empty cache, then with what the other campaign left in another one."""
    output, left = work / "run", work / f"cache-{checkout.name}-{command}"
    with tempfile.TemporaryDirectory() as empty:
        cold = seconds(checkout, Path(empty), [command, str(data)], output)
    if not left.exists():
        seconds(checkout, left, [command, str(other)], output)
    warm = seconds(checkout, left, [command, str(data)], output)
    return Run(f"{command} {data.name}", cold, warm, *told(output))


def main() -> None:
    """Run the comparison from the command line."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--against", type=Path, help="another checkout of ident")
    parser.add_argument("--long", action="store_true", help="4 and 16 times as many samples too")
    parser.add_argument("--whole", action="store_true", help="one record of 100,000 samples too")
    parser.add_argument("--check", action="store_true", help="assert the targets")
    options = parser.parse_args()
    checkouts = [ROOT, *([options.against.resolve()] if options.against else [])]
    found: dict[str, Run] = {}
    with tempfile.TemporaryDirectory() as folder:
        work = Path(folder)
        other = campaign(work / "other", OTHER, BEFORE, records=5, samples=1300, device="oscillator")
        smooth = campaign(work / "smooth", SEED, SMOOTH)
        sharp = campaign(work / "sharp", SEED, SHARP)
        todo = [(smooth, "fit"), (smooth, "discover"), (sharp, "discover")]
        if options.long:
            todo += [(campaign(work / f"smooth-x{k}", SEED, SMOOTH, samples=k * SAMPLES), "discover") for k in (4, 16)]
        if options.whole:
            todo += [(single(work / f"whole-{e}", SEED, e, LONG), "discover") for e in (SMOOTH, SHARP)]
        for data, command in todo:
            for checkout in checkouts:
                run = measure(checkout, work, data, other, command)
                print(f"{checkout.name:8} {run.what:28} cold {run.cold:6.1f} s  warm {run.warm:6.1f} s  "
                      f"{', '.join(run.named) or 'linear'}: {run.error:.3g}", flush=True)  # fmt: skip
                if checkout is ROOT:
                    found[run.what] = run
    if options.check:
        check(found)


TARGETS = {"fit smooth": (6.0, 2.0), "discover smooth": (20.0, 5.0), "discover sharp": (30.0, 10.0)}
"""CPU seconds, with an empty cache and with another campaign's."""


def check(found: dict[str, Run]) -> None:
    """Assert what was promised."""
    for what, (cold, warm) in TARGETS.items():
        assert found[what].cold <= cold and found[what].warm <= warm, found[what]
    base = found["discover smooth"].warm
    for k in (4, 16):
        if (run := found.get(f"discover smooth-x{k}")) is not None:
            assert run.warm <= k * base, run
    for effect in (SMOOTH, SHARP):
        if (run := found.get(f"discover whole-{effect}")) is not None:
            assert run.warm <= 60.0, run


if __name__ == "__main__":
    main()
