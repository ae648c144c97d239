"""Beyond the library: what is missing is estimated, written as an effect file, and joins the model like any other."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import NamedTuple

from ...effects.registry import registry
from ...fit import Fit, fit
from ...pulse import Report
from ..linearised.regression import Regression
from ..linearised.shorten import CRAWLS
from ..unknown.effect_file import write_effect
from ..unknown.find import Unknown
from .change import add

NAME = "unknown-effect"


class Beyond(NamedTuple):
    """The missing term, the file it was written to, and the fit with it."""

    unknown: Unknown
    path: Path
    fit: Fit


def go_beyond(
    fitted: Fit, regression: Regression, unknown: Unknown, path: Path, report: Report = lambda _: None
) -> Beyond:
    """Write what a fit lacks to a file that does not exist yet, and refit with it, in as many steps as models that are
    compared.

    **Arguments:** `regression`: of the fit, or of its `working` excerpt; `unknown`: what `find_unknown` says there.

    **Raises:** UserError if the file exists.
    """
    name = free_name(fitted)
    write_effect(unknown, path, name)
    files = (*fitted.campaign.effect_files, path)
    known = lambda parent: replace(parent, campaign=replace(parent.campaign, effect_files=files))
    # Its numbers are estimates, and no guesses.
    found = add(known(regression.fit), registry(files)[name], report, others=0, most=CRAWLS)
    if regression.fit is not fitted:
        found = fit(found.model, known(fitted).campaign, initial=found.values, report=report, most=CRAWLS)
    return Beyond(unknown, path, found)


def free_name(fitted: Fit) -> str:
    """A name that neither the model nor the campaign's own effects use."""
    taken = set(fitted.model.names) | set(registry(fitted.campaign.effect_files))
    names = (NAME if i == 1 else f"{NAME}-{'abcdefghijklmnopqrstuvwxyz'[i - 1]}" for i in range(1, 27))
    return next(name for name in names if name not in taken)
