"""Run the commands of the documents and hold every excerpt and number to what comes out.

`python -m experiments.docs_numbers [FOLDER]`; run folders are left in FOLDER if it is given, where a check that was
stopped goes on. `--figure` draws the figures of the tutorial and of the README again.
"""

from __future__ import annotations

import argparse
import json
import os
import re
import shlex
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

ROOT = Path(__file__).resolve().parents[1]
TUTORIAL = ROOT / "docs" / "tutorial.md"
README = ROOT / "README.md"
FIGURES = ROOT / "docs" / "figures"
README_RUN = "ident fit data/platform_317hz -o runs/paper"

_NUMBER = re.compile(r"[-−]?\d+(?:\.\d+)?(?:e[-−]?\d+)?")
_RELATIVE, _ABSOLUTE = 0.02, 0.021  # another processor's last digits may differ; a number that means another thing not


class Claim(NamedTuple):
    """A number that stands in prose: the document, the words around it (one group), and where the truth is."""

    document: str
    words: str
    run: str
    path: tuple[str, ...]
    scale: float = 1.0


CLAIMS = (
    Claim("docs/tutorial.md", r"`voltage_force`, (\d+) standard errors", "stress", ("ratio", "voltage_force")),
    Claim("docs/tutorial.md", r"friction is ([\d.]+) ±", "friction", ("value", "coulomb-friction.friction"), 1e6),
    Claim("README.md", r"are ([\d.]+) \| [\d.]+ on `data/platform_317hz`", "paper", ("fitted", "error_over_noise")),
    Claim("README.md", r"are [\d.]+ \| ([\d.]+) on `data/platform_317hz`", "paper", ("holdout", "error_over_noise")),
)


def steps(page: str) -> Iterator[tuple[str, list[str]]]:
    """Each command of a page with the lines of its output that are shown before the next command.

    A line that starts with four spaces goes on with the one before: the page breaks what the terminal does not.
    """
    command, shown = "", []
    for language, text in re.findall(r"^```(\w+)\n(.*?)^```", page, re.MULTILINE | re.DOTALL):
        if language == "bash":
            if command:
                yield command, shown
            command, shown = text.strip(), []
        elif language == "text":
            whole = re.sub(r"\n {4}(?=\S)", " ", text)
            shown += [line for line in whole.splitlines() if line.strip() not in ("", "…")]
    if command:
        yield command, shown


def run(command: str, work: Path) -> str:
    """What one `ident` command prints."""
    words = shlex.split(command)
    environment = os.environ | {"PYTHONPATH": os.pathsep.join(filter(None, (str(ROOT), os.environ.get("PYTHONPATH"))))}
    done = subprocess.run(
        (sys.executable, "-m", "ident.cli.main", *words[1:]), cwd=work, env=environment | {"COLUMNS": "100"},
        stdout=subprocess.PIPE, encoding="utf-8", check=True,
    )  # fmt: skip
    return done.stdout


def same(shown: str, printed: str) -> bool:
    """Whether two lines say the same: equal words, numbers equal but for their last digits."""
    if _NUMBER.sub("#", shown).split() != _NUMBER.sub("#", printed).split():
        return False
    pairs = zip(_NUMBER.findall(shown), _NUMBER.findall(printed), strict=True)
    return all(_close(float(a.replace("−", "-")), float(b.replace("−", "-"))) for a, b in pairs)


def _close(a: float, b: float) -> bool:
    return abs(a - b) <= max(_ABSOLUTE, _RELATIVE * abs(b))


def value(document: dict[str, Any], path: tuple[str, ...]) -> float:
    """A number of run.json; "value" and "ratio" (value over standard error) look a parameter up by its name's end."""
    if path[0] in ("value", "ratio"):
        found = next(p for p in document["parameters"] if p["name"].endswith(path[1]))
        return found["value"] / (found["standard_error"] if path[0] == "ratio" else 1.0)
    inner: Any = document
    for key in path:
        inner = inner[key]
    return float(inner)


def check_claims(work: Path) -> list[str]:
    """Claims of the prose that do not hold."""
    wrong = []
    for claim in CLAIMS:
        document = json.loads((work / "runs" / claim.run / "run.json").read_text(encoding="utf-8"))
        true = claim.scale * value(document, claim.path)
        found = re.search(claim.words, (ROOT / claim.document).read_text(encoding="utf-8"))
        if found is None or not _close(float(found[1]), true):
            wrong.append(f"{claim.document}: {claim.words} is {true:.6g}")
    return wrong


