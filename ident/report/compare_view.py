"""Models weighed against one another: `compare.json`, its table and its figure."""

from __future__ import annotations

import math
import os
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ..posterior.compare import DECISIVE, Comparison, Weighed
from .figures.style import HELDOUT, INK, MODEL, RESIDUAL, key, label, new_axes, new_figure
from .words.quantity import finite
from .words.sheet import Column, Sheet

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_LINEAR = 10.0  # nats, up to which the axis is linear
_BEFORE = 1.5  # nats, from which a number beside a bar would reach the line of decision


def compare_dict(found: Comparison) -> dict[str, Any]:
    """A comparison as plain numbers, format 1."""
    return {
        "format": 1,
        "models": [_model(m) for m in found.models],
        "verdict": found.verdict,
        "best": found.models[found.best].name,
        "lead": finite(found.lead),
        "lead_error": found.error,
        "describes_the_records": found.describes,
        "words": found.words,
    }


def headline(document: Mapping[str, Any]) -> str:
    """The verdict in one sentence, from `compare.json`: which of the models, and whether that one is any good."""
    if document.get("describes_the_records", True):
        return document["verdict"]
    held = _ahead(document)["holdout_error_over_noise"]
    far = "" if held is None else f" (held-out error {held:.3g} times the noise floor)"
    return f"{document['verdict']} among these, but even the best does not describe the records{far}"


def _ahead(document: Mapping[str, Any]) -> Mapping[str, Any]:
    return _ordered(document)[0]


def _ordered(document: Mapping[str, Any]) -> list[Mapping[str, Any]]:
    """The models, the best first; those without evidence, which JSON has as null, last."""
    return sorted(document["models"], key=lambda m: -_number(m["log_evidence"], -math.inf))


def _number(told: float | None, else_: float = math.nan) -> float:
    """A number as JSON has it, where null stands for one that is not finite."""
    return else_ if told is None else told


def _model(one: Weighed) -> dict[str, Any]:
    holdout = one.fit.holdout
    return {
        "run": one.name,
        "effects": list(one.fit.model.names),
        "log_evidence": finite(one.evidence.value),
        "log_evidence_error": one.evidence.error,
        "log_evidence_laplace": one.evidence.laplace,
        "pareto_k": finite(one.evidence.shape),
        "efficiency": one.evidence.efficiency,
        "trusted": one.evidence.trusted,
        "probability": finite(one.probability),
        "elpd": finite(one.left_out.elpd),
        "elpd_error": finite(one.left_out.error),
        "elpd_bad_blocks": one.left_out.bad,
        "heldout_log_score": one.heldout,
        "holdout_error_over_noise": None if holdout is None else holdout.error_over_noise,
        "describes_the_records": not one.misfit.reasons,
    }


def compare_sheet(document: Mapping[str, Any]) -> Sheet:
    """Every model with its evidence and scores, the best first."""
    models = _ordered(document)
    best = models[0]
    folders = [Path(m["run"]).absolute() for m in models]
    shared = os.path.commonpath([folder.parent for folder in folders])
    rows, marks = [], []
    for m, folder in zip(models, folders, strict=True):
        holdout = m["holdout_error_over_noise"]
        ahead = _number(m["log_evidence"]) - _number(best["log_evidence"])
        predicts = _number(m["elpd"]) - _number(best["elpd"])
        doubt = [] if m["trusted"] else ["evidence not to be trusted"]
        doubt = ["no evidence"] if m["log_evidence"] is None else doubt
        doubt += [] if m["describes_the_records"] else ["does not describe the records"]
        rows.append((str(folder.relative_to(shared)), " + ".join(m["effects"]) or "linear",
                     f"{ahead:.1f} ± {m['log_evidence_error']:.2f}" if math.isfinite(ahead) else "–",
                     _probability(m["probability"]),
                     f"{predicts:.1f}" if math.isfinite(predicts) else "–",
                     "–" if holdout is None else f"{holdout:.3g}",
                     "; ".join(doubt)))  # fmt: skip
        marks.append("total" if m is best else "warning" if doubt else "")
    columns = (
        Column("run", wraps=True), Column("effects", wraps=True), Column("Δ ln Z", True, True),
        Column("probability", True), Column("Δ elpd", True), Column("held out/noise", True, True),
        Column("remark", wraps=True),
    )  # fmt: skip
    note = "Δ: against the best. elpd: ln predictive density of left-out stretches of time."
    return Sheet("Models compared", columns, tuple(rows), tuple(marks), note)


