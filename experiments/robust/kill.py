"""Is a run ever lost if the process that writes it is killed?  `python -m experiments.robust.kill --times 100 --seed 0`

`ident fit --force`, `add --force` and `discover --force` write over a run that is there, and are killed (SIGKILL) at a
random moment of the time that they take undisturbed, half of them while they write their folder. After each, the folder
must hold a whole run, the old one or the new one, and the next run must succeed and leave nothing beside it.
"""

from __future__ import annotations

import argparse
import json
import os
import signal
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np

from ident.report.run_folder import load_run, write_run

ROOT = Path(__file__).resolve().parents[2]
COMMANDS = ("fit", "add", "discover")


def campaign(folder: Path) -> Path:
    """A small oscillator whose cubic stiffness is left out, simulated without the model under test."""
    rng = np.random.default_rng(5)
    n, step, fine = 700, 1 / 2000.0, 8
    t = step * np.arange(n)
    z, v, out = 0.0, 0.0, []
    for k in range(n):
        out.append(z)
        for j in range(fine):  # symplectic Euler at an eighth of the sampling interval
            force = 3.0 * np.sin(2 * np.pi * 70 * (t[k] + j * step / fine))
            v += step / fine * (2e5 * force - (2 * np.pi * 71) ** 2 * z - 2 * np.pi * 71 / 15 * v - 6e4 * z**3)
            z += step / fine * v
    drive = 3.0 * np.sin(2 * np.pi * 70 * t)
    response = np.array(out) + 0.01 * rng.standard_normal(n)
    rows = "\n".join(f"{a:.9g},{b:.9g},{c:.9g}" for a, b, c in zip(t, drive, response, strict=True))
    (folder / "a.csv").write_text(f"time (s),drive (V),response (V)\n{rows}\n", encoding="utf-8")
    text = 'device = { kind = "oscillator", output = "V" }\n[[record]]\nfile = "a.csv"\nstart = "rest"\n'
    (folder / "campaign.toml").write_text(text, encoding="utf-8")
    return folder


def words(command: str, home: Path) -> list[str]:
    """The command line, which writes `home/run`."""
    told = {"fit": ["fit", "data"], "add": ["add", "parent", "cubic-stiffness"], "discover": ["discover", "data"]}
    return [sys.executable, "-m", "ident", *told[command], "-o", "run", "--force"]


def start(command: str, home: Path) -> subprocess.Popen[bytes]:
    """The process."""
    environment = os.environ | {"PYTHONPATH": str(ROOT)}
    return subprocess.Popen(
        words(command, home), cwd=home, env=environment, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE
    )  # fmt: skip


def undisturbed(command: str, home: Path) -> float:
    """Seconds that the command takes."""
    began = time.monotonic()
    process = start(command, home)
    _, said = process.communicate()
    assert process.returncode == 0, said.decode()
    return time.monotonic() - began


def kill_once(command: str, home: Path, rng: np.random.Generator, seconds: float) -> bool:
    """Start, kill, look: whether a whole run is there. Every other kill waits for the folder to be written."""
    process = start(command, home)
    if rng.random() < 0.5:
        time.sleep(rng.uniform(0.0, seconds))
    else:
        end = time.monotonic() + 3 * seconds
        while process.poll() is None and time.monotonic() < end and not list(home.glob(".ident-*")):
            time.sleep(1e-3)
        time.sleep(rng.uniform(0.0, 0.05 * seconds))
    process.send_signal(signal.SIGKILL)
    process.communicate()
    try:
        json.loads((home / "run" / "run.json").read_text(encoding="utf-8"))
        load_run(home / "run")
    except Exception as error:
        print(f"{command}: the run is lost: {error}", flush=True)
        return False
    return True


def study(times: int, seed: int) -> tuple[int, int]:
    """How many of the kills lost a run, and how many folders were left beside it after one more run."""
    rng, lost = np.random.default_rng(seed), 0
    with tempfile.TemporaryDirectory() as temporary:
        home = Path(temporary)
        (home / "data").mkdir()
        campaign(home / "data")
        import ident

        write_run(ident.fit(home / "data"), home / "parent", page=False)
        taken = {command: undisturbed(command, home) for command in COMMANDS[: max(1, min(times, 3))]}
        for number in range(times):
            command = COMMANDS[number % len(taken)]
            lost += not kill_once(command, home, rng, taken[command])
        undisturbed("fit", home)
        left = [entry.name for entry in home.iterdir() if entry.name.startswith(".ident-")]
    return lost, len(left)


def main() -> None:
    """Run the study from the command line."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--times", type=int, default=100)
    parser.add_argument("--seed", type=int, default=0)
    told = parser.parse_args()
    lost, left = study(told.times, told.seed)
    print(f"{told.times} kills: {lost} runs lost, {left} folders left beside the run after the next one")


if __name__ == "__main__":
    main()
