"""Records as other laboratories write them: `python -m experiments.other_labs [SEED] [device…]`

Driven by sines, chirps, multisines, noise, steps, blows and decays, with offsets, rounded times, few bits and coloured
noise; SciPy's adaptive solver, force laws written here. Each is given to `ident new` and `ident discover`, whose word
is final. Asserted: the hidden effect is named or a tie names it, nothing else is, what the library cannot have is not
called known but described, held-out error does not grow, and the noise floor is reached unless it stands beside the
device that it is not.
"""

from __future__ import annotations

import json
import os
import re
import resource
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np

from . import DEVICES, Lab, judge


def discovered(name: str, seed: int, folder: Path) -> tuple[dict, float]:
    """diagnosis.json of `ident discover` on the campaign that `ident new` writes, and CPU seconds."""
    rng = np.random.default_rng([seed, list(DEVICES).index(name)])
    lab = Lab(folder, rng)
    DEVICES[name].write(lab, rng)
    ident, here = [sys.executable, "-m", "ident"], os.environ | {"OPENBLAS_NUM_THREADS": "1"}
    files = sorted(map(str, folder.glob("*.csv")))
    subprocess.run([*ident, "new", str(folder / "mine"), *files], env=here, check=True, capture_output=True)
    toml = folder / "mine" / "campaign.toml"
    text = re.sub(r"^holdout = true.*\n", "", toml.read_text(), flags=re.M)
    for held in lab.held:
        text = re.sub(rf'(^file = ".*{held}"\n)', r"\1holdout = true\n", text, flags=re.M)
    if "\ndevice = " not in text:  # V and µm are those of the platform: say that it is none
        text = text.replace("[model]", 'device = { kind = "oscillator", output = "m" }\n[model]', 1)
    toml.write_text(text)
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    command = [*ident, "discover", str(toml.parent), "-o", str(folder / "run")]
    subprocess.run(command, env=here, check=True, capture_output=True)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    seconds = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    return json.loads((folder / "run" / "diagnosis.json").read_text()), seconds


def main() -> None:
    """Run the devices that are named, or all, and assert what stands beside them."""
    seed, wrong = int(sys.argv[1]) if len(sys.argv) > 1 else 1, list[str]()
    for name in sys.argv[2:] or DEVICES:
        try:
            with tempfile.TemporaryDirectory() as folder:
                found, seconds = discovered(name, seed, Path(folder))
        except subprocess.CalledProcessError as crash:
            print(f"{name:20s} crash: {crash.stderr.decode().splitlines()[-1]}", flush=True)
            wrong.append(name)
            continue
        start, final, verdict = found["start"], found["final"], judge(name, found)
        told = lambda what: f"{what['error_over_noise']:.2f} | {what['holdout_error_over_noise']:.2f}"
        words = f"{verdict:20s} {found['verdict']:15s} {', '.join(final['effects']) or '-'}"
        print(f"{name:20s} {words}: {told(start)} → {told(final)}, {seconds:.0f} s", flush=True)
        held, floor = (
            final["holdout_error_over_noise"],
            max(final["error_over_noise"], final["holdout_error_over_noise"]),
        )
        kept = held <= 1.02 * start["holdout_error_over_noise"] and (floor < 1.2 or not DEVICES[name].floor)
        wrong += [] if verdict.startswith("right") and kept else [name]
    assert not wrong, wrong


if __name__ == "__main__":
    main()
