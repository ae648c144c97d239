"""Wrong usage and unusable input: one line, exit code 2, nothing written."""

from __future__ import annotations

import math
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

import ident as package
from ident.cli.changed import beside
from ident.cli.fit import default_folder
from ident.cli.limit import Limit
from ident.cli.main import ident as commands
from tests.end_to_end.user import DATA, ROOT, assert_one_line, ident

COMMANDS = commands.list_commands(commands.make_context("ident", ["effects"]))


@pytest.mark.parametrize("command", COMMANDS)
def test_every_command_explains_itself_with_an_example(command):
    outcome = ident(command, "--help")
    assert outcome.code == 0
    assert "Example:" in outcome.out and f"ident {command} " in outcome.out.split("Example:")[1]


@pytest.mark.parametrize(
    ("line", "words"),
    [
        ("fti CAMPAIGN", ["did you mean 'fit'"]),
        ("fit", ["Missing argument", "ident fit --help"]),
        ("fit CAMPAIGN --sigma unknown", ["known"]),
        ("fit CAMPAIGN --starts -3", ["--starts"]),
        ("fit CAMPAIGN --frobnicate", ["--frobnicate"]),
        ("fit nowhere.toml", ["nowhere.toml", "no such file"]),
        ("fit .", ["campaign.toml"]),
        ("fit CAMPAIGN --effects cubic-stifness", ["cubic-stiffness"]),
        ("fit CAMPAIGN --effects cubic-stiffness,cubic-stiffness", ["already"]),
        ("fit CAMPAIGN --profile platform.qality", ["platform.quality"]),
        ("fit OSCILLATOR --effects residual-stress", ["platform"]),
        ("check CAMPAIGN/a.csv CAMPAIGN/campaign.toml", ["campaign.toml"]),
        ("effects cubic", ["cubic-stiffness"]),
        ("effects --file nowhere.py", ["nowhere.py"]),
        ("report CAMPAIGN", ["run.json"]),
        ("simulate CAMPAIGN", ["--output"]),
        ("simulate CAMPAIGN -o x.csv --set platform.quality", ["NAME=VALUE"]),
        ("simulate CAMPAIGN -o x.csv --set platform.qality=3", ["platform.quality"]),
        ("simulate CAMPAIGN -o x.csv --set platform.d31=3um", ["d31"]),
        ("simulate CAMPAIGN -o x.csv --set platform.quality=-3", ["not possible"]),
        ("simulate CAMPAIGN -o x.csv --record b.csv", ["b.csv", "a.csv"]),
        ("new CAMPAIGN", ["exists already"]),
    ],
)
def test_a_mistake_is_answered_in_one_line_and_writes_nothing(line, words, small, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    line = line.replace("CAMPAIGN", str(small)).replace("OSCILLATOR", str(DATA / "oscillator"))
    assert_one_line(ident(*line.split()), *words)
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(
    ("model", "words"),
    [
        ("[effect.cubic-stiffnes]\nk3 = 1.0", ["cubic-stiffness"]),
        ("[effect.cubic-stiffness]\nk33 = 1.0", ["k33", "'k3'"]),
        ('[effect.cubic-stiffness]\nk3 = "soft"', ["k3", "not a number"]),
        ('[effect.cubic-stiffness]\nfixed = ["q"]', ["'q'"]),
        ('[effect.residual-stress]\nclosure = "frme"', ["frme", '"frame"']),
        ('[effect.residual-stress]\nsigma12 = "80 nm"', ["a length", "a stress"]),
        ('[priors]\n"residual-stress.sigma12" = { normal = [80, 20], unit = "um" }', ["a length", "a stress"]),
        ("[effect.platform]\nquality = 0", ["not positive"]),
        ('[effect.platform]\nfixed = ["quality"]\nfree = ["quality"]', ["both fixed and free"]),
        ('[priors]\n"cubic-stiffness.k4" = { normal = [1, 1] }', ["cubic-stiffness.k3"]),
    ],
)
def test_a_mistake_about_effects_names_its_line(model, words, small, tmp_path):
    shutil.copytree(small, tmp_path / "campaign")
    file = tmp_path / "campaign" / "campaign.toml"
    before = file.read_text(encoding="utf-8")
    file.write_text(f"{before}\n{model}\n", encoding="utf-8")
    first = before.count("\n") + 2
    outcome = ident("fit", tmp_path / "campaign", "-o", tmp_path / "run")
    assert_one_line(outcome, "campaign.toml, line", *words)
    line = int(outcome.err.split("line ")[1].split(":")[0])
    assert first <= line <= first + model.count("\n")
    assert not (tmp_path / "run").exists()


def test_a_defect_of_ours_is_one_line_too_and_says_how_to_see_more(monkeypatch, small):
    def broken(*_):
        raise RuntimeError("a\ndefect")

    monkeypatch.setattr("ident.report.check.check", broken)
    outcome = ident("check", small)
    assert (outcome.code, outcome.out, len(outcome.err.splitlines())) == (1, "", 1)
    assert "RuntimeError: a defect" in outcome.err and "IDENT_DEBUG=1" in outcome.err
    monkeypatch.setenv("IDENT_DEBUG", "1")
    with pytest.raises(RuntimeError):
        ident("check", small)


def test_the_console_script_passes_the_exit_code_on():
    done = subprocess.run(
        [sys.executable, "-m", "ident.cli.main", "check", "nowhere"],
        capture_output=True,
        text=True,
        cwd=ROOT,
        check=False,
    )
    assert done.returncode == 2
    assert done.stdout == "" and len(done.stderr.splitlines()) == 1


def test_the_package_tells_its_story_in_few_names_and_loads_nothing_for_it():
    assert len(package.__all__) <= 25
    assert all(getattr(package, name) is not None for name in package.__all__)
    script = "import sys, ident; print(*sorted({'jax', 'numpy', 'pandas', 'matplotlib', 'click'} & set(sys.modules)))"
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, cwd=ROOT, check=True)
    assert done.stdout.strip() == ""


def test_an_effect_file_in_place_of_a_name_is_told_the_option():
    assert_one_line(ident("effects", "my_file.py"), "my_file.py", "ident effects --file my_file.py")


def test_a_folder_that_cannot_be_made_is_told_before_anything_is_fitted():
    if Path("/proc").is_dir():
        outcome = ident("discover", DATA / "oscillator", "-o", "/proc/found")
        assert_one_line(outcome, "/proc/found", "nothing can be written there")
        assert "fitting" not in outcome.err


def test_a_run_is_called_as_its_campaign_is(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "stage.2").mkdir()
    for given, name in (("stage.2", "stage.2"), ("stage.2/campaign.toml", "stage.2"), ("sine.8V.csv", "sine.8V")):
        assert default_folder((given,)) == Path("runs") / name


def test_a_changed_run_lies_beside_its_parent_however_that_is_called(tmp_path, monkeypatch):
    (tmp_path / "a").mkdir()
    monkeypatch.chdir(tmp_path / "a")
    for run in (".", "../a/", str(tmp_path / "a")):
        assert beside(Path(run), "+cubic-stiffness").resolve() == tmp_path / "a+cubic-stiffness"


@pytest.mark.parametrize("minutes", [math.inf, 1e300, math.nan])
def test_more_time_than_a_timer_can_tell_is_no_limit(minutes):
    limit = Limit(minutes)
    with limit.running():
        limit.ask()


def test_a_full_disk_tells_no_file(monkeypatch, small):
    def full(*_):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("ident.report.check.check", full)
    assert ident("check", small).err.startswith("ident: No space left on device")
