"""Is a faulty record named, and named before physics?  `python -m experiments.faulty_records.study --seeds 0-1`

Devices of the independent simulator of `experiments.hidden_effects`, with nothing, one effect or two hidden, and one of
twelve faults in one record; campaigns without a fault show how often a sound record is suspected: two effects are what
a fault may be mistaken for, so they are of three sizes and of oscillators as well. Each case is fitted
by the plain linear model and asked for its suspects. Finished cases are kept in `results.jsonl`, one line each.
"""

from __future__ import annotations

import os

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import argparse
import json
import time
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from ident import runtime

runtime.configure()

from experiments.hidden_effects.campaigns import campaign_of  # noqa: E402  (JAX must be configured first)
from experiments.hidden_effects.generator import Case, draw  # noqa: E402
from ident.campaign import Campaign  # noqa: E402
from ident.campaign.quality.outliers import find_outliers, without_outliers  # noqa: E402
from ident.diagnosis.diagnose import diagnose  # noqa: E402
from ident.diagnosis.faulty.suspects import find_suspects  # noqa: E402
from ident.diagnosis.ranking.look import first_look  # noqa: E402
from ident.effects.registry import registry  # noqa: E402
from ident.fit import fit  # noqa: E402
from ident.model import build_model  # noqa: E402

from .faults import EXPECTED, FAULTS, spoil  # noqa: E402

RESULTS = Path(__file__).with_name("results.jsonl")
HIDDEN = ("cubic-stiffness", "coulomb-friction", "pzt-hysteresis", "squeeze-film-damping", "quadratic-stiffness")
OF_TWO = (
    "cubic-stiffness", "coulomb-friction", "quadratic-damping", "quadratic-stiffness", "sensor-nonlinearity",
    "viscoelastic-support", "bouc-wen", "end-stop", "creep", "sensor-lag",
)  # fmt: skip
_WORDS = ("none", "one", "two")
_BY_OTHERS = ("delay", "gain", "sign", "time-scale", "wrong-record")


def hide(seed: int, hidden: int) -> tuple[Case, list[str]]:
    """A device with so many effects hidden, and their names."""
    if hidden < 2:
        names = [HIDDEN[seed % len(HIDDEN)]] * hidden
        return draw(seed, tuple(names), size=0.02, noise=0.003), names
    rng = np.random.default_rng(seed)
    names, size = rng.choice(OF_TWO, 2, replace=False).tolist(), float(rng.choice([0.03, 0.08, 0.2]))
    device = "oscillator" if rng.random() < 0.5 else "platform"
    return draw(seed, tuple(names), size=size, noise=0.003, device=device, records=6), names


def run(seed: int, fault: str, hidden: int, walk: bool = False) -> dict[str, Any]:
    """One campaign, its suspects, and whether the first of them is the fault; if `walk`, the whole diagnosis of it."""
    case, effects = hide(seed, hidden)
    records, faulty = (case.records, "") if fault == "none" else spoil(case, fault, seed)
    campaign = _as_read(campaign_of(replace(case, records=records)))
    began = time.process_time()
    found = fit(build_model(campaign), campaign)
    if walk:
        diagnosis = diagnose(found, registry())
        suspects, named = diagnosis.suspects, [step.added for step in diagnosis.discovery.steps]
        told = {"verdict": diagnosis.verdict, "named": named, "truth": effects}
        told["wrong_physics"] = diagnosis.verdict == "identified" and set(named) != set(effects)
    else:
        suspects, told = find_suspects(found, lambda one: first_look(one, registry(), lambda _: None)), {}
    named = [s for s in suspects if s.kind in _BY_OTHERS or s.kind in EXPECTED.get(fault, ()) or fault == "none"]
    right = any(s.file == f"{faulty}.csv" and s.kind in EXPECTED.get(fault, ()) for s in named)
    return {
        "key": key_of(seed, fault, hidden, walk), "fault": fault, "hidden": hidden, "seed": seed,
        "record": f"{faulty}.csv", "right": right, "record_named": any(s.file == f"{faulty}.csv" for s in suspects),
        "wrong": sum(s.file != f"{faulty}.csv" for s in suspects),
        "suspects": [[s.file, s.kind, round(s.size, 4), s.probability, s.first] for s in suspects],
        "error": round(found.fitted.error_over_noise, 3), "seconds": round(time.process_time() - began, 1),
        **told,
    }  # fmt: skip


