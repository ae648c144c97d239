"""The choice of the linear model: its table, its sentences, and what `run.json` keeps of it."""

from __future__ import annotations

from typing import Any

from ...fit.linear.start_model import linear_choice
from ...fit.result import Fit
from .quantity import finite
from .sheet import Column, Mark, Sheet
from .tables import percent_text

_WORSE = 1.1  # times what gain and offset leave: the two are not taken over quite the same samples


def linear_sheet(fit: Fit) -> Sheet | None:
    """Every linear candidate with what it leaves of the signal, and its criterion; None where there was no choice."""
    choice = linear_choice(fit.campaign)
    if choice is None:
        return None
    best = choice.candidates[0].criterion
    rows = tuple(
        (c.words, percent_text(c.left), str(c.numbers), f"{c.criterion - best:.1f}", "*" if c is choice.chosen else "")
        for c in choice.candidates
    )
    marks: tuple[Mark, ...] = tuple("" if c is choice.chosen else "quiet" for c in choice.candidates)
    columns = (
        Column("linear model", wraps=True), Column("leaves of the signal", True), Column("numbers", True),
        Column("criterion", True), Column("chosen"),
    )  # fmt: skip
    asked = "" if choice.told == "auto" else f' (linear = "{choice.told}")'
    note = f"criterion: n ln(what is left) + k ln n above the least; it chooses where the model starts{asked}."
    return Sheet("Linear models compared", columns, rows, marks, note)


def worse_than_static(fit: Fit) -> str:
    """A sentence where gain and offset alone do better than the fit; empty else."""
    choice = linear_choice(fit.campaign)
    simple = choice.simplest if choice is not None else None
    share = fit.fitted.error_over_signal
    if simple is None or not share > _WORSE * simple.left:
        return ""
    return (
        f"This fit is worse than gain and offset alone: they leave {percent_text(simple.left)} of the signal, it "
        f"leaves {percent_text(share)}. Nothing that it says of the device holds."
    )


def linear_dict(fit: Fit) -> dict[str, Any]:
    """`"linear"` of `run.json`: the form of the linear part, and the candidates that were compared."""
    choice = linear_choice(fit.campaign)
    document: dict[str, Any] = {"form": fit.model.form, "told": fit.campaign.linear, "candidates": []}
    if choice is None:
        return document
    document["candidates"] = [
        {
            "model": c.words,
            "form": c.form,
            "constant": c.level,
            "error_over_signal": finite(c.left),
            "numbers": c.numbers,
            "criterion": finite(c.criterion),
            "chosen": c is choice.chosen,
        }
        for c in choice.candidates
    ]
    return document
