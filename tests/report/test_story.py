"""The error falling step by step, also where a step has none to show."""

from __future__ import annotations

from ident.report.story import change_sheet, moved_sheet, staircase_figure


def entry(added: str, before: float | None, after: float | None) -> dict:
    score = lambda error: {"error_over_noise": error}
    return {
        "effects": [added], "added": added, "removed": None, "parameters": {},
        "before": {"fitted": score(9.0), "holdout": score(before)},
        "after": {"fitted": score(3.0), "holdout": score(after)},
    }  # fmt: skip


def test_a_motion_without_bound_has_no_error_but_a_row_and_a_picture():
    lineage = [entry("cubic-stiffness", 8.0, 2.0), entry("unknown-effect", 2.0, None)]
    assert "no bound" in change_sheet(lineage).rows[1]
    assert staircase_figure(lineage).axes


def test_a_parameter_without_a_value_has_not_moved():
    """JSON writes a number that is not finite as null."""
    told = {"before": 4.0, "after": 5.0, "standard_error": 0.1}
    step = entry("cubic-stiffness", 8.0, 2.0) | {
        "parameters": {"a": told | {"before": None}, "b": told | {"after": None}, "c": told}
    }
    sheet = moved_sheet(step)
    assert sheet is not None and [row[0] for row in sheet.rows] == ["c"]
