"""docs/python.md runs as it stands, and prints what it shows."""

from __future__ import annotations

import contextlib
import io
import re
from pathlib import Path

import pytest

from experiments.docs_numbers import same

ROOT = Path(__file__).parent.parent


def cells(page: str) -> list[tuple[str, list[str]]]:
    """Each Python fence with the lines shown after it; four spaces go on with the line before."""
    found: list[tuple[str, list[str]]] = []
    for language, text in re.findall(r"^```(\w+)\n(.*?)^```", page, re.MULTILINE | re.DOTALL):
        if language == "python":
            found.append((text, []))
        else:
            whole = re.sub(r"\n {4}(?=\S)", " ", text)
            found[-1][1].extend(line for line in whole.splitlines() if line.strip() not in ("", "…"))
    return found


def test_the_page_runs_and_prints_what_it_shows(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(ROOT)
    names: dict = {"__name__": "page"}
    shown = cells((ROOT / "docs" / "python.md").read_text(encoding="utf-8"))
    assert len(shown) >= 6 and all(lines for _, lines in shown)
    for code, lines in shown:
        said = io.StringIO()
        with contextlib.redirect_stdout(said):
            exec(code, names)
        printed = said.getvalue().splitlines()
        assert [line for line in lines if not any(same(line, one) for one in printed)] == [], said.getvalue()
