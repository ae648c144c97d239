"""Is an interval ever called final although the model lacks an effect? Campaigns of many hidden effects.

    python -m experiments.posterior.missing_effect --cases 60 --results runs/missing.jsonl

Every law of the hidden-effect simulator in turn, among them those that no effect of the library describes, on platforms
and oscillators, under noise of 0.3, 3 and 10 % of the signal. Its size is what the best linear oscillator would leave
of it, 2 % of the signal. Every second device also has a cubic spring, which the model holds. Judged as `ident sample`
judges, without drawing a chain: a chain that has not settled would be one reason more.
"""

from __future__ import annotations

import argparse
import json
from pathlib import Path
from typing import Any

from experiments.hidden_effects.campaigns import campaign_of
from experiments.hidden_effects.generator import draw
from experiments.hidden_effects.laws import NAMES
from ident.diagnosis.judged import doubts
from ident.errors import UserError
from ident.fit.fit import fit
from ident.model import build_model
from ident.posterior.evidence import log_evidence
from ident.posterior.misfit import misfit

BESIDE = "cubic-stiffness"
HIDDEN = tuple(name for name in NAMES if name != BESIDE)
BEAMS = ("residual-stress", "arch-force")  # of a platform only
NOISES = (0.003, 0.03, 0.1)
SIZE = 0.02


def one(seed: int) -> dict[str, Any]:
    """One campaign whose model lacks an effect, and what is said against the model."""
    hidden = HIDDEN[seed % len(HIDDEN)]
    beside = (BESIDE,) if seed % 2 else ()
    device = "platform" if seed % 4 < 2 or hidden in BEAMS else "oscillator"
    noise = NOISES[(seed // 3) % len(NOISES)]
    line: dict[str, Any] = {"seed": seed, "hidden": hidden, "beside": beside, "device": device, "noise": noise}
    try:
        campaign = campaign_of(draw(seed, (hidden, *beside), size=SIZE, noise=noise, device=device))
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
    return line | {"final": not by, "by": by, "error_over_noise": round(found.fitted.error_over_noise, 3)}


def main() -> None:
    """Run the study, going on where it stopped."""
    parser = argparse.ArgumentParser()
    parser.add_argument("--cases", type=int, default=60)
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--results", type=Path, default=Path("runs/missing.jsonl"))
    told = parser.parse_args()
    told.results.parent.mkdir(parents=True, exist_ok=True)
    lines = []
    if told.results.exists():
        lines = [json.loads(text) for text in told.results.read_text(encoding="utf-8").splitlines()]
    for seed in range(told.first + len(lines), told.first + told.cases):
        lines.append(one(seed))
        with told.results.open("a", encoding="utf-8") as file:
            file.write(json.dumps(lines[-1]) + "\n")
    judged = [line for line in lines if line["final"] is not None]
    final = [line for line in judged if line["final"]]
    print(f"{len(final)} of {len(judged)} campaigns were called final although an effect is missing")
    for reason in ("residual", "library"):
        alone = sum(line.get("by") == [reason] for line in judged)
        print(f"  {sum(reason in line.get('by', ()) for line in judged)} by the {reason}, {alone} by it alone")
    assert not final, final


if __name__ == "__main__":
    main()