def key_of(seed: int, fault: str, hidden: int, walk: bool) -> str:
    """The name of a case."""
    return f"{fault}/{hidden}/{seed}{'/walk' if walk else ''}"


def _as_read(campaign: Campaign) -> Campaign:
    """With outliers taken out, clipped samples and slips of the sensor masked, as reading the files would."""
    from ident.campaign.noise.floor import noise_floor
    from ident.campaign.quality.clipping import clipped_mask
    from ident.campaign.quality.slips import find_slips

    records = []
    for trace in campaign.traces:
        masked = clipped_mask(trace.response)
        if masked is not None:
            noise = noise_floor(trace.time, trace.drive, trace.response, trace.period, masked)
            trace = replace(trace, masked=masked, stuck=float(np.mean(masked)), noise=noise)
        outliers = find_outliers(trace.response)
        if len(outliers):
            response = without_outliers(trace.response, outliers)
            noise = noise_floor(trace.time, trace.drive, response, trace.period)
            trace = replace(trace, response=response, noise=noise, outliers=tuple(int(k) for k in outliers))
        slips = find_slips(trace.response, trace.drive)
        if slips is not None:
            masked = slips if trace.masked is None else trace.masked | slips
            noise = noise_floor(trace.time, trace.drive, trace.response, trace.period, masked, trace.stuck == 0)
            trace = replace(trace, masked=masked, noise=noise)
        records.append(trace)
    return replace(campaign, records=tuple(records))


def table(rows: list[dict[str, Any]]) -> str:
    """The result in words and numbers."""
    lines = ["fault        hidden   cases  record named  kind right  other records suspected"]
    for fault in ("none", *FAULTS):
        for hidden, word in enumerate(_WORDS):
            some = [row for row in rows if row["fault"] == fault and row["hidden"] == hidden]
            if some:
                share = [100 * float(np.mean([row[key] for row in some])) for key in ("record_named", "right")]
                wrong = sum(row["wrong"] for row in some)
                lines.append(f"{fault:12} {word:7} {len(some):6}  {share[0]:10.0f} %  {share[1]:8.0f} %  {wrong:10}")
    walked = [row for row in rows if "verdict" in row]
    if walked:
        sure = [row["key"] for row in walked if row["wrong_physics"]]
        lines.append(f"whole diagnoses: {len(walked)}, wrong physics called sure in {len(sure)} {sure or ''}")
    return "\n".join(lines)


def main() -> None:
    """Run the study from the command line."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seeds", default="0-1", help='"3" or "0-19"')
    parser.add_argument("--faults", default=",".join(("none", *FAULTS)))
    parser.add_argument("--hidden", choices=[*_WORDS, "all"], default="all")
    parser.add_argument("--walk", action="store_true", help="the whole diagnosis: is wrong physics called sure?")
    parser.add_argument("--minutes", type=float, default=1e9, help="of wall clock, after which no case is begun")
    told = parser.parse_args()
    first, _, last = told.seeds.partition("-")
    rows = [json.loads(line) for line in RESULTS.read_text().splitlines()] if RESULTS.exists() else []
    done, began = {row["key"] for row in rows}, time.monotonic()
    with RESULTS.open("a", encoding="utf-8") as file:
        for seed in range(int(first), int(last or first) + 1):
            for fault in told.faults.split(","):
                for hidden in range(3) if told.hidden == "all" else (_WORDS.index(told.hidden),):
                    late = time.monotonic() - began > 60 * told.minutes
                    if late or key_of(seed, fault, hidden, told.walk) in done:
                        continue
                    rows.append(run(seed, fault, hidden, told.walk))
                    file.write(json.dumps(rows[-1]) + "\n")
                    file.flush()
    print(table(rows))


if __name__ == "__main__":
    main()
