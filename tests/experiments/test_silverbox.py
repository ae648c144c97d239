"""The steps of `docs/silverbox.md` reach the errors that the page shows."""

import re
from pathlib import Path

import pytest

from experiments import public_data
from experiments.silverbox import silverbox


@pytest.mark.slow
def test_every_step_reaches_its_bound(tmp_path: Path) -> None:
    if not public_data.available("silverbox", silverbox.FILES):
        pytest.skip(f"{public_data.data_folder('silverbox')} lacks the files; IDENT_BENCHMARKS names another folder")
    found = [*silverbox.walk(tmp_path), silverbox.discover(tmp_path)[1]]
    for shown, errors in zip(_table(), found, strict=True):
        assert shown == pytest.approx(errors, rel=0.02)


def test_the_page_shows_the_commands_that_the_script_runs() -> None:
    text = silverbox.PAGE.read_text(encoding="utf-8")
    shown = [line for line in text.splitlines() if line.startswith("ident ")]
    assert shown[:-1] == ["ident " + " ".join(step.arguments) for step in silverbox.STEPS]
    assert shown[-1] == "ident discover blind -o runs/discovered"


def test_the_numbers_of_the_page_keep_the_bounds() -> None:
    *walked, alone = _table()
    for (_, multisine, arrow), step in zip(walked, silverbox.STEPS, strict=True):
        assert arrow <= step.arrow and multisine <= step.multisine
    assert alone[2] <= silverbox.ARROW_ALONE


def _table() -> list[tuple[float, ...]]:
    """Errors of the page in mV, a row per model: training, test multisine, test arrow."""
    text = silverbox.PAGE.read_text(encoding="utf-8").partition("| model |")[2]
    rows = re.findall(r"\| ([\d.]+) \| ([\d.]+) \| ([\d.]+) \|", text)
    return [tuple(map(float, row)) for row in rows]
