"""What the functions of ident cost a Python user who has set no environment variable:
`python -m experiments.benchmarks.in_python`

A script reads a campaign of 7 records of 2400 samples, fits and diagnoses it, with programs that an earlier run has
left; once as it is, and once with OpenBLAS held to one thread from outside. CPU seconds are user and system time of the
whole process. `--against FOLDER` runs it in another checkout of ident too; `--check` asserts that the variable is not
needed.

Measured on two cores that others used: 9.9 and 9.6 s; in the same run, before the functions kept to one thread
themselves, 30.9 and 11.2 s.
"""

from __future__ import annotations

import argparse
import os
import resource
import subprocess
import sys
import tempfile
from pathlib import Path

from experiments.benchmarks.first_run import ROOT, SEED, SMOOTH, campaign

NEEDLESS = 1.3  # times the CPU with the variable: what is left to the noise of a machine
SCRIPT = "import sys, ident; ident.diagnose(ident.fit(ident.read_campaign(sys.argv[1])))"
THREADS = "OPENBLAS_NUM_THREADS"


def seconds(checkout: Path, data: Path, cache: Path, held: bool) -> float:
    """CPU seconds of the script; `held`: with the variable."""
    environment = os.environ | {"PYTHONPATH": str(checkout), "IDENT_CACHE": str(cache), THREADS: "1"}
    environment.pop("PYTHONDONTWRITEBYTECODE", None)  # a user's Python keeps the bytecode of what it has imported
    if not held:
        environment.pop(THREADS)
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    subprocess.run([sys.executable, "-c", SCRIPT, str(data)], env=environment, cwd=checkout, check=True)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def main() -> None:
    """Run the comparison from the command line."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--against", type=Path, help="another checkout of ident")
    parser.add_argument("--check", action="store_true", help="assert that the variable is not needed")
    options = parser.parse_args()
    for checkout in (ROOT, *([options.against.resolve()] if options.against else [])):
        with tempfile.TemporaryDirectory() as folder:
            data, cache = campaign(Path(folder) / "smooth", SEED, SMOOTH), Path(folder) / "cache"
            seconds(checkout, data, cache, True)
            held, free = seconds(checkout, data, cache, True), seconds(checkout, data, cache, False)
        print(f"{checkout.name:8} as it is {free:5.1f} s, with {THREADS}=1 {held:5.1f} s", flush=True)
        assert not options.check or checkout is not ROOT or free < NEEDLESS * held, (free, held)


if __name__ == "__main__":
    main()
