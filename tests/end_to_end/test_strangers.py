"""Campaigns and runs from elsewhere: no program of theirs runs unasked, and what cannot be read is not opened."""

from __future__ import annotations

import json
import os
import shutil
import zipfile
from pathlib import Path

import numpy as np
import pytest

from tests.broken import campaign_text, csv_text
from tests.end_to_end.user import Outcome, assert_one_line, ident

EFFECT = '''
from pathlib import Path
from ident.effects import AbstractEffect, amplitude
Path(__file__).with_name("it_ran").touch()


class Odd(AbstractEffect):
    """F = −k z."""

    name = "odd"
    k = amplitude("N/m", "stiffness")

    def force(self, state, drive, t):
        return -self.k * state.z
'''


@pytest.fixture(autouse=True)
def trusting(monkeypatch, tmp_path_factory):
    """A user who has trusted nothing yet."""
    monkeypatch.setenv("IDENT_CONFIG", str(tmp_path_factory.mktemp("settings")))
    monkeypatch.setattr("ident.campaign.trust._session", set())


@pytest.fixture
def stranger(tmp_path):
    """A campaign with an effect file that leaves a trace when it runs."""
    folder = tmp_path / "stranger"
    folder.mkdir()
    (folder / "a.csv").write_text(csv_text(), encoding="utf-8")
    (folder / "odd.py").write_text(EFFECT, encoding="utf-8")
    (folder / "campaign.toml").write_text(campaign_text(rest='[model]\neffect_files = ["odd.py"]'), encoding="utf-8")
    return folder


def ran(folder: Path) -> bool:
    return (folder / "it_ran").exists()


def assert_refused(outcome: Outcome, *words: str) -> None:
    """As `assert_one_line`, after lines of progress."""
    lines = [line for line in outcome.err.splitlines() if not line.endswith("…")]
    assert_one_line(outcome._replace(err="\n".join(lines)), *words)


def test_an_effect_file_runs_only_when_asked_and_is_then_remembered(stranger, tmp_path):
    run = tmp_path / "run"
    assert ident("check", stranger).code == 0 and not ran(stranger)
    assert_one_line(ident("fit", stranger, "-o", run), "odd.py", "--trust")
    assert not ran(stranger) and not run.exists()
    assert ident("fit", stranger, "--effects", "odd", "-o", run, "--trust").code == 0
    assert ident("fit", stranger, "-o", tmp_path / "without").code == 0
    assert ran(stranger)
    (stranger / "it_ran").unlink()
    assert ident("report", run).code == 0 and ran(stranger)
    told = json.loads((run / "run.json").read_text(encoding="utf-8"))["campaign"]
    assert len(told["effect_checksums"]) == 1 and all(len(s) == 64 for s in told["effect_checksums"].values())

    (stranger / "odd.py").write_text(EFFECT + "# more\n", encoding="utf-8")
    (stranger / "it_ran").unlink()
    assert_one_line(ident("fit", stranger, "-o", tmp_path / "run2"), "odd.py", "changed since")
    assert_refused(ident("report", run, "--trust"), "odd.py", "changed since this run")
    assert ident("report", tmp_path / "without").code == 0, "a run that has not its effect neither runs it nor minds"
    assert not ran(stranger)


def test_a_file_added_to_a_run_is_checked_like_those_of_the_campaign(stranger, tmp_path):
    (stranger / "campaign.toml").write_text(campaign_text(), encoding="utf-8")
    mine = tmp_path / "mine.py"
    mine.write_text(EFFECT, encoding="utf-8")
    assert ident("fit", stranger, "-o", tmp_path / "run").code == 0
    assert ident("add", tmp_path / "run", mine, "-o", tmp_path / "more").code == 0  # named, and so asked for
    mine.write_text(EFFECT.replace("−k z", "−k z once more"), encoding="utf-8")
    mine.with_name("it_ran").unlink()
    assert_refused(ident("report", tmp_path / "more", "--trust"), "mine.py", "changed since this run")
    assert not ran(tmp_path)


def test_pipes_devices_and_endless_files_are_refused_before_they_are_read(tmp_path):
    pipe = tmp_path / "pipe.csv"
    os.mkfifo(pipe)
    assert_one_line(ident("check", pipe), "pipe.csv", "a pipe")
    (tmp_path / "zero.csv").symlink_to("/dev/zero")
    assert_one_line(ident("check", tmp_path / "zero.csv"), "zero.csv", "a device")
    with open(tmp_path / "huge.csv", "wb") as file:
        file.truncate(1 << 40)
    assert_one_line(ident("check", tmp_path / "huge.csv"), "huge.csv", "1.02e+03 GB")
    for name, says in (("campaign.toml", "a pipe"), ("a.csv", "a pipe"), ("d.toml", "a pipe")):
        folder = tmp_path / name.replace(".", "_")
        folder.mkdir()
        (folder / "a.csv").write_text(csv_text(), encoding="utf-8")
        (folder / "d.toml").write_text("", encoding="utf-8")
        (folder / "campaign.toml").write_text('device = "d.toml"\n' + campaign_text(), encoding="utf-8")
        (folder / name).unlink()
        os.mkfifo(folder / name)
        assert_one_line(ident("check", folder), name, says)
    run = tmp_path / "run"
    run.mkdir()
    os.mkfifo(run / "run.json")
    assert_one_line(ident("report", run), "run.json", "a pipe")


