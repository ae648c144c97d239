"""Residual stress or hysteresis: does `ident compare` decide rightly, and does it say so where it cannot decide?

    python -m experiments.posterior.model_choice --cases 100 --results runs/choice.jsonl

Each platform has one of the two effects, by the toss of a coin, with parameters from the very priors that the models
assume, and noise from 0.1 to 20 µm, so that some campaigns decide and others cannot. Where the exact evidences differ
by more than 5 nats the verdict must be `decided`, for the true model; elsewhere `undecided`. Exact is importance
sampling with four times as many draws and others. Where those weights are not to be trusted nothing is exact, and the
case is told apart.
"""

from __future__ import annotations

import argparse
import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from experiments.make_campaigns import PAPER
from experiments.posterior.stressed_platforms import draw_truth, fitted, measure
from ident.posterior.compare import DECISIVE, compare
from ident.posterior.evidence import log_evidence

MODELS = ("residual-stress", "pzt-hysteresis")
ABSENT = {  # what switches an effect off in the simulator
    "residual-stress": {"sigma12": 0.0, "sigma23": 0.0, "restraint": 0.0, "voltage_force": 0.0},
    "pzt-hysteresis": {"eta": 0.0, "zeta": 0.0},
}
SIGMAS = 0.1e-6, 20e-6  # m; the motion is 4 to 50 µm
DRAWS = 8192
_ON_THE_LINE = 0.2
"""Nats within which the two evidences may stand on both sides of the limit: their error."""


def one(seed: int) -> dict[str, Any]:
    """One campaign, weighed."""
    random = np.random.default_rng([17, seed])
    truth, true = draw_truth(random), MODELS[int(random.integers(2))]
    absent = next(name for name in MODELS if name != true)
    stage = replace(PAPER, **{name.split(".")[1]: value for name, value in truth.items()})
    sigma = float(np.exp(random.uniform(*np.log(SIGMAS))))
    records = measure(random, replace(stage, **ABSENT[absent]), sigma)
    fits = [(name, fitted(records, (name,))) for name in MODELS]
    told = compare(fits)
    exact = [log_evidence(weighed.evidence.density, count=DRAWS, seed=1 + seed) for weighed in told.models]
    return {
        "seed": seed, "true": true, "sigma": sigma, "verdict": told.verdict, "best": told.models[told.best].name,
        "exact": abs(exact[0].value - exact[1].value), "lead": told.lead, "error": told.error,
        "trusted": all(e.trusted for e in exact), "words": told.words,
    }  # fmt: skip


def judge(line: dict[str, Any]) -> str:
    """What became of a campaign."""
    if not line["trusted"]:
        return "evidence not to be trusted"
    apart = line["exact"] - DECISIVE
    if line["verdict"] == "undecided":
        return "undecided, as it should be" if apart < _ON_THE_LINE else "undecided, but decidable"
    if line["best"] != line["true"]:
        return "wrong"
    return "right" if apart > -_ON_THE_LINE else "decided, but undecidable"


def main() -> None:
    """Run the study, going on where it stopped."""
    parser = argparse.ArgumentParser()
    parser.add_argument("--cases", type=int, default=100)
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--results", type=Path, default=Path("runs/choice.jsonl"))
    told = parser.parse_args()
    told.results.parent.mkdir(parents=True, exist_ok=True)
    lines = []
    if told.results.exists():
        lines = [json.loads(text) for text in told.results.read_text(encoding="utf-8").splitlines()]
    for seed in range(told.first + len(lines), told.first + told.cases):
        lines.append(one(seed))
        with told.results.open("a", encoding="utf-8") as file:
            file.write(json.dumps(lines[-1]) + "\n")
    outcomes = [judge(line) for line in lines]
    for outcome in sorted(set(outcomes)):
        print(f"{outcomes.count(outcome):4d}  {outcome}")
    decidable = [judge(x) for x in lines if x["trusted"] and x["exact"] > DECISIVE + _ON_THE_LINE]
    assert decidable.count("right") >= 0.99 * len(decidable) - 1, decidable
    assert not outcomes.count("decided, but undecidable")


if __name__ == "__main__":
    main()
