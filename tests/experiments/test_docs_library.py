"""`docs/library.md` says what the library says."""

import re

from experiments import docs_library


def test_the_page_is_up_to_date() -> None:
    assert docs_library.PAGE.read_text(encoding="utf-8") == docs_library.page(), "python -m experiments.docs_library"


def test_every_effect_and_every_parameter_is_on_the_page() -> None:
    text = docs_library.PAGE.read_text(encoding="utf-8").replace("\\", "")
    for effect in docs_library.effects():
        row = next(line for line in text.splitlines() if line.startswith(f"| `{effect['name']}`"))
        assert all(re.search(rf"\b{p['name']}\b", row) for p in effect["parameters"])


def test_every_row_has_four_cells() -> None:
    rows = [line for line in docs_library.page().splitlines() if line.startswith("|")]
    assert all(len(re.findall(r"(?<!\\)\|", row)) == 5 for row in rows)
