"""Does any input end in an internal error, a hang, or a result that is no number?

`python -m experiments.robust.fuzz --api 3000 --cli 200 --seed 0`. Every input is checked; what a check accepts is
fitted every so often, because a fit takes a second. A hang is more than 5 s of the processor, without compiling.
"""

from __future__ import annotations

import os

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import argparse
import contextlib
import io
import math
import signal
import tempfile
import time
import warnings
from collections import Counter
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

import ident
from ident.cli.main import run

from .inputs import arrays, campaign_values, table_text

LIMIT = 5.0
_FIT_EVERY = 12  # of the inputs that a check accepts


class Hang(BaseException):
    """More than `LIMIT` seconds of the processor; not to be caught on the way."""


def _ring(*_: Any) -> None:
    raise Hang


def judged(work: Callable[[], Any]) -> tuple[str, str]:
    """How a piece of work ends: "fine", "advice", "error", "hang" or "nan"; and what to know of it."""
    signal.signal(signal.SIGPROF, _ring)
    signal.setitimer(signal.ITIMER_PROF, LIMIT)
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            bad = work()
        return ("nan", bad) if bad else ("fine", "")
    except ident.UserError as error:
        text = str(error)
        bad = not text or "\n" in text or len(text) > 2000
        return ("error", f"advice of {len(text)} characters") if bad else ("advice", "")
    except Hang:
        return "hang", ""
    except Exception as error:
        return "error", f"{type(error).__name__}: {error}"[:200]
    finally:
        signal.setitimer(signal.ITIMER_PROF, 0.0)


def no_number(document: Any, at: str = "") -> str:
    """Where a result holds what is no number; "" if nowhere."""
    if isinstance(document, dict):
        return next(filter(None, (no_number(value, f"{at}.{key}") for key, value in document.items())), "")
    if isinstance(document, (list, tuple)):
        return next(filter(None, (no_number(value, f"{at}[{k}]") for k, value in enumerate(document))), "")
    return at if isinstance(document, float) and math.isnan(document) else ""


def api(number: int, seed: int, folder: Path) -> tuple[str, str]:
    """One input through the functions: read and judged, now and then fitted."""
    rng = np.random.default_rng([seed, number])
    kind = number % 3
    if kind == 0:
        file = folder / "a.csv"
        file.write_bytes(table_text(rng).encode("utf-8", "surrogatepass"))
        data: Any = file
    else:
        data = arrays(rng) if kind == 1 else campaign_values(rng)
    found: list[Any] = []

    def look() -> str:
        found.append(ident.check(data))
        return no_number(found[0].as_json())

    told = judged(look)
    if told[0] != "fine" or rng.integers(0, _FIT_EVERY):
        return told

    def fit() -> str:
        fitted = ident.fit(found[0].campaign)
        bad = [e.name for e in fitted.estimates if not math.isfinite(e.value)]
        return ", ".join(bad) or ("" if math.isfinite(fitted.fitted.error_over_noise) else "error over noise")

    return judged(fit)


def cli(number: int, seed: int, folder: Path) -> tuple[str, str]:
    """One input through the command line."""
    rng = np.random.default_rng([seed, number, 7])
    file = folder / f"b{number}.csv"
    file.write_bytes(table_text(rng).encode("utf-8", "surrogatepass"))
    words = {
        0: ["check", str(file)], 1: ["check", str(file), "--json"], 2: ["new", str(folder / f"n{number}"), str(file)],
        3: ["check", str(file), "--columns", str(rng.choice(["time=1,drive=2,response=3", "time=t", "x=1"]))],
        4: ["fit", str(file), "-o", str(folder / f"r{number}"), "--effects", str(rng.choice(["", "cubic-stifness"]))],
    }[number % 5]  # fmt: skip
    out, err = io.StringIO(), io.StringIO()

    def command() -> str:
        with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
            code = run(words)
        last = err.getvalue().strip().splitlines()[-1:] or [""]
        if code not in (0, 2) or "went wrong inside" in err.getvalue() or "Traceback" in err.getvalue():
            raise RuntimeError(f"exit {code}: {last[0]}")
        if any(ord(c) < 32 and c not in "\n\t" for c in out.getvalue() + err.getvalue()):
            raise RuntimeError("a control character was printed")
        return "NaN printed" if "NaN" in out.getvalue() else ""

    return judged(command)


def study(what: Callable[[int, int, Path], tuple[str, str]], count: int, seed: int, first: int = 0) -> Counter[str]:
    """How many inputs end in which way; whatever is a defect is printed with its number."""
    ends: Counter[str] = Counter()
    with tempfile.TemporaryDirectory() as temporary:
        for number in range(first, first + count):
            end, words = what(number, seed, Path(temporary))
            ends[end] += 1
            if end not in ("fine", "advice"):
                print(f"{what.__name__} {number} (seed {seed}): {end} {words}", flush=True)
    return ends


def warm() -> None:
    """The programs that small fits share, so that no compiling counts as a hang."""
    from .inputs import good_columns

    for start in ("rest", "unknown"):
        ident.fit(good_columns(np.random.default_rng(0)), start=start)


def main() -> None:
    """Run the study from the command line."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--api", type=int, default=3000)
    parser.add_argument("--cli", type=int, default=200)
    parser.add_argument("--seed", type=int, default=0)
    told = parser.parse_args()
    warm()
    for what, count in ((api, told.api), (cli, told.cli)):
        began = time.process_time()
        ends = study(what, count, told.seed)
        shown = ", ".join(f"{ends[end]} {end}" for end in ("fine", "advice", "error", "hang", "nan"))
        print(f"{what.__name__}: {count} inputs: {shown}; {time.process_time() - began:.0f} s of CPU", flush=True)


if __name__ == "__main__":
    main()
