"""Do fits return the truth, and do their error bars mean what they say?  `python -m experiments.recovery.recovery`

400 simulated campaigns with random truths (`campaigns.py`) are fitted from the records' own guess. For every
determined parameter the standardised error (estimate − truth)/standard error must have a mean within ±0.15 and a
standard deviation within 0.9–1.1; the two stress gradients, of which the displacement shows one combination only,
must be reported as undetermined, and their combination must be right. Finished campaigns are kept in `runs/recovery`,
so that an interrupted run goes on where it stopped; `--again` forgets them.
"""

from __future__ import annotations

import argparse
import json
from pathlib import Path
from typing import Any

import numpy as np
from rich.progress import track

from ident.campaign.device import Platform
from ident.effects.library.pzt_hysteresis import PztHysteresis
from ident.effects.library.residual_stress import ResidualStress
from ident.fit import Fit, fit
from ident.model import Model

from .campaigns import KINDS, Case, draw

CAMPAIGNS = 400
RESULTS = Path("runs/recovery/results.jsonl")
HIDDEN = ("residual-stress.sigma12", "residual-stress.sigma23")
COMBINATION = "combination of σ12 and σ23"
MEAN, SPREAD = 0.15, (0.9, 1.1)


def model() -> Model:
    """The model that is fitted: residual stress (closure "axial-force") and hysteresis on the platform."""
    return Model(Platform()) + ResidualStress() + PztHysteresis()


def standardised(found: Fit, case: Case) -> dict[str, float]:
    """(estimate − truth)/standard error of every parameter that has one, and of the combination."""
    truth = case.truth
    errors = {
        e.name: (e.value - truth[e.name]) / e.standard_error
        for e in found.estimates
        if e.fitted and e.standard_error is not None
    }
    for combination in found.combinations:
        assert set(combination.names) == set(HIDDEN) and not combination.logarithmic
        true = sum(w * truth[name] for w, name in zip(combination.weights, combination.names, strict=True))
        errors[COMBINATION] = (combination.value - true) / combination.deviation
    return errors


def one(seed: int) -> dict[str, Any]:
    """Draw, fit and judge the campaign of one seed."""
    case = draw(seed)
    found = fit(model(), case.campaign)
    return {
        "seed": seed,
        "kind": case.kind,
        "converged": found.converged,
        "error_over_noise": found.fitted.error_over_noise,
        "step_error": found.step_error,
        "undetermined": [e.name for e in found.estimates if "undetermined" in e.flags],
        "errors": standardised(found, case),
    }


def run(count: int, path: Path) -> list[dict[str, Any]]:
    """The results of the first `count` seeds; those in `path` are not computed again."""
    path.parent.mkdir(parents=True, exist_ok=True)
    lines = path.read_text(encoding="utf-8").splitlines() if path.exists() else []
    done = {row["seed"]: row for row in map(json.loads, lines)}
    with path.open("a", encoding="utf-8") as file:
        for seed in track([s for s in range(count) if s not in done], "campaigns"):
            done[seed] = one(seed)
            file.write(json.dumps(done[seed]) + "\n")
            file.flush()
    return [done[seed] for seed in range(count)]


def table(rows: list[dict[str, Any]]) -> dict[str, np.ndarray]:
    """Standardised errors by parameter."""
    return {name: np.array([row["errors"][name] for row in rows]) for name in rows[0]["errors"]}


def check(rows: list[dict[str, Any]], mean: float = MEAN, spread: tuple[float, float] = SPREAD) -> None:
    """Assert what the table shows."""
    for row in rows:
        assert row["converged"], row
        assert tuple(row["undetermined"]) == HIDDEN, row
        assert len(row["errors"]) == 8 and not set(HIDDEN) & set(row["errors"]), row
        assert row["step_error"] < 0.1, row
    for name, errors in table(rows).items():
        assert abs(errors.mean()) < mean, (name, errors.mean())
        assert spread[0] < errors.std(ddof=1) < spread[1], (name, errors.std(ddof=1))


def show(rows: list[dict[str, Any]]) -> None:
    """Print the table, for all campaigns and by kind of noise."""
    columns = ("all", *KINDS)
    print(f"{len(rows)} campaigns; mean and standard deviation of (estimate − truth)/standard error")
    print(f"{'':32}" + "".join(f"{c:>22}" for c in columns))
    for name in rows[0]["errors"]:
        cells = []
        for kind in columns:
            errors = np.array([row["errors"][name] for row in rows if kind in ("all", row["kind"])])
            cells.append(f"{errors.mean():+13.2f} {errors.std(ddof=1):8.2f}")
        print(f"{name:32}" + "".join(cells))
    print(f"largest discretisation error: {max(row['step_error'] for row in rows):.3f} noise floors")


def main() -> None:
    """Run the study from the command line."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--campaigns", type=int, default=CAMPAIGNS)
    parser.add_argument("--again", action="store_true", help="forget what was computed before")
    options = parser.parse_args()
    if options.again:
        RESULTS.unlink(missing_ok=True)
    rows = run(options.campaigns, RESULTS)
    show(rows)
    check(rows)


if __name__ == "__main__":
    main()
