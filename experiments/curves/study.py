"""What curves can tell: the hidden-effect study on sweeps.  `python -m experiments.curves.study --part phase --limit 8`

Devices of an independent simulator hide an effect, or none, and are swept up and down at four levels. Each case is
written to a folder in one of the styles of laboratories, read back, and handed to the tool, which estimates the noise
itself. Finished cases are kept in `results/`, one line each, so that an interrupted run goes on where it stopped;
`--again` forgets them. The table is printed, and with `--check` its targets are asserted.

Seeds 0-999 served to find mistakes; figures to be quoted are of seeds from 5000 on.
"""

from __future__ import annotations

import os

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # its threads wait by spinning, beside those of XLA; before NumPy

import argparse
import itertools
import json
import tempfile
import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any, Literal

import numpy as np

from ident import runtime

runtime.configure()

from experiments.hidden_effects.laws import INDEX, LAWS  # noqa: E402
from experiments.hidden_effects.tables import FAILS  # noqa: E402
from ident.campaign import read_campaign  # noqa: E402  (JAX must be configured first)
from ident.diagnosis.diagnose import discover  # noqa: E402
from ident.errors import UserError  # noqa: E402

from .classes import ALIKE, SEEN  # noqa: E402
from .files import STYLES, write  # noqa: E402
from .generator import Case, Noise, draw  # noqa: E402
from .mimics import SEEN as TOLD_APART  # noqa: E402
from .mimics import left_by  # noqa: E402

Part = Literal["phase", "amplitude", "nulls"]
Row = dict[str, Any]
RESULTS = Path(__file__).parent / "results"
SEEDS: dict[Part, range] = {"phase": range(5000, 5002), "amplitude": range(5000, 5002), "nulls": range(5000, 5200)}
SIZES = (0.05, 0.3)
NULL_NOISE = (Noise(3e-4, 5e-4, 5e-4), Noise(), Noise(5e-3, 0.0, 5e-3), Noise(1e-3, 0.01, 0.01))
_REACHED = 0.5  # of the size that was asked for, without which an effect is not a case: it cannot be made so large


@dataclass(frozen=True)
class Task:
    """One case: `size`, misfit that the effect gives the best linear oscillator; `noise`: which of `NULL_NOISE`."""

    part: Part
    seed: int
    effects: tuple[str, ...]
    size: float
    noise: int = 1

    @property
    def key(self) -> str:
        """What tells the cases of a file of results apart."""
        return "/".join(str(value) for value in asdict(self).values())


def tasks(part: Part, seeds: Sequence[int], effects: Sequence[str] | None = None) -> Iterator[Task]:
    """The cases of a part."""
    if part == "nulls":
        for seed in seeds:
            yield Task(part, seed, (), 0.0, seed % len(NULL_NOISE))
        return
    for seed, size, name in itertools.product(seeds, SIZES, effects or SEEN):
        yield Task(part, seed, (name,), size)


def run(task: Task) -> Row:
    """Draw a case, write it as a laboratory would, let the tool discover, and note what it said beside what is true."""
    case = draw(task.seed, task.effects, size=task.size, noise=NULL_NOISE[task.noise])
    laws: Any = case.truth["laws"]
    row: Row = {"key": task.key, **asdict(task), "laws": laws}
    if any(law["size"] < _REACHED * task.size for law in laws.values()):
        return row | {"visible": False}
    style = STYLES[task.seed % len(STYLES)]
    phase = task.part != "amplitude" and not (task.part == "nulls" and task.seed % 3 == 0)
    with tempfile.TemporaryDirectory() as folder:
        write(case, Path(folder), style, phase)
        try:
            campaign = read_campaign(folder)
        except UserError as error:  # a platform that moves by a millimetre is no device
            return row | {"visible": False, "refused": str(error)}
    began = time.process_time()
    found = discover(campaign).discovery
    deviation = np.median(np.concatenate([sweep.deviation for sweep in campaign.sweeps]))
    clean = np.abs(np.concatenate([curve.clean for curve in case.curves]))
    true = np.median(np.hypot(float(case.truth["sigma"]), NULL_NOISE[task.noise].relative * clean))  # type: ignore[arg-type]
    row |= {
        "visible": True,
        "style": style,
        "verdict": found.verdict,
        "steps": [
            {"added": s.added, "role": s.role, "ties": list(s.tie_set[1:]), "confirmed": round(s.confirmed_gain, 5)}
            for s in found.steps
        ],
        "before": round(found.start.fitted.error_over_noise, 4),
        "after": round(found.final.fitted.error_over_noise, 4),
        "sigma_ratio": round(float(deviation / true), 3),
        "cpu_seconds": round(time.process_time() - began, 1),
    }
    return row if task.part == "nulls" else row | _as_good(row, case)


def _as_good(row: Row, case: Case) -> Row:
    """How well a name outside the class could pass for the hidden effect on this case's curves."""
    first = named(row)[:1]
    if in_class(row) or not first or first[0] not in INDEX:
        return {}
    return {"left_by_name": round(left_by(case, first[0], row["part"] == "phase"), 1)}


def named(row: Row) -> list[str]:
    """What the tool names; what only refines a shape is none."""
    return [step["added"] for step in row["steps"] if step["role"] == "effect"]


def class_of(row: Row) -> set[str]:
    """The hidden effect, and those that curves of this kind do not tell from it."""
    name = row["effects"][0]
    return {name, *ALIKE[row["part"] == "phase"].get(name, ())}


