"""`ident report` makes the page that the command before it made, whichever that was."""

from __future__ import annotations

import json

import pytest

from ident.campaign import read_campaign
from tests.end_to_end.user import DATA, ident

RECORDS = ("multisine_a.csv", "sine_75Hz.csv")


@pytest.fixture(scope="module")
def campaign(tmp_path_factory):
    """Two records of the shipped oscillator, the second held out; its spring is not linear."""
    folder = tmp_path_factory.mktemp("page")
    whole = read_campaign(DATA / "oscillator")
    lines = ['device = { kind = "oscillator", output = "V" }']
    for name in RECORDS:
        trace = next(t for t in whole.traces if t.name == name)
        rows = zip(trace.time[:1500], trace.drive[:1500], trace.response[:1500], strict=True)
        text = "\n".join(["time (s),drive (V),response (V)", *(f"{t:.9g},{u:.9g},{y:.9g}" for t, u, y in rows)])
        (folder / name).write_text(text + "\n", encoding="utf-8")
        held = str(name == RECORDS[1]).lower()
        lines += ["[[record]]", f'file = "{name}"', f'start = "{trace.start}"', f"holdout = {held}"]
    (folder / "campaign.toml").write_text("\n".join(lines) + "\n", encoding="utf-8")
    return folder


def again(run) -> tuple[str, str]:
    """The page of a run as it is, and as `ident report` makes it."""
    before = (run / "report.html").read_text(encoding="utf-8")
    figures = sorted(p.name for p in (run / "figures").iterdir())
    assert ident("report", run).code == 0
    assert sorted(p.name for p in (run / "figures").iterdir()) == figures
    return before, (run / "report.html").read_text(encoding="utf-8")


def test_after_fit_add_and_remove(campaign, tmp_path):
    first, more, less = tmp_path / "a", tmp_path / "b", tmp_path / "c"
    assert ident("fit", campaign, "-o", first).code == 0
    added = ident("add", first, "cubic-stiffness", "-o", more)
    assert added.code == 0, added.err
    assert ident("remove", more, "cubic-stiffness", "-o", less).code == 0
    lineage = json.loads((less / "lineage.json").read_text(encoding="utf-8"))
    errors = [entry["after"]["fitted"]["error_over_noise"] for entry in lineage]
    assert [entry["added"] or entry["removed"] for entry in lineage] == ["cubic-stiffness"] * 2
    assert (
        errors[0] < 1.3 < 2 < errors[1] == pytest.approx(lineage[0]["before"]["fitted"]["error_over_noise"], rel=1e-3)
    )
    for run in (first, more, less):
        page, same = again(run)
        assert page == same and ("How the error fell" in page) == (run != first)


def test_after_discover_diagnose_and_sample(campaign, tmp_path):
    run = tmp_path / "found"
    outcome = ident("discover", campaign, "-o", run)
    assert outcome.code == 0, outcome.err
    assert json.loads((run / "run.json").read_text(encoding="utf-8"))["fitted"]["error_over_noise"] < 1.3
    found = json.loads((run / "diagnosis.json").read_text(encoding="utf-8"))
    assert (found["verdict"], found["final"]["effects"], found["records"]) == ("identified", ["cubic-stiffness"], [])
    assert found["start"]["error_over_noise"] > 2 and found["final"]["holdout_error_over_noise"] < 1.3
    best = found["ranking"][0]
    assert best["effect"] == "cubic-stiffness" and best["size"] > 20 * best["size_error"] > 0
    assert abs(best["predicted_gain"] - best["confirmed_gain"]) < 0.2 and best["confirmed_gain"] > 0.9
    page, same = again(run)
    assert page == same and "Which effect is missing" in page and "How the error fell" in page
    told = json.loads(ident("diagnose", run, "--json").out)
    assert told["verdict"] == "adequate" and told["steps"] == []
    page, same = again(run)
    assert page == same and "Where the first model fails" in page
    pytest.importorskip("h5py")
    assert ident("sample", run, "--minutes", "0.05").code == 0
    page, same = again(run)
    assert page == same and "Posterior" in page and "Where the first model fails" in page
    assert (run / "figures" / "posterior.png").is_file()
    outcome = ident("report", run, "--figures", "svg,pdf")
    assert outcome.code == 0 and "the figures of diagnosis are kept as PNG alone" in outcome.err
    for name in ("posterior", "overview"):  # that too which `report` does not draw itself
        assert all((run / "figures" / f"{name}.{kind}").is_file() for kind in ("svg", "pdf")), name