def test_files_that_unfold_to_gigabytes_are_refused(tmp_path):
    h5py = pytest.importorskip("h5py")
    with h5py.File(tmp_path / "a.h5", "w") as file:
        file.create_dataset("z", shape=(1 << 28,), dtype="f8", chunks=True, compression="gzip")
    assert_one_line(ident("check", tmp_path / "a.h5"), "a.h5", "unfolds to 2 GB")
    from scipy.io import savemat

    savemat(tmp_path / "a.mat", {"z": np.zeros((1 << 26) + 9)}, do_compression=True)
    assert_one_line(ident("check", tmp_path / "a.mat"), "a.mat", "unfolds to 512 MB")


def test_a_header_of_megabytes_is_refused(tmp_path):
    (tmp_path / "a.csv").write_text("x" * 20_000_000 + "\n" + csv_text(), encoding="utf-8")
    assert_one_line(ident("check", tmp_path / "a.csv"), "a.csv", "line")
    (tmp_path / "b.csv").write_text("# remark\n" * 2_000_000 + csv_text(), encoding="utf-8")
    assert_one_line(ident("check", tmp_path / "b.csv"), "b.csv")


def test_nothing_that_steers_a_terminal_is_printed(tmp_path):
    (tmp_path / "campaign.toml").write_text('title = "a\\u001b[2Jb\\u202ec"\n' + campaign_text()[12:], encoding="utf-8")
    (tmp_path / "a.csv").write_text(csv_text("t (s),drive \x1b[31m(V),z (um)\x9b"), encoding="utf-8")
    for command in (("check", tmp_path), ("check", tmp_path, "--json"), ("check", tmp_path / "no\x1b[2Jfile")):
        outcome = ident(*command)
        text = outcome.out + outcome.err
        assert not any(mark in text for mark in "\x1b\x9b\u202e"), command


def test_force_spares_what_is_not_ours_and_a_report_is_renewed_whole(tmp_path):
    folder = tmp_path / "data"
    folder.mkdir()
    (folder / "a $5 b$.csv").write_text(csv_text(), encoding="utf-8")  # once a formula, which lost the whole fit
    run = tmp_path / "run"
    assert ident("fit", folder / "a $5 b$.csv", "-o", run).code == 0
    (run / "notes.txt").write_text("mine", encoding="utf-8")
    (run / "sub").mkdir()
    (run / "sub" / "deep.txt").write_text("mine too", encoding="utf-8")
    page = (run / "report.html").read_text(encoding="utf-8")
    shutil.rmtree(run / "figures")
    (tmp_path / ".ident-000-leftover").mkdir()
    assert ident("report", run).code == 0
    assert ident("fit", folder / "a $5 b$.csv", "-o", run, "--force").code == 0
    assert (run / "notes.txt").read_text(encoding="utf-8") == "mine"
    assert (run / "sub" / "deep.txt").read_text(encoding="utf-8") == "mine too"
    assert (run / "figures" / "overview.png").is_file()
    assert len(page) > 10_000 and sorted(p.name for p in tmp_path.iterdir()) == [".ident-000-leftover", "data", "run"]


@pytest.mark.parametrize(
    ("name", "arguments"),
    [
        ("n" * 255, ("fit", "{campaign}", "-o", "{folder}/{name}x")),
        ("n" * 300, ("check", "{folder}/{name}")),
        ("n" * 300, ("new", "{folder}/{name}")),
        ("n" * 300, ("report", "{folder}/{name}")),
        ("n" * 300, ("simulate", "{campaign}", "-o", "{folder}/{name}")),
        ("a.txt", ("effects", "--file", "{folder}/{name}")),
    ],
)
def test_odd_names_are_answered_in_one_line(small, tmp_path, name, arguments):
    (tmp_path / "a.txt").write_text("no python", encoding="utf-8")
    words = [word.format(campaign=small, folder=tmp_path, name=name) for word in arguments]
    outcome = ident(*words)
    assert_refused(outcome)
    assert "inside ident" not in outcome.err


@pytest.mark.parametrize(
    "record",
    ['noise = "1e-300 nm"', 'noise = "1e300 m"', f"skip = {'9' * 400}", 'load = "1e-320 mg"'],
)
def test_numbers_beyond_physics_are_advice(tmp_path, record):
    (tmp_path / "a.csv").write_text(csv_text(), encoding="utf-8")
    (tmp_path / "campaign.toml").write_text(campaign_text(record), encoding="utf-8")
    outcome = ident("check", tmp_path)
    assert outcome.code in (0, 2) and "inside ident" not in outcome.err, outcome
    if "noise" in record:
        assert_one_line(outcome, "noise", "campaign.toml")


@pytest.mark.parametrize("cell", ["1_000", "٣", "１", "0x10", "1e5_0"])
def test_digits_of_other_scripts_are_no_numbers(tmp_path, cell):
    rows = csv_text().split("\n")
    rows[9] = f"0.0004,{cell},1.0"
    (tmp_path / "a.csv").write_text("\n".join(rows), encoding="utf-8")
    assert_one_line(ident("check", tmp_path / "a.csv"), "a.csv, line 10", "column 2")


def test_an_archive_is_no_table(tmp_path):
    with zipfile.ZipFile(tmp_path / "a.csv", "w") as archive:
        archive.writestr("inner", "x" * 100)
    assert_one_line(ident("check", tmp_path / "a.csv"), "a.csv")
