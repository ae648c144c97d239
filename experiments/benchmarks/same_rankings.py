"""Are effects scored as before?  `python -m experiments.benchmarks.same_rankings --against FOLDER`

Fifty campaigns of the hidden-effect study (`experiments/hidden_effects`), every second one with another effect in the
model already, are scored by this checkout and by another one. The drop of χ² that each effect promises must agree to a
thousandth of the χ² that there is to explain. An effect whose law differs between the two is left out by `--but NAME`:
against 24fa412 that is `bouc-wen`, and all others agree.
"""

from __future__ import annotations

import argparse
import importlib
import json
import os
import subprocess
import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
SEED, CAMPAIGNS, AGREE = 8200, 50, 1e-3
IN_MODEL = "cubic-damping"


def scores(path: Path, campaigns: int) -> None:
    """Score so many campaigns with the ident of this process; runs in either checkout, so it needs nothing new."""
    from experiments.hidden_effects.campaigns import campaign_of
    from experiments.hidden_effects.generator import draw
    from experiments.hidden_effects.laws import NAMES
    from ident.effects.registry import built_in
    from ident.fit import fit
    from ident.model import Model

    try:
        from ident.diagnosis.linearised.regression import prepare
        from ident.diagnosis.ranking.score import score
    except ImportError:  # an older checkout
        score_file = importlib.import_module("ident.diagnosis.score")
        score = score_file.score
        prepare = getattr(score_file, "prepare", None) or importlib.import_module("ident.diagnosis.bench").prepare

    library, found = built_in(), []
    known = [name for name in NAMES if name in library and not library[name].needs]
    for k in range(campaigns):
        campaign = campaign_of(draw(SEED + k, (known[k % len(known)],), size=0.02, noise=0.003))
        model = Model(campaign.device)
        regression = prepare(fit(model + library[IN_MODEL]() if k % 2 else model, campaign))
        found.append({"chi2": regression.chi2} | {c.name: c.drop for c in score(regression, library)})
    path.write_text(json.dumps(found), encoding="utf-8")


def main() -> None:
    """Run the comparison from the command line."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--against", type=Path, help="another checkout of ident")
    parser.add_argument("--write", type=Path, help="score with this process and write the numbers")
    parser.add_argument("--but", action="append", default=[], help="an effect whose law has changed; may be repeated")
    parser.add_argument("--campaigns", type=int, default=CAMPAIGNS, help="how many of them")
    options = parser.parse_args()
    if options.write:
        return scores(options.write, options.campaigns)
    rows = []
    with tempfile.TemporaryDirectory() as folder:
        for checkout in (ROOT, options.against.resolve()):
            path = Path(folder) / f"{len(rows)}.json"
            environment = os.environ | {"PYTHONPATH": str(checkout), "IDENT_CACHE": f"{folder}/cache{len(rows)}"}
            call = [sys.executable, str(Path(__file__)), "--write", str(path), "--campaigns", str(options.campaigns)]
            subprocess.run(call, env=environment, cwd=checkout, check=True)
            rows.append(json.loads(path.read_text(encoding="utf-8")))
    worst = 0.0
    for number, (new, old) in enumerate(zip(*rows, strict=True)):
        assert new.keys() == old.keys(), (number, new.keys() ^ old.keys())
        apart = {name: abs(new[name] - old[name]) / old["chi2"] for name in new.keys() - set(options.but)}
        name = max(apart, key=lambda name: apart[name])
        worst = max(worst, apart[name])
        if apart[name] > AGREE:
            print(f"campaign {number}: {name} {new[name]:.6g} against {old[name]:.6g}")
    print(f"{len(rows[0])} campaigns, largest difference {worst:.1e} of χ²")
    assert worst <= AGREE


if __name__ == "__main__":
    main()
