"""A fit for those who work in Python: parameters by name, tables, a short face in a notebook."""

from __future__ import annotations

from collections.abc import Sequence
from html import escape
from typing import TYPE_CHECKING, Any

import numpy as np

from ..errors import UserError, nearest

if TYPE_CHECKING:
    from pandas import DataFrame

    from .result import Fit


def position(names: Sequence[str], name: str) -> int:
    """Where a parameter stands, by its full name ("platform.quality") or by what is behind the point if one has it."""
    found = [k for k, one in enumerate(names) if one == name]
    found = found or [k for k, one in enumerate(names) if one.rpartition(".")[2] == name]
    if len(found) == 1:
        return found[0]
    if found:
        do = f"{' or '.join(names[k] for k in found)}?"
        raise UserError(f"{name!r} is the name of {len(found)} parameters", do=do)
    short = (one.rpartition(".")[2] for one in names)
    do = nearest(name, [*names, *short], f"the parameters are {', '.join(names)}")
    raise UserError(f"the model has no parameter {name!r}", do=do)


def parameters_frame(fit: Fit) -> DataFrame:
    """Value, standard error (NaN where there is none), unit and flags of every parameter, by its name."""
    from pandas import DataFrame

    rows = [(e.value, np.nan if e.standard_error is None else e.standard_error, e.unit, e.fitted, ", ".join(e.flags))
            for e in fit.estimates]  # fmt: skip
    return DataFrame(rows, columns=["value", "error", "unit", "fitted", "flags"], index=[e.name for e in fit.estimates])


def covariance_frame(fit: Fit) -> DataFrame:
    """Covariance of the fitted parameters (SI), rows and columns by their names."""
    from pandas import DataFrame

    names = [fit.model.parameters[i].name for i in fit.free]
    return DataFrame(np.asarray(fit.covariance), index=names, columns=names)


def residuals(fit: Fit) -> dict[str, np.ndarray]:
    """Per record (n,) measured − model, in the SI unit of the response."""
    pairs = zip(fit.campaign.traces, fit.readings, strict=True)
    return {record.name: record.response - np.asarray(reading) for record, reading in pairs}


def line(fit: Fit) -> str:
    """The fit in one line."""
    effects = ", ".join(fit.model.names) or "the linear model alone"
    held = "" if fit.holdout is None else f", held out {fit.holdout.error_over_noise:#.3g}"
    state = "" if fit.converged else ", not converged"
    return f"<Fit of {effects}: error over noise {fit.fitted.error_over_noise:#.3g}{held}{state}>"


def html(fit: Fit) -> str:
    """The same with a table of the parameters, for a notebook."""
    rows: list[Any] = []
    for e in fit.estimates:
        error = "" if e.standard_error is None else f"{e.standard_error:.2g}"
        cells = (e.name, f"{e.value:.6g}", error, e.unit, ", ".join(e.flags))
        rows.append("<tr>" + "".join(f"<td>{escape(cell)}</td>" for cell in cells) + "</tr>")
    head = "".join(f"<th>{word}</th>" for word in ("parameter", "value", "error", "unit", "flags"))
    return f"<p>{escape(line(fit))}</p><table><tr>{head}</tr>{''.join(rows)}</table>"