def draw(work: Path) -> None:
    """The figures of the tutorial and of the README: what models leave of one record, and their errors."""
    stress, friction = {"residual-stress": "stress"}, {"+ coulomb-friction": "friction"}
    guess = {"+ prandtl-ishlinskii": "guess"}
    _leaves(work, stress | guess | friction, ["stress\nalone", "with\nhysteresis", "with\nfriction"], "tutorial.png")
    _leaves(work, stress | friction, ["stress\nalone", "with\nfriction"], "first_run.png")


def _leaves(work: Path, models: dict[str, str], names: list[str], file: str) -> None:
    """Residual of a record under each model, one below the other, beside the errors on fitted and held-out records."""
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    from ident import load_run

    count = len(models)
    tall = 0.75 + 1.28 * count  # inches: a strip for each model, and the labels below
    figure = plt.figure(figsize=(10, tall))
    bottoms = [(0.55 + 1.28 * (count - 1 - k)) / tall for k in range(count)]
    left = [figure.add_axes((0.075, bottom, 0.52, 1.0 / tall)) for bottom in bottoms]
    right = figure.add_axes((0.70, 0.6 / tall, 0.28, (tall - 1.0) / tall))
    errors = []
    for axes, (name, folder) in zip(left, models.items(), strict=True):
        fit = load_run(work / "runs" / folder)
        traces = fit.campaign.traces
        index = next(i for i, trace in enumerate(traces) if trace.name == "sine_3V_500Hz.csv")
        record, floor = traces[index], fit.scores[index].noise_rmse
        axes.axhspan(-2e9 * floor, 2e9 * floor, color="0.88")
        axes.plot(record.time * 1e3, 1e9 * (record.response - fit.readings[index]), lw=0.7, color="#0072B2")
        axes.set(xlim=(0, record.time[-1] * 1e3), ylim=(-720, 720))
        axes.set_title(name, loc="left", fontsize=10, pad=3)
        axes.tick_params(labelbottom=axes is left[-1])
        assert fit.holdout is not None
        errors.append((fit.fitted.error_over_noise, fit.holdout.error_over_noise))
    figure.text(0.012, 0.5, "measured − model (nm)", rotation=90, va="center", fontsize=9)
    left[-1].set_xlabel("time (ms), record at 3 V, 500 Hz; shaded: ±2 noise floors")
    at = np.arange(count)[::-1]
    for k, (label, colour) in enumerate((("fitted", "#0072B2"), ("held out", "#E69F00"))):
        bars = right.barh(at + 0.19 - 0.38 * k, [e[k] for e in errors], 0.36, color=colour, label=label)
        right.bar_label(bars, fmt="%.2f", padding=3, fontsize=9)
    right.axvline(1.0, color="0.2", lw=1)
    right.set(yticks=at, yticklabels=names, xlim=(0, 12.2))
    right.set_xlabel("error over noise floor (line: 1)")
    right.legend(loc="lower right", frameon=False, fontsize=9)
    for axes in (*left, right):
        axes.spines[["top", "right"]].set_visible(False)
    FIGURES.mkdir(exist_ok=True)
    figure.savefig(FIGURES / file, dpi=100)
    plt.close(figure)


def main(work: Path, figure: bool) -> int:
    """Run everything; the number of things that do not hold."""
    if not (work / "data").exists():
        (work / "data").symlink_to(ROOT / "data")
    wrong, kept = [], work / "printed.json"
    said = json.loads(kept.read_text(encoding="utf-8")) if kept.exists() else {}
    tutorial, readme = (list(steps(page.read_text(encoding="utf-8"))) for page in (TUTORIAL, README))
    for command, shown in [*tutorial, *(step for step in readme if step[1]), (README_RUN, [])]:
        if command not in said:
            print(f"$ {command}", flush=True)
            said[command] = run(command, work).splitlines()
            kept.write_text(json.dumps(said), encoding="utf-8")
        printed = said[command]
        wrong += [f"{command} no longer prints: {line}" for line in shown if not any(same(line, p) for p in printed)]
    wrong += check_claims(work)
    if figure:
        draw(work)
    print("\n".join(wrong) or "every excerpt and every number holds")
    return len(wrong)


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folder", nargs="?", type=Path)
    parser.add_argument("--figure", action="store_true")
    given = parser.parse_args()
    with tempfile.TemporaryDirectory() as temporary:
        folder = given.folder or Path(temporary)
        folder.mkdir(parents=True, exist_ok=True)
        sys.exit(bool(main(folder.resolve(), given.figure)))
