"""Tables as narrow as a pipe: no word is broken inside."""

from __future__ import annotations

import re

import pytest

from ident.report.words.sheet import Column, Sheet, sheet_text
from ident.report.words.widths import broken, columns_within

COMPARED = Sheet(
    "Models compared",
    (
        Column("run", wraps=True), Column("effects", wraps=True), Column("Δ ln Z", True, True),
        Column("probability", True), Column("Δ elpd", True), Column("held out/noise", True, True),
        Column("remark", wraps=True),
    ),
    (
        ("cubic-stiffness", "cubic-stiffness + power-law-damping", "-31920.7 ± 0.01", "< 0.01 %", "-19961.2", "19.4",
         "does not describe the records"),
    ),
    ("warning",),
)  # fmt: skip
POSTERIOR = Sheet(
    "Posterior",
    (
        Column("parameter"), Column("mean", True), Column("sd"), Column("90 % interval"), Column("unit"),
        Column("remark", wraps=True),
    ),
    (
        ("residual-stress.voltage_force", "498.59937", "± 0.000047", "498.59847 … 498.60029", "1e-24 m³/V³", ""),
        ("residual-stress.sigma12", "100", "± 34", "45 … 156", "MPa", "the prior decides"),
    ),
)  # fmt: skip


@pytest.mark.parametrize("width", [80, 100])
@pytest.mark.parametrize("sheet", [COMPARED, POSTERIOR], ids=["compare", "sample"])
def test_no_word_is_broken_inside(sheet: Sheet, width: int) -> None:
    text = sheet_text(sheet, width)
    assert max(map(len, text.splitlines())) <= width
    shown = {piece for line in text.splitlines()[1:] if "─" not in line for piece in line.split()}
    words = {word for row in (*sheet.rows, [c.name for c in sheet.columns]) for cell in row for word in cell.split()}
    assert shown <= {fragment for word in words for fragment in _fragments(word)}


def _fragments(word: str) -> set[str]:
    """The word, and what is between any two of its hyphens and the like."""
    parts = re.split(r"(?<=[-_/])", word)
    return {"".join(parts[i:j]) for i in range(len(parts)) for j in range(i + 1, len(parts) + 1)}


def test_names_are_broken_at_hyphens_and_numbers_are_not() -> None:
    assert broken("cubic-stiffness + drag", 10).splitlines() == ["cubic-", "stiffness", "+ drag"]
    assert broken("sine_8V_317Hz_40mg.csv", 17).splitlines() == ["sine_8V_317Hz_", "40mg.csv"]
    assert broken("-3 ± 0.01 mN/V at 1e-3", 4).splitlines() == ["-3", "± 0.01", "mN/V", "at", "1e-3"]


def test_what_may_be_broken_gives_way_first() -> None:
    cells = [("parameter.of_a_name",), ("some words that may be broken",)]
    assert columns_within(cells, [False, True], 40) == [19, 18]
    assert columns_within(cells, [False, True], 90) == [19, 29]
    assert sum(columns_within(cells, [False, True], 20)) <= 17
