"""What the documents show is what the commands print."""

import re
from pathlib import Path

import pytest

from experiments import docs_numbers
from ident.cli.main import COMMANDS


def test_every_excerpt_and_every_number_holds(tmp_path: Path) -> None:
    assert docs_numbers.main(tmp_path, figure=False) == 0


def test_the_python_of_the_readme_runs(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys) -> None:
    text = (docs_numbers.ROOT / "README.md").read_text(encoding="utf-8")
    fence = re.search(r"^```python\n(.*?)^```", text, re.MULTILINE | re.DOTALL)
    assert fence is not None
    (tmp_path / "data").symlink_to(docs_numbers.ROOT / "data")
    monkeypatch.chdir(tmp_path)
    exec(fence[1], {})
    error, quality, deviation = map(float, capsys.readouterr().out.split())
    assert (
        error == pytest.approx(1.0, abs=0.02) and quality == pytest.approx(35.0, abs=5 * deviation) and deviation < 0.05
    )
    assert (tmp_path / "runs" / "clean" / "report.html").is_file()


@pytest.mark.parametrize(
    ("shown", "printed", "equal"),
    [
        ("error 8.88", "error   8.87", True),
        ("error 8.88", "error 9.88", False),
        ("− stress 1.00", "− stress 1.00", True),
        ("a -0.158 µN", "a -0.157 µN", True),
        ("a 0.5 µN", "a 0.5 nN", False),
    ],
)
def test_lines_are_compared_by_words_and_numbers(shown: str, printed: str, equal: bool) -> None:
    assert docs_numbers.same(shown, printed) == equal


def test_every_command_of_the_tutorial_exists_and_shows_something() -> None:
    for command, shown in docs_numbers.steps(docs_numbers.TUTORIAL.read_text(encoding="utf-8")):
        assert command.split()[0] == "ident" and command.split()[1] in COMMANDS
        assert shown, command


def test_every_claim_stands_in_its_document() -> None:
    for claim in docs_numbers.CLAIMS:
        text = (docs_numbers.ROOT / claim.document).read_text(encoding="utf-8")
        assert len(re.findall(claim.words, text)) == 1, claim.words


def test_figures_of_the_documents_exist_and_are_small() -> None:
    for page in (docs_numbers.ROOT / "docs").glob("*.md"):
        for link in re.findall(r"!?\[[^\]]*\]\(([^)#]+)\)", page.read_text(encoding="utf-8")):
            if "://" not in link:
                assert (page.parent / link).exists(), (page.name, link)
    assert all(f.stat().st_size < 120_000 for f in (docs_numbers.ROOT / "docs" / "figures").glob("*.png"))
