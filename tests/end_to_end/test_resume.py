"""What was stopped goes on: walks and fits end where they would have ended undisturbed."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from ident.cli import walk
from tests.end_to_end.user import DATA, assert_one_line, ident


def document(run: Path, file: str) -> dict:
    return json.loads((run / file).read_text(encoding="utf-8"))


@pytest.fixture(scope="module")
def walks(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Path]:
    """Run folders of a walk that was left alone, and of one that was interrupted after its first step and resumed."""
    home = tmp_path_factory.mktemp("walks")
    whole, cut = home / "whole", home / "cut"
    assert ident("discover", DATA / "oscillator", "-o", whole).code == 0
    with pytest.MonkeyPatch.context() as patch:
        keep = walk._Kept.keep

        def interrupted(kept: walk._Kept, walked: walk.Walked) -> None:
            keep(kept, walked)
            if walked.steps:
                raise KeyboardInterrupt

        patch.setattr(walk._Kept, "keep", interrupted)
        stopped = ident("discover", DATA / "oscillator", "-o", cut)
        assert stopped.code != 0 and "--resume goes on" in stopped.out
    assert document(cut, "diagnosis.json")["finished"] is False
    outcome = ident("discover", DATA / "oscillator", "-o", cut, "--resume")
    assert outcome.code == 0 and "added cubic-stiffness" not in outcome.err  # it had been
    return whole, cut


def test_a_resumed_walk_ends_where_an_undisturbed_one_does(walks):
    whole, cut = (document(run, "diagnosis.json") for run in walks)
    assert cut["finished"] and cut["verdict"] == whole["verdict"] and cut["summary"] == whole["summary"]
    assert [step["added"] for step in cut["steps"]] == [step["added"] for step in whole["steps"]] != []
    for a, b in zip(cut["ranking"], whole["ranking"], strict=True):
        numbers = [key for key, value in b.items() if isinstance(value, float)]
        assert {**a, **dict.fromkeys(numbers)} == {**b, **dict.fromkeys(numbers)}
        # Values go through logarithms as they are read.
        assert [a[key] for key in numbers] == pytest.approx([b[key] for key in numbers], rel=1e-9)
    for a, b in zip(cut["steps"], whole["steps"], strict=True):
        assert a["tie_set"] == b["tie_set"] and a["role"] == b["role"]
        assert a["error_over_noise"] == pytest.approx(b["error_over_noise"], rel=1e-6)
    values = [document(run, "run.json")["state"]["values"] for run in walks]
    assert values[1] == pytest.approx(values[0], rel=1e-6)
    assert sorted(p.name for p in walks[0].iterdir()) == sorted(p.name for p in walks[1].iterdir())


def test_what_cannot_go_on_is_told(walks, clean, tmp_path):
    whole, _ = walks
    assert_one_line(ident("discover", DATA / "oscillator", "-o", whole, "--resume"), "no walk here", "leave --resume")
    assert_one_line(ident("discover", DATA / "oscillator", "-o", tmp_path / "x", "--resume"), "no run here")
    assert_one_line(ident("fit", DATA / "oscillator", "-o", clean[0] / "run", "--resume"), "another campaign")
    refused = ident("fit", DATA / "oscillator", "-o", whole, "--resume", "--effects", "creep")
    assert_one_line(refused, "--effects", "keeps its effects")


def test_a_fit_that_ran_out_of_time_goes_on(oscillator, tmp_path):
    run, effects = tmp_path / "run", ("--effects", "cubic-stiffness")
    stopped = ident("fit", DATA / "oscillator", *effects, "-o", run, "--minutes", "1e-6", "--sigma", "scaled")
    assert stopped.code == 0 and "--resume goes on" in stopped.err and "did not converge" in stopped.out
    assert document(run, "run.json")["converged"] is False
    assert ident("fit", DATA / "oscillator", "-o", run, "--resume").code == 0
    assert document(run, "run.json")["converged"] is True
    assert document(run, "run.json")["sigma"] == "scaled"  # as it was begun
    assert_one_line(ident("fit", DATA / "oscillator", "-o", run, "--resume"), "has converged", "another folder")
    values, expected = (document(r, "run.json")["state"]["values"] for r in (run, oscillator[0]))
    assert values == pytest.approx(expected, rel=1e-3)


def test_figures_in_the_formats_of_a_paper(clean, tmp_path):
    figures = clean[0] / "run" / "figures"
    before = {path.stem for path in figures.glob("*.png")}
    drawn = ident("report", clean[0] / "run", "--figures", "pdf,svg", "--json")
    assert drawn.code == 0 and json.loads(drawn.out) == document(clean[0] / "run", "run.json")
    for format, begins in (("pdf", b"%PDF"), ("svg", b"<?xml"), ("png", b"\x89PNG")):
        files = list(figures.glob(f"*.{format}"))
        assert {path.stem for path in files} == before
        assert all(path.read_bytes().startswith(begins) for path in files)
    assert_one_line(ident("report", clean[0] / "run", "--figures", "eps"), "'eps' is none of png, svg, pdf")
