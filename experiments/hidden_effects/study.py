"""Which physics is missing? The hidden-effect study.  `python -m experiments.hidden_effects.study --part single`

Devices of an independent simulator, with force laws of their own, hide one effect, two, none, or one that no library
has; the tool sees the records, estimates the noise floors itself, and says what is missing. Finished cases are kept in
`results/`, one line each, so that an interrupted run goes on where it stopped; `--again` forgets them. All records have
one length and one number of samples per period, so that the programs compile once. The tables are printed, and with
`--check` their targets are asserted.

Seeds 0-999 served to find mistakes; the figures in `README.md` are of seeds from 5000 on.
"""

from __future__ import annotations

import os

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # its threads wait by spinning, beside those of XLA; before NumPy

import argparse
import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn

from ident import runtime

runtime.configure()

from . import tables  # noqa: E402  (JAX must be configured first)
from .parts import Part, Task, run, tasks  # noqa: E402

RESULTS = Path(__file__).parent / "results"
PARTS: dict[Part, range] = {
    "single": range(5000, 5002),
    "pairs": range(5000, 5040),
    "nulls": range(5000, 5500),
    "outside": range(5000, 5005),
    "poor": range(5000, 5002),
    "cut": range(5000, 5002),
    "steady": range(5000, 5002),
    "circumstances": range(5000, 5012),
    "long": range(5000, 5001),
}
"""Parts and the seeds of the report."""


def work(todo: Sequence[Task], path: Path, limit: int | None = None) -> list[dict[str, Any]]:
    """The results of the tasks in `path`; at most `limit` of those that it lacks are computed and added."""
    path.parent.mkdir(parents=True, exist_ok=True)
    lines = path.read_text(encoding="utf-8").splitlines() if path.exists() else []
    done = {row["key"]: row for row in map(json.loads, lines)}
    missing = [task for task in todo if task.key not in done][:limit]
    columns = (TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), TimeRemainingColumn())
    with path.open("a", encoding="utf-8") as file, Progress(*columns) as bar:
        shown = bar.add_task("", total=len(missing))
        for task in missing:
            bar.update(shown, description=f"{' + '.join(task.effects) or 'null'}, seed {task.seed}")
            done[task.key] = run(task)
            file.write(json.dumps(done[task.key], default=float) + "\n")
            file.flush()
            bar.advance(shown)
    return [done[task.key] for task in todo if task.key in done]


def seeds_of(text: str) -> list[int]:
    """ "3,7,10-12" as a list."""
    found: list[int] = []
    for piece in text.split(","):
        first, _, last = piece.partition("-")
        found += range(int(first), int(last or first) + 1)
    return found


def levels_of(text: str) -> list[tuple[float, float]]:
    """ "2:0.3,8:1", sizes and noise in percent, as fractions."""
    pairs = (piece.split(":") for piece in text.split(","))
    return [(float(size) / 100, float(noise) / 100) for size, noise in pairs]


def main() -> None:
    """Run the study from the command line."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--part", choices=list(PARTS), action="append", help="default: all")
    parser.add_argument("--seeds", type=seeds_of, help='"0", "0-59" or "1,5,7-9"; default: those of the report')
    parser.add_argument("--effects", help="names with commas between them, instead of all")
    parser.add_argument("--levels", type=levels_of, help='size:noise in percent, "2:0.3,8:1", instead of the part\'s')
    parser.add_argument("--limit", type=int, help="compute at most so many cases now")
    parser.add_argument("--results", type=Path, default=RESULTS, help="folder of the results")
    parser.add_argument("--again", action="store_true", help="forget what was computed before")
    parser.add_argument("--show", action="store_true", help="only print the tables of what has been computed")
    parser.add_argument("--check", action="store_true", help="assert the targets")
    options = parser.parse_args()
    effects = options.effects.split(",") if options.effects else None
    for part in options.part or PARTS:
        path = options.results / f"{part}.jsonl"
        if options.again:
            path.unlink(missing_ok=True)
        todo = tasks(part, options.seeds or PARTS[part], effects, options.levels)
        rows = work(todo, path, 0 if options.show else options.limit)
        tables.show(part, rows)
        if options.check:
            tables.check(part, rows)


if __name__ == "__main__":
    main()
