"""Why `ident diagnose --write-effect` has written nothing."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import pytest

from ident.report.diagnosis_view import why_not_written


@pytest.mark.parametrize(
    ("said", "verdict", "told"),
    [
        ("nothing is missing", "adequate", {}),
        ("wrong with the records", "ambiguous", {"suspects": (SimpleNamespace(first=True, file="a.csv"),)}),
        ("in traces only", "not-in-library", {"traces": ()}),
        ("no term describes", "not-in-library", {"unknown": object()}),
        ("held-out ones", "not-in-library", {"holdout": SimpleNamespace(error_over_noise=float("inf"))}),
        ("in whole records only", "not-in-library", {}),
        ("no law that a simulation keeps", "ambiguous", {"unknown": object()}),
        ("come near", "ambiguous", {"steps": (object(),), "lacking": 0.1, "unknown": object()}),
        ("effects of the library explain", "identified", {"steps": (object(),)}),
        ("effects of the library explain", "ambiguous", {"steps": (object(),)}),
    ],
)
def test_it_says_the_true_reason(said: str, verdict: str, told: dict[str, Any]) -> None:
    campaign = SimpleNamespace(fitted=told.get("traces", (object(),)), left_out=())
    final = SimpleNamespace(campaign=campaign, holdout=told.get("holdout"))
    steps, lacking = told.get("steps", ()), told.get("lacking", 0.0)
    loop = SimpleNamespace(verdict=verdict, final=final, steps=steps, lacking=lacking)
    suspects = told.get("suspects", ())
    found: Any = SimpleNamespace(discovery=loop, final=final, unknown=told.get("unknown"), suspects=suspects)
    assert said in why_not_written(found)