def _probability(share: float | None) -> str:
    if share is None:
        return "–"
    return f"{100 * share:.3g} %" if share > 1e-4 else "< 0.01 %"


def compare_figure(document: Mapping[str, Any]) -> Figure:
    """How far each model is behind the best, in nats of evidence (bar) and of left-out prediction (dot)."""
    models = _ordered(document)
    height = 0.5 * len(models) + 1.75
    figure = new_figure(10.6, height)
    axes = new_axes(figure, 0.36, 0.82 / height, 0.56, 1 - 1.6 / height)
    best = models[0]
    behind = [_number(best["log_evidence"]) - _number(m["log_evidence"]) for m in models]
    missed = [np.maximum(_number(best["elpd"]) - _number(m["elpd"]), 0.0) for m in models]  # keeps NaN: no dot
    places = [-i for i in range(len(models))]
    colours = [MODEL if i == 0 else HELDOUT for i in range(len(models))]
    axes.barh(places, np.nan_to_num(np.maximum(behind, 0.0)), height=0.55, color=colours)
    axes.plot(missed, places, "o", color=INK, ms=5)
    axes.set_xscale("symlog", linthresh=_LINEAR)
    axes.set_xlim(0, max(20.0, 3.0 * max([0.0, *filter(math.isfinite, [*behind, *missed])])))
    axes.axvline(DECISIVE, color=RESIDUAL, lw=1.2, ls="--")
    axes.set_ylim(places[-1] - 0.6, 0.6)
    above = axes.get_xaxis_transform()
    axes.text(
        DECISIVE,
        1.02,
        f"decided beyond {DECISIVE:g}",
        fontsize=9,
        color=RESIDUAL,
        ha="center",
        va="bottom",
        transform=above,
    )
    axes.set_yticks(places, [" + ".join(m["effects"]) or "linear alone" for m in models])
    axes.tick_params(axis="y", length=0)
    axes.minorticks_off()
    axes.xaxis.set_major_formatter("{x:g}")
    for place, b, dot, m in zip(places, behind, missed, models, strict=True):
        known = math.isfinite(b)
        text = (f"{b:.1f}" if b < 1000 else f"{b:.0f}") if known else "no evidence"
        if m is best and known:
            text = f"best: {100 * m['probability']:.3g} %"
        reached = max(filter(math.isfinite, (0.0, b, dot)))
        at = (
            DECISIVE if _BEFORE < reached < DECISIVE or m is best and reached < DECISIVE else reached
        )  # not on its line
        axes.annotate(text, (at, place), (8, 0), textcoords="offset points", va="center", fontsize=9)
    label(axes, f"nats behind the best (a nat: odds of 2.7; logarithmic beyond {_LINEAR:g})")
    key(figure, 0.92, 0.2 / height, ("bar: evidence", HELDOUT), ("dot: left-out prediction", INK))
    decided, described = document["verdict"] == "decided", document.get("describes_the_records", True)
    words = "The records decide for" if decided else "The records do not decide; ahead is"
    doubt = "" if described else ", but it does not describe them"
    title = f"{words} {' + '.join(best['effects']) or 'the linear model'}{doubt}"
    colour = INK if decided and described else RESIDUAL
    figure.text(0.012, 1 - 0.24 / height, title, fontsize=12, weight="bold", color=colour, va="center")
    return figure
