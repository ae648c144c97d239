"""What stood against each step of a walk, as it is kept and as it is told."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any, cast

from ident.diagnosis.document import _step
from ident.diagnosis.search.rivals import Rival, rivals_of
from ident.diagnosis.search.steps import Step
from ident.report import walk_json
from ident.report.candidates_view import later_sheet, ranking_sheet

_ERRORS = SimpleNamespace(error_over_noise=1.0, error_over_signal=0.01)
FIT: Any = SimpleNamespace(fitted=_ERRORS, holdout=None, model=SimpleNamespace(device=None))


def candidate(name: str, gain: float) -> Any:
    return SimpleNamespace(name=name, predicted_gain=gain, p_value=0.3, errors={}, values={}, units={})


def step(name: str, *rivals: Rival) -> Step:
    return Step(name, 0.9, 0.95, (name,), "effect", FIT, rivals=rivals)


def found(verdict: str, *steps: Step, ranking: tuple[Any, ...] = ()) -> Any:
    return SimpleNamespace(
        discovery=SimpleNamespace(verdict=verdict, steps=steps, ranking=ranking, confirmed={}, start=FIT)
    )


def test_what_was_refitted_stood_nearest() -> None:
    real = [candidate(name, gain) for name, gain in (("a", 0.99), ("b", 0.9), ("c", 0.8), ("d", 0.7))]
    kept = rivals_of("a", real, {"a": 0.98, "c": 0.71, "d": 0.93})
    assert kept == (Rival("d", 0.7, 0.93), Rival("c", 0.8, 0.71), Rival("b", 0.9, None))


def test_every_later_step_shows_what_stood_against_it() -> None:
    walked = found("identified", step("a", Rival("z", 0.5)), step("b", Rival("c", 0.93, 0.71), Rival("d", 0.4)))
    sheet = later_sheet(walked)
    assert sheet is not None
    assert sheet.rows == (
        ("+ b", "", "90.0 %", "95.0 %"), ("", "c", "93.0 %", "71.0 %"), ("", "d", "40.0 %", "–"),
    )  # fmt: skip
    assert later_sheet(found("identified", step("a", Rival("z", 0.5)))) is None  # the first has its own table


def test_the_document_holds_the_rivals_of_each_step() -> None:
    assert _step(step("a", Rival("z", 0.5)))["rivals"] == [
        {"effect": "z", "predicted_gain": 0.5, "confirmed_gain": None}
    ]


def test_a_walk_keeps_its_rivals_and_one_of_an_earlier_version_has_none() -> None:
    one = step("a", Rival("z", 0.5, 0.4))
    told = {name: getattr(one, name) for name in walk_json._OWN}
    assert walk_json._step({**told, "rivals": [["z", 0.5, 0.4]]}, cast(Any, FIT)).rivals == one.rivals
    assert walk_json._step(told, cast(Any, FIT)).rivals == ()


def test_of_noise_no_share_is_told() -> None:
    """All of nothing is 100 %, and said beside a candidate it reads as if that were missing."""
    names = lambda sheet: [column.name for column in sheet.columns]
    ranking = (candidate("a", 1.0),)
    assert "predicted" in names(ranking_sheet(found("identified", step("a"), ranking=ranking)))
    sheet = ranking_sheet(found("adequate", ranking=ranking))
    assert names(sheet) == ["candidate", "estimated size", "by chance"]
    assert sheet.title.startswith("Nothing is missing") and "%" not in str(sheet.rows)
