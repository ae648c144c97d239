"""An effect that contains simpler ones, taken apart: are a few of these the whole truth?"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import NamedTuple

import numpy as np

from ...effects.effect import AbstractEffect
from ...fit import Fit
from ..evidence.criterion import STRONG, behind
from ..evidence.enough import ANOTHER_LAW
from ..linearised.regression import prepare
from ..linearised.trajectory import Diverged
from ..ranking.confirm import accept, confirm
from ..ranking.score import score, significant
from .change import try_without


class Parts(NamedTuple):
    """`names`, the simpler effects that do as well as the one called `whole`, or `better`; the fit with them, and that
    with the whole; `near`, whether the whole leaves no more than laws of one kind differ by."""

    whole: str
    names: tuple[str, ...]
    fit: Fit
    better: bool
    undivided: Fit
    near: bool = True

    @property
    def words(self) -> str:
        """Both answers."""
        together = " and ".join(self.names) + (" together" if len(self.names) > 1 else "")
        return f"{together}, or {self.whole} alone" if self.better else f"{self.whole}, or {together}"


def take_apart(
    last: Fit,
    added: Sequence[str],
    library: Mapping[str, type[AbstractEffect]],
    start: Fit,
    report: Callable[[str], None],
) -> list[Parts]:
    """The added effects that simpler ones out of what they `contain` explain as well, up to the first that they
    explain better.

    A law with several parameters mimics any two of the simple ones that it implies, and a walk that adds one effect at
    a time meets it first. But one name is a simpler answer than two: each further one costs 2 ln(size of the library).
    Beyond that the evidence must be strong for either answer; in between, both are given.
    """
    alike: list[Parts] = []
    for effect in (library[name] for name in added):
        simple = {n: library[n] for n in effect.contains if n in library and n not in last.model.names}
        if not simple or last.model.carries(effect.name):
            continue
        report(f"is {effect.name} the sum of simpler effects?")
        whole, current, names = prepare(last), try_without(last, effect.name, start), []
        try:
            regression = without = prepare(current)
            while best := next(iter(significant(score(regression, simple))), None):
                trial = confirm(regression, simple[best.name], best)
                if not (trial.possible and behind(trial, regression) < 0):
                    break
                current = accept(trial, current)
                regression, names = prepare(current), [*names, best.name]
        except Diverged:  # a motion without bound explains nothing
            continue
        worse = behind(regression, whole) + 2 * np.log(len(library)) * (len(names) - 1)
        if names and worse < -STRONG:
            near = whole.fit_chi2 - regression.fit_chi2 < ANOTHER_LAW * without.excess
            return [*alike, Parts(effect.name, tuple(names), current, True, last, near)]
        if names and worse < STRONG:
            alike.append(Parts(effect.name, tuple(names), current, False, last))
    return alike
