"""One record has the wrong sign, and all lack an effect: the walk tells both, and goes on where it was stopped."""

from __future__ import annotations

import json
import shutil
from pathlib import Path

import pandas as pd
import pytest

from ident.cli import walk
from ident.report.run_folder import load_run
from tests.end_to_end.user import DATA, Outcome, ident

WRONG = "multisine_b.csv"


@pytest.fixture(scope="module")
def told(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Outcome]:
    """A walk that was interrupted after its first step and resumed, and what it says at its end."""
    home = tmp_path_factory.mktemp("left-out")
    campaign, run = shutil.copytree(DATA / "oscillator", home / "campaign"), home / "run"
    table = pd.read_csv(campaign / WRONG, comment="#")
    table.iloc[:, -1] *= -1
    table.to_csv(campaign / WRONG, index=False)
    with pytest.MonkeyPatch.context() as patch:
        keep = walk._Kept.keep

        def interrupted(kept: walk._Kept, walked: walk.Walked) -> None:
            keep(kept, walked)
            if walked.steps:
                raise KeyboardInterrupt

        patch.setattr(walk._Kept, "keep", interrupted)
        assert ident("discover", campaign, "-o", run).code != 0
    outcome = ident("discover", campaign, "-o", run, "--resume")
    assert outcome.code == 0
    return run, outcome


def test_both_are_told(told):
    run, outcome = told
    said = json.loads((run / "diagnosis.json").read_text(encoding="utf-8"))
    (suspect,) = said["records"]
    assert (suspect["file"], suspect["suspect"]) == (WRONG, "sign") and suspect["size"] == pytest.approx(-1, rel=1e-3)
    assert [step["added"] for step in said["steps"]] == ["cubic-stiffness"]
    assert said["verdict"] == "ambiguous"  # beside a suspect no name is sure
    assert said["final"]["error_over_noise"] < 1.05
    assert f"{WRONG} is left out. " in outcome.out


def test_the_run_is_read_back_without_the_record(told):
    run, _ = told
    fitted = load_run(run)
    assert WRONG not in [score.name for score in fitted.scores]
    assert [record.name for record, _ in fitted.campaign.left_out] == [WRONG]
    kept = json.loads((run / "run.json").read_text(encoding="utf-8"))
    assert fitted.fitted.error_over_noise == pytest.approx(kept["fitted"]["error_over_noise"], rel=1e-9)
    assert kept["left_out"] == [WRONG] and WRONG not in [record["file"] for record in kept["records"]]
    shown = ident("report", run)
    assert shown.code == 0 and f"Left out as suspect: {WRONG}" in (run / "report.html").read_text(encoding="utf-8")
