"""Is an interval ever called final although the model lacks an effect? Campaigns of many hidden effects.

    python -m experiments.posterior.missing_effect --cases 60 --results runs/missing.jsonl
    python -m experiments.posterior.missing_effect --complete --results runs/complete.jsonl     # nothing is missing

Every law of the hidden-effect simulator in turn, among them those that no effect of the library describes, on platforms
and oscillators, under noise of 0.3, 3 and 10 % of the signal. Its size is what the best linear oscillator would leave
of it, 2 % of the signal. Every second device also has a cubic spring, which the model holds. Judged as `ident sample`
judges, without drawing a chain: a chain that has not settled would be one reason more. With `--complete` nothing is
hidden and the cubic spring is the library's: every refusal is then a false one.

An effect that the model's own parameters absorb leaves nothing to see. So of every campaign called final the study says
how visible it was: the model is fitted to the same records without their noise, and what it cannot follow there is
measured in standard deviations of the noise, d = √Σ(left/σ)². A test that knew the missing law would find it d standard
deviations from nought; the score test asks all effects of the library and must see one at `SEEN`.
"""

from __future__ import annotations

import argparse
import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from scipy import stats

from experiments.hidden_effects.campaigns import campaign_of
from experiments.hidden_effects.generator import Case, draw
from experiments.hidden_effects.laws import NAMES
from ident.diagnosis.judged import doubts
from ident.effects.registry import registry
from ident.errors import UserError
from ident.fit import Fit, fit
from ident.model import build_model
from ident.posterior.evidence import log_evidence
from ident.posterior.misfit import misfit

BESIDE = "cubic-stiffness"
HIDDEN = tuple(name for name in NAMES if name != BESIDE)
BEAMS = ("residual-stress", "arch-force")  # of a platform only
SEEN = float(stats.norm.isf(0.5 * 0.002 / len(registry(()))))
"""Standard deviations at which one effect is seen, were all as likely: two false alarms in a thousand over all."""
NOISES = (0.003, 0.03, 0.1)
SIZE = 0.02


def one(seed: int, complete: bool) -> dict[str, Any]:
    """One campaign whose model lacks an effect, or is `complete`, and what is said against the model."""
    hidden = () if complete else (HIDDEN[seed % len(HIDDEN)],)
    beside = (BESIDE,) if seed % 2 else ()
    device = "platform" if seed % 4 < 2 or set(hidden) & set(BEAMS) else "oscillator"
    noise = NOISES[(seed // 3) % len(NOISES)]
    line: dict[str, Any] = {"seed": seed, "hidden": hidden, "beside": beside, "device": device, "noise": noise}
    detail = "plain" if complete else "own"
    try:
        case = draw(seed, (*hidden, *beside), size=SIZE, noise=noise, device=device, detail=detail)
        campaign = campaign_of(case)
    except ValueError:  # a device whose motion has no bound cannot be measured
        return line | {"final": None}
    try:
        found = fit(build_model(campaign, beside), campaign)
        told = doubts(found)
        evidence = log_evidence(found)
    except UserError as error:
        return line | {"final": False, "by": ["refused"], "words": str(error)}
    left = misfit(evidence.density).reasons
    by = [name for name, said in (("residual", left), ("library", told), ("evidence", not evidence.trusted)) if said]
    line |= {"final": not by, "by": by, "error_over_noise": round(found.fitted.error_over_noise, 3)}
    return line if by or complete else line | {"visible": round(visible(found, case), 2)}


def visible(found: Fit, case: Case) -> float:
    """How many standard deviations of the noise a model leaves of all records without their noise."""
    clean = {f"{made.name}.csv": made.clean for made in case.records}
    records = tuple(replace(r, response=clean[r.name], holdout=False) for r in found.campaign.traces)
    return float(np.sqrt(fit(found.model, replace(found.campaign, records=records), initial=found.values).fitted.chi2))


def main() -> None:
    """Run the study, going on where it stopped."""
    parser = argparse.ArgumentParser()
    parser.add_argument("--cases", type=int, default=60)
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--complete", action="store_true")
    parser.add_argument("--results", type=Path, default=Path("runs/missing.jsonl"))
    told = parser.parse_args()
    told.results.parent.mkdir(parents=True, exist_ok=True)
    lines = []
    if told.results.exists():
        lines = [json.loads(text) for text in told.results.read_text(encoding="utf-8").splitlines()]
    for seed in range(told.first + len(lines), told.first + told.cases):
        lines.append(one(seed, told.complete))
        with told.results.open("a", encoding="utf-8") as file:
            file.write(json.dumps(lines[-1]) + "\n")
    judged = [line for line in lines if line["final"] is not None]
    refused = [line for line in judged if not line["final"]]
    print(f"{len(judged) - len(refused)} of {len(judged)} campaigns were called final")
    for reason in ("residual", "library", "evidence"):
        alone = sum(line["by"] == [reason] for line in refused)
        print(f"  {sum(reason in line['by'] for line in refused)} refused by the {reason}, {alone} by it alone")
    if told.complete:  # three false alarms in a thousand are asked for
        assert len(refused) <= stats.binom.ppf(0.999, len(judged), 0.003), refused
        return
    for line in judged:
        if line["final"]:
            print(f"  final, the effect being visible at {line['visible']} standard deviations: {line}")
    assert all(line["visible"] < SEEN for line in judged if line["final"]), SEEN


if __name__ == "__main__":
    main()
