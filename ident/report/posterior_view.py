"""A posterior to look at: its table, its verdict in a sentence, and each parameter before and after the records."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from ..campaign.device import Device
from ..posterior.pareto import TRUSTED
from ..posterior.result import Marginal, Posterior
from .figures.picture import draw_kept
from .figures.style import FAINT, INK, MODEL, RESIDUAL, new_axes, new_figure
from .html import Section
from .words.quantity import Shown, display_unit, scale, show, show_in
from .words.sheet import Column, Sheet

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_ACROSS = 3
_EDGE = 0.06  # of a panel's width that has no tick
_WIDE = 4.0  # standard deviations shown to each side


def verdict_words(document: Mapping[str, Any]) -> str:
    """Whether the intervals are final, in one sentence, from `posterior.json`."""
    size = (
        f"{document['draws']} draws worth {document['ess_min']:.0f} independent ones, R-hat {document['rhat_max']:.3f}"
    )
    if document["trusted"]:
        return f"The intervals are final: {size}."
    return f"The intervals are NOT FINAL, because {'; '.join(document['reasons'])}. So far {size}."


def evidence_words(told: Mapping[str, Any]) -> str:
    """The evidence in one sentence, from `posterior.json`."""
    if told["value"] is None:
        return f"No evidence was found ({told['method']}): the records are impossible at every draw."
    k = "none" if told["pareto_k"] is None else f"{told['pareto_k']:.2f}"
    doubt = "" if told["trusted"] else f"; not to be trusted, because k is above {TRUSTED}"
    return (
        f"Log evidence {told['value']:.2f} ± {told['error']:.2f} ({told['method']}, "
        f"efficiency {told['efficiency']:.2f}, Pareto k {k}; Laplace {told['laplace']:.2f}){doubt}."
    )


def posterior_sheet(document: Mapping[str, Any], device: Device) -> Sheet:
    """Mean, standard deviation and 90 % interval of every parameter, from `posterior.json`."""
    rows, marks = [], []
    for told in document["parameters"]:
        shown = show(told["mean"], told["sd"], told["unit"], device)
        chosen = scale(max(abs(told["mean"]), told["sd"]), told["unit"], device)
        low, high = (show_in(v, told["sd"], chosen).value for v in told["interval90"])
        remark = "the prior decides" if told["prior_decides"] else ""
        rows.append((told["name"], shown.value, f"± {shown.error}", f"{low} … {high}", shown.unit, remark))
        marks.append("warning" if told["prior_decides"] or not document["trusted"] else "")
    last = "90 % interval" if document["trusted"] else "90 %, NOT FINAL"
    columns = (
        Column("parameter"), Column("mean", True), Column("sd"), Column(last), Column("unit"),
        Column("remark", wraps=True),
    )  # fmt: skip
    worst = max(told["monte_carlo_error"] / told["sd"] for told in document["parameters"] if told["sd"] > 0)
    note = f"Monte-Carlo error of a mean: at most {100 * worst:.2g} % of its sd."
    return Sheet("Posterior", columns, tuple(rows), tuple(marks), note)


def prior_sheet(document: Mapping[str, Any], device: Device) -> Sheet:
    """What was assumed of each parameter beforehand, why, and how much narrower the records made it."""
    rows, marks = [], []
    for told in document["parameters"]:
        words = prior_words(told["prior"], told["unit"], device)
        rows.append((told["name"], words, told["prior"]["source"], f"{_narrower(told['contraction'])}×"))
        marks.append("warning" if told["prior_decides"] else "")
    columns = (Column("parameter"), Column("prior", wraps=True), Column("why", wraps=True), Column("narrowed", True))
    return Sheet("Priors", columns, tuple(rows), tuple(marks))


def prior_words(prior: Mapping[str, Any], unit: str, device: Device) -> str:
    """ "0 ± 100 MPa", "(0 ± 1.6) 1e6 N/m²", "505 Hz × or ÷ 1.2", "any size from 0.5 to 1e+06"."""
    if prior["kind"] == "log-uniform":
        if not display_unit(unit, device):
            return "any size from {:.3g} to {:.3g}".format(*prior["limits"])
        return "any size from {} to {}".format(*(show(limit, None, unit, device) for limit in prior["limits"]))
    if prior["kind"] == "normal":
        chosen = scale(max(abs(prior["centre"]), prior["spread"]), unit, device)
        centre, spread = (show_in(v, None, chosen, 3).value for v in (prior["centre"], prior["spread"]))
        return str(Shown(centre, spread, chosen.unit))
    return f"{show(prior['centre'], None, unit, device)} × or ÷ {math.exp(prior['spread']):.2g}"


def posterior_figure(posterior: Posterior) -> Figure:
    """Each parameter on a panel of its own: what was assumed (line) and what the records leave (filled)."""
    marginals, device = posterior.marginals, posterior.fit.model.device
    values = posterior.draws(8000)[:, list(posterior.density.static.free)]
    down = -(-len(marginals) // _ACROSS)
    height = 1.75 * down + 0.85
    figure = new_figure(10.6, height)
    for k, marginal in enumerate(marginals):
        row, column = divmod(k, _ACROSS)
        bottom = 1 - (0.8 + 1.75 * (row + 1) - 0.62) / height
        axes = new_axes(figure, 0.025 + 0.328 * column, bottom, 0.295, 0.78 / height)
        _panel(figure, axes, marginal, values[:, k], device, bottom + 1.0 / height)
    final = "90 % intervals" if posterior.trusted else "NOT FINAL"
    title = f"What the records say of each parameter: {final}"
    at = 1 - 0.24 / height
    figure.text(0.012, at, title, fontsize=12, weight="bold", color=INK if posterior.trusted else RESIDUAL, va="center")
    figure.text(0.86, at, "after", fontsize=10, weight="bold", color=MODEL, va="center", ha="right")
    figure.text(0.985, at, "before (prior)", fontsize=10, weight="bold", color=FAINT, va="center", ha="right")
    return figure


def _panel(figure: Figure, axes: Axes, marginal: Marginal, values: np.ndarray, device: Device, top: float) -> None:
    unit = scale(max(abs(marginal.mean), marginal.deviation), marginal.prior.unit, device)
    decides = marginal.prior_decides
    colour = RESIDUAL if decides else MODEL
    reach = _WIDE * marginal.deviation
    if decides and marginal.prior.kind == "normal":
        reach = max(reach, 2.5 * marginal.prior.spread)
    low = max(marginal.mean - reach, marginal.prior.lower)
    high = min(marginal.mean + reach, marginal.prior.upper)
    heights, edges = np.histogram(values, bins=60, range=(low, high), density=True)
    axes.fill_between(edges[:-1] / unit.factor, heights * unit.factor, step="post", color=colour, alpha=0.75, lw=0)
    at = np.linspace(low, high, 200)[1:-1]
    axes.plot(at / unit.factor, marginal.prior.density(at) * unit.factor, color=FAINT, lw=1.4)
    for edge in (marginal.low, marginal.high):
        axes.axvline(edge / unit.factor, color=INK, lw=0.8, ls=":")
    axes.set_yticks([])
    axes.spines["left"].set_visible(False)
    axes.set_ylim(0, float(heights.max()) * unit.factor * 1.08)
    axes.set_xlim(low / unit.factor, high / unit.factor)
    axes.locator_params(axis="x", nbins=4)
    axes.ticklabel_format(axis="x", useOffset=False, style="plain")
    shown = [x for x in axes.get_xticks() if _EDGE < (x * unit.factor - low) / (high - low) < 1 - _EDGE]
    axes.set_xticks(shown)  # a number at the edge would touch that of the next panel
    left = axes.get_position().x0
    name = marginal.prior.name + (f"  ({unit.unit})" if unit.unit else "")
    figure.text(left, top + 0.012, name, fontsize=9.5, color=INK, weight="bold", va="bottom")
    words = "the prior decides" if decides else f"{_narrower(marginal.contraction)} times narrower than before"
    figure.text(left, top - 0.002, words, fontsize=8.5, color=colour if decides else FAINT, va="top")


def posterior_section(posterior: Posterior, document: Mapping[str, Any]) -> Section:
    """The part of the report about a posterior, whose `posterior.json` is the `document`."""
    device = posterior.fit.model.device
    caption = "Each parameter before (line) and after (filled) the records; dotted: 90 % interval"
    paragraphs = (verdict_words(document), evidence_words(document["log_evidence"]), *document["notes"])
    sheets = (posterior_sheet(document, device), prior_sheet(document, device))
    return Section("Posterior", paragraphs, sheets, (draw_kept(caption, posterior_figure(posterior)),))


def _narrower(contraction: float) -> str:
    """How many times narrower an interval became, "1.3" or "180000": no engineer reads 1.8e+05."""
    times = f"{1 / math.sqrt(max(1.0 - contraction, 1e-12)):.2g}"
    return f"{float(times):.0f}" if float(times) >= 10 else times
