"""How long and how much memory do long records take?  `python -m experiments.benchmarks.long_records [--only NAME]`

One CSV of 2·10⁶ samples, and 200 CSVs of 10⁴, of a linear oscillator solved exactly between samples: `ident check` and
`ident fit` as a user runs them, in processes of their own. Asserts the figures of `docs/speed.md`.
"""

from __future__ import annotations

import argparse
import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import Any

import numpy as np
from scipy.signal import cont2discrete, lfilter

FREQUENCY, QUALITY, NOISE = 480.0, 40.0, 0.02  # Hz, -, of the response's size
CAMPAIGN = """title = "long records"
device = { kind = "oscillator", output = "m" }
[defaults]
start = "rest"
"""
LIMITS = {"one": {"check": 10.0, "fit": 60.0}, "many": {"check": 20.0, "fit": 60.0}}  # s of CPU
MEMORY = 4.0  # GB


def response(drive: np.ndarray, step: float) -> np.ndarray:
    """(n,) of z̈ + (ω₀/Q) ż + ω₀² z = ω₀² u from rest, the drive a straight line between samples."""
    w = 2 * np.pi * FREQUENCY
    system = ([w * w], [1.0, w / QUALITY, w * w])
    exact: Any = cont2discrete(system, step, method="foh")
    return np.asarray(lfilter(np.ravel(exact[0]), exact[1], drive))


def write(folder: Path, records: int, samples: int, rate: float) -> Path:
    """A campaign of sines of several levels and frequencies; the last record is held out if there are several."""
    folder.mkdir()
    rng, lines = np.random.default_rng(11), [CAMPAIGN]
    for k in range(records):
        t = np.arange(samples) / rate
        drive = (1 + k % 5) * np.sin(2 * np.pi * FREQUENCY * (0.9 + 0.02 * (k % 11)) * t)
        clean = 1e-6 * response(drive, 1 / rate)
        noisy = clean + NOISE * np.std(clean) * rng.standard_normal(samples)
        table = np.column_stack([t, drive, 1e6 * noisy])
        name = f"record_{k:03d}.csv"
        np.savetxt(folder / name, table, "%.8g,%.6g,%.6g", header="time (s),drive (V),displacement (um)", comments="")
        held = "holdout = true\n" if records > 1 and k == records - 1 else ""
        lines.append(f'[[record]]\nfile = "{name}"\n{held}')
    (folder / "campaign.toml").write_text("\n".join(lines), encoding="utf-8")
    return folder


def measure(*words: str) -> tuple[float, float, float]:
    """Seconds of CPU and of wall clock and gigabytes at most of one `ident` command."""
    code = "import resource, sys; from ident.cli.main import main; sys.argv[0] = 'ident'\n" \
           "try: code = main()\nexcept SystemExit as stopped: code = stopped.code\n" \
           "used = resource.getrusage(resource.RUSAGE_SELF)\n" \
           "print(used.ru_utime + used.ru_stime, used.ru_maxrss, file=sys.stderr); sys.exit(code)"  # fmt: skip
    began = time.perf_counter()
    done = subprocess.run((sys.executable, "-c", code, *words), capture_output=True, text=True, check=False)
    seconds = time.perf_counter() - began
    if done.returncode:
        raise SystemExit(f"ident {' '.join(words)}: {done.stderr[-2000:]}")
    cpu, memory = map(float, done.stderr.split()[-2:])
    return cpu, seconds, memory / 2**20


def main() -> None:
    """Run the benchmark from the command line."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--only", choices=["one", "many"])
    parser.add_argument("--keep", type=Path, help="write the campaigns there, or take those that are there")
    told = parser.parse_args()
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    with tempfile.TemporaryDirectory() as scratch:
        home = told.keep or Path(scratch)
        home.mkdir(parents=True, exist_ok=True)
        for name, records, samples, rate in (("one", 1, 2_000_000, 100_000.0), ("many", 200, 10_000, 20_000.0)):
            if told.only in (None, name):
                folder = home / name
                folder = folder if folder.exists() else write(folder, records, samples, rate)
                for command, words in (("check", ()), ("fit", ("-o", str(Path(scratch) / f"run-{name}")))):
                    cpu, wall, memory = measure(command, str(folder), *words)
                    print(f"{command} of {records} × {samples}: {cpu:.1f} s of CPU, {wall:.1f} s, {memory:.2f} GB")
                    assert cpu <= LIMITS[name][command] and memory <= MEMORY, "more than docs/speed.md says"


if __name__ == "__main__":
    main()