def in_class(row: Row) -> bool:
    return bool(class_of(row) & set(named(row)[:1]))


def first_right(row: Row) -> bool:
    """Whether the first name is of the class, or such that even an observer who knew both laws could not have told it
    from the hidden one on these curves."""
    return in_class(row) or row.get("left_by_name", np.inf) < TOLD_APART


def in_tie_set(row: Row) -> bool:
    """Whether the hidden effect itself, or one that no record of any kind tells from it, is among what the first step
    leaves open: the library's arch force is a part of residual stress, and alone it is a quadratic spring."""
    first = row["steps"][0] if row["steps"] else {"added": "", "ties": []}
    name = row["effects"][0]
    return bool({name, *LAWS[INDEX[name]].alike} & {first["added"], *first["ties"]})


def alarm(row: Row) -> bool:
    return bool(named(row))


def share(rows: Sequence[Row], holds: Callable[[Row], bool]) -> float:
    return float(np.mean([holds(row) for row in rows])) if rows else float("nan")


def show(part: Part, rows: Sequence[Row]) -> None:
    """Print the table of a part, and every case that went wrong."""
    seen, small = to_be_seen(rows), sum(not row["visible"] for row in rows)
    print(f"\n{part}: {len(seen)} cases; {small} effects could not be made as large as asked, and the linear model "
          f"describes {len(rows) - small - len(seen)}")  # fmt: skip
    if not seen:
        return
    ratios = [row["sigma_ratio"] for row in seen]
    print(f"noise estimated over true: median {np.median(ratios):.2f}, {min(ratios):.2f} to {max(ratios):.2f}; "
          f"processor time {np.median([row['cpu_seconds'] for row in seen]):.1f} s a case")  # fmt: skip
    if part == "nulls":
        print(
            f"false alarms: {sum(map(alarm, seen))} of {len(seen)}; before {np.median([r['before'] for r in seen]):.3f}"
        )
        for row in filter(alarm, seen):
            print(f"  alarm: {told(row)}")
        return
    print(f"{'size':>6} {'n':>4} {'class first':>12} {'by name':>8} {'in tie set':>11}  error over noise before, after")
    for size in SIZES:
        some = [row for row in seen if row["size"] == size]
        if some:
            errors = (np.median([row[when] for row in some]) for when in ("before", "after"))
            print(f"{size:6.0%} {len(some):4d} {share(some, first_right):12.3f} {share(some, in_class):8.3f} "
                  f"{share(some, in_tie_set):11.3f}  "
                  + " ".join(f"{error:.3g}" for error in errors))  # fmt: skip
    for row in seen:
        if in_class(row) and in_tie_set(row):
            continue
        what = "not in the tie set" if in_class(row) else "as good" if first_right(row) else "missed"
        passes = f"; the first name leaves χ² = {row['left_by_name']}" if "left_by_name" in row else ""
        print(f"  {what}: {told(row)}{passes}")


def told(row: Row) -> str:
    """A case and what was said of it, in one line."""
    steps = " > ".join(f"{'/'.join([s['added'], *s['ties']])} ({s['role']})" for s in row["steps"]) or "nothing"
    hidden = " + ".join(row["effects"]) or "nothing hidden"
    return (f"seed {row['seed']}, {hidden}, size {row['size']:.0%}, {row['style']}: {row['verdict']}, {steps}; "
            f"error over noise {row['before']} -> {row['after']}")  # fmt: skip


def to_be_seen(rows: Sequence[Row]) -> list[Row]:
    """The cases in which the linear model fails: of a lag, say, nearly all is phase, and amplitudes do not show it."""
    return [row for row in rows if row["visible"] and (row["part"] == "nulls" or row["before"] > FAILS)]


def check(part: Part, rows: Sequence[Row]) -> None:
    """Assert that a part meets its targets."""
    seen = to_be_seen(rows)
    if part == "nulls":
        assert share(seen, alarm) <= 0.01, share(seen, alarm)
    elif part == "phase":
        assert share(seen, first_right) >= 0.95, share(seen, first_right)
    else:
        assert share(seen, in_tie_set) >= 0.98, share(seen, in_tie_set)


def main() -> None:
    """Run the study from the command line."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--part", choices=list(SEEDS), action="append", help="default: all")
    parser.add_argument("--seeds", type=int, nargs="+", help="default: those of the report")
    parser.add_argument("--effects", help="names with commas between them, instead of all")
    parser.add_argument("--limit", type=int, help="compute at most so many cases now")
    parser.add_argument("--again", action="store_true", help="forget what was computed before")
    parser.add_argument("--check", action="store_true", help="assert the targets")
    options = parser.parse_args()
    RESULTS.mkdir(exist_ok=True)
    for part in options.part or SEEDS:
        path = RESULTS / f"{part}.jsonl"
        if options.again:
            path.unlink(missing_ok=True)
        lines = path.read_text(encoding="utf-8").splitlines() if path.exists() else []
        done = {row["key"]: row for row in map(json.loads, lines)}
        todo = list(tasks(part, options.seeds or SEEDS[part], options.effects and options.effects.split(",")))
        for task in [task for task in todo if task.key not in done][: options.limit]:
            done[task.key] = run(task)
            with path.open("a", encoding="utf-8") as file:
                file.write(json.dumps(done[task.key], default=float) + "\n")
        rows = [done[task.key] for task in todo if task.key in done]
        show(part, rows)
        if options.check:
            check(part, rows)


if __name__ == "__main__":
    main()
