"""kill -9 at random moments of `ident sample`: does `--resume` end with the chain of an undisturbed run, bit by bit?

    python -m experiments.posterior.kill --kills 20

One run is sampled in peace. A copy of it is sampled too, killed at a random moment, resumed, killed again, until it
ends; then its chain is compared, dataset by dataset and generator by generator, and all begins anew, until there were
so many kills. Then a chain that is cut short, or of another seed, must be refused in one line.
"""

from __future__ import annotations

import argparse
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

DATA = Path(__file__).resolve().parents[2] / "data" / "oscillator"
_LIMIT = 600.0  # s that one command may take


def command(*words: str | Path) -> list[str]:
    """`ident …` by this interpreter."""
    return [sys.executable, "-m", "ident", *map(str, words)]


def content(chain: Path) -> dict[str, bytes]:
    """Every dataset and attribute of a chain file."""
    import h5py

    found: dict[str, bytes] = {}
    with h5py.File(chain, "r") as file:
        take = lambda name, item: found.update(
            {f"{name}@{key}": np.asarray(value).tobytes() for key, value in item.attrs.items() if key != "taus"}
            | ({name: item[()].tobytes()} if isinstance(item, h5py.Dataset) else {})
        )
        file.visititems(take)
        found["taus"] = np.asarray(file.attrs["taus"]).tobytes()
    return found


def disturbed(run: Path, moments: np.random.Generator, longest: float, kills: int) -> int:
    """Sample `run` to its end, killed at random moments at most `kills` times; returns how often it was."""
    killed = 0
    while True:
        resumable = (run / "chain.h5").exists()
        process = subprocess.Popen(
            command("sample", run, "--resume" if resumable else "--force"),
            stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True,
        )  # fmt: skip
        wait = float(moments.uniform(0.0, longest)) if killed < kills else _LIMIT
        try:
            _, said = process.communicate(timeout=wait)
        except subprocess.TimeoutExpired:
            process.send_signal(signal.SIGKILL)
            process.communicate()
            killed += 1
            continue
        assert process.returncode == 0, said
        return killed


def refused(run: Path, *options: str) -> str:
    """The one line with which `--resume` refuses a chain."""
    done = subprocess.run(
        command("sample", run, "--resume", *options), capture_output=True, text=True, timeout=_LIMIT, check=False
    )
    lines = [line for line in done.stderr.splitlines() if line.startswith("ident: ")]
    assert done.returncode == 2 and len(lines) == 1 and "Traceback" not in done.stderr, (done.returncode, done.stderr)
    return lines[0]


def study(kills: int, seed: int, source: Path = DATA, effects: str = "cubic-stiffness") -> tuple[int, list[str]]:
    """Chains that came out the same (all must), and the refusals."""
    moments, chains = np.random.default_rng(seed), 0
    with TemporaryDirectory() as folder:
        peace, war = Path(folder) / "peace", Path(folder) / "war"
        subprocess.run(command("fit", source, "--effects", effects, "-o", peace), check=True, capture_output=True)
        shutil.copytree(peace, war)
        subprocess.run(command("sample", peace), check=True, capture_output=True)  # compiles what it needs
        begun = time.monotonic()
        subprocess.run(command("sample", peace, "--force"), check=True, capture_output=True)
        longest, expected = time.monotonic() - begun, content(peace / "chain.h5")
        while kills > 0:
            killed = disturbed(war, moments, longest, kills)
            assert content(war / "chain.h5") == expected, "a resumed chain is not that of the undisturbed run"
            kills, chains = kills - killed, chains + 1
            print(f"killed {killed} times, then the same; {kills} to go", flush=True)
            whole = (war / "chain.h5").read_bytes()
            (war / "chain.h5").unlink()
        (war / "chain.h5").write_bytes(whole[: len(whole) // 2])
        told = [refused(war)]
        (war / "chain.h5").write_bytes(whole)
        told.append(refused(war, "--seed", "1"))
    return chains, told


def main() -> None:
    """Kill, compare, and print what happened."""
    parser = argparse.ArgumentParser()
    parser.add_argument("--kills", type=int, default=20)
    parser.add_argument("--seed", type=int, default=0)
    told = parser.parse_args()
    chains, refusals = study(told.kills, told.seed)
    print(f"killed {told.kills} times: {chains} chains, each bit for bit that of the undisturbed run")
    for line in refusals:
        print(f"refused: {line}")


if __name__ == "__main__":
    main()
