"""Laws that carry over to fitted records but not to held-out ones: does one of their finer numbers do?

A walk asks for what refines a law where it leaves more than noise of the fitted records. These may hardly show the
shape by which others are predicted: plays of a straight line of weights left 1.02 noise floors of five records, and
2.4 of two more, where weights of their own left 1.00 of all.
"""

from __future__ import annotations

from ...effects.effect import AbstractEffect
from ...fit import Fit
from ...pulse import Report
from ..evidence.criterion import clearly_better
from ..evidence.held_out import foretold, hurts
from ..linearised.regression import prepare
from ..linearised.shorten import CRAWLS, working
from ..linearised.trajectory import Diverged
from ..ranking.confirm import accept, refined
from ..ranking.starts import refinements
from .change import ENOUGH, from_its_score


def with_finer_laws(last: Fit, start: Fit, report: Report) -> Fit:
    """A fit with what refines its laws free, one law after the other, where held-out records are not foretold and the
    fitted ones clearly choose that; `start`: the fit before any effect was added."""
    for effect in last.model.effects:
        if not refinements(effect) - last.model.freed or last.model.carries(effect.name) or foretold(last):
            continue
        report(f"does {effect.name} need its finer numbers to carry over?")
        try:
            finer = _finer(last, type(effect), start)
            if finer is None:
                continue
            better = clearly_better(prepare(working(finer)), prepare(working(last)))
        except Diverged:
            continue
        if better and not hurts(last, finer):
            last = finer
    return last


def _finer(last: Fit, effect: type[AbstractEffect], start: Fit) -> Fit | None:
    """The fit with all numbers of an effect, which begin where its score leads: a law that was too plain may have bent
    its shapes."""
    found = from_its_score(last, effect.name, effect, start, ENOUGH, refining=False)
    if found is None:
        return None
    below, plain = found
    finer = refined(below, effect, plain, CRAWLS)
    return accept(finer, last) if finer is not plain else None
