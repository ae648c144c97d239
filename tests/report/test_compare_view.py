"""What is said of models that were compared, and of shares of an offset: the number with its limits."""

from __future__ import annotations

from typing import Any

import pytest

from ident.report.attribution_view import attribution_sheet
from ident.report.compare_view import compare_figure, compare_sheet, headline
from ident.report.posterior_view import evidence_words


def document(verdict: str = "decided", described: bool = True, behind: float = 35.4) -> dict[str, Any]:
    one = {
        "run": "runs/a", "effects": ["power-law-stiffness"], "log_evidence": 0.0, "log_evidence_error": 0.01,
        "probability": 1.0, "elpd": 0.0, "holdout_error_over_noise": 19.43, "trusted": True,
        "describes_the_records": described,
    }  # fmt: skip
    other = one | {"run": "runs/b", "effects": [], "log_evidence": -behind, "probability": 4e-16, "elpd": -20.0}
    return {"models": [other, one], "verdict": verdict, "describes_the_records": described}


def test_the_headline_says_whether_the_best_is_any_good() -> None:
    assert headline(document()) == "decided"
    told = headline(document(described=False))
    assert told.startswith("decided among these, but even the best does not describe the records")
    assert "19.4 times the noise floor" in told
    earlier = {k: v for k, v in document(described=False).items() if k != "describes_the_records"}
    assert headline(earlier) == "decided"  # written before anything was said of it


def test_a_probability_is_no_power_of_ten() -> None:
    assert [row[3] for row in compare_sheet(document()).rows] == ["100 %", "< 0.01 %"]


def test_the_line_of_decision_runs_through_no_word() -> None:
    figure = compare_figure(document(described=False, behind=3.0))
    figure.canvas.draw()
    (axes,) = figure.axes
    line = next(line for line in axes.lines if line.get_linestyle() == "--")
    at = axes.transData.transform((line.get_xdata()[0], 0))[0]
    top = axes.get_window_extent().y1
    boxes = [text.get_window_extent() for text in axes.texts]
    assert len(boxes) == 3 and not any(box.x0 < at < box.x1 and box.y0 < top for box in boxes)
    assert "does not describe them" in figure.texts[-1].get_text()
    assert "logarithmic beyond 10" in axes.get_xlabel()


@pytest.mark.parametrize("lost", [[0], [0, 1]])
def test_a_model_without_evidence_has_a_row_and_a_bar_of_no_length(lost: list[int]) -> None:
    told = document(described=False)
    for i in lost:
        told["models"][i] |= {"log_evidence": None, "probability": None if len(lost) > 1 else 0.0, "elpd": None}
        told["models"][i] |= {"trusted": False}
    sheet = compare_sheet(told)
    assert sheet.rows[-1][2] == "–" and "no evidence" in sheet.rows[-1][-1]
    figure = compare_figure(told)
    figure.canvas.draw()
    assert [text.get_text() for text in figure.axes[0].texts].count("no evidence") == len(lost)
    assert "undecided" in headline(told | {"verdict": "undecided"})
    assert evidence_words({"value": None, "method": "importance sampling"}).startswith("No evidence was found")


def test_a_share_has_its_interval_and_the_note_says_how_it_passes_100_percent() -> None:
    share = lambda name, middle, low, high: {"mechanism": name, "share": middle, "interval90": [low, high]}
    overall = [share("a", 1.03, 0.95, 1.1), share("b", -0.034, -0.036, -0.032), share("c", 1.0, 1.0, 1.0)]
    sheet = attribution_sheet({"mechanisms": ["a", "b", "c"], "records": [], "overall": overall})
    assert sheet.rows == (("all together", "", "", "103 % (95…110)", "-3.4 % (-3.6…-3.2)", "100 %"),)
    assert "Beyond 100 %" in sheet.note and "works against it" in sheet.note
