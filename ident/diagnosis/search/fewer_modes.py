"""The further modes of the linear side, questioned once effects have their place: a mode may have mimicked what was
missing, as a strongly damped one does a support that relaxes, and one at twice the frequency the overtone of a law.

It was chosen before the effects were known, and is none; but like one it has to be needed, and to say more than
another effect in its place.
"""

from __future__ import annotations

from collections.abc import Sequence

from ...effects.registry import Registry
from ...fit import Fit
from ...fit.linear.start_model import linear_choice, modes_of
from ...fit.rebuild import values_without
from ...pulse import Report
from ..evidence.criterion import behind
from ..evidence.enough import superfluous
from ..evidence.held_out import hurts, hurts_more
from ..linearised.regression import Regression, prepare
from ..linearised.shorten import is_long
from ..linearised.trajectory import Diverged
from ..ranking.confirm import accept, confirm
from .change import ENOUGH, without
from .parts import without_one
from .prune import rivals


def without_a_mode(start: Fit, last: Fit, library: Registry, first: Regression, report: Report) -> Fit | None:
    """The first model of a walk without that further mode which its `last` model needs least, if that does as well
    without, or with an effect in its place: the walk then begins again from there."""
    campaign = start.campaign
    choice = linear_choice(campaign)
    further = modes_of(campaign)[: len(choice.chosen.further)] if choice is not None and campaign.modes is None else ()
    chosen = [one for one in start.model.names if one in further and one not in campaign.effects]
    if not chosen or is_long(campaign):  # excerpts hold nothing out
        return None
    report(f"does the model still need {' and '.join(chosen)}?")
    found = without_one(last, chosen, start)
    if found is None or not _does_as_well(last, *found, start, library, first):
        return None
    try:
        fewer = without(start, [found[2]])
        prepare(fewer)
    except Diverged:  # without it the motion of the first model has no bound
        return None
    report(f"another answer needs no {found[2]}: once more, without it")
    return fewer


def without_its_mode(
    fitted: Fit, start: Fit, added: Sequence[str], first: Regression, report: Report
) -> tuple[Fit, Regression] | None:
    """A fit without that mode which it needs least of those that joined its model on the walk, and the regression, if
    that does as well; `added`: the effects of the walk's steps."""
    known = {*start.model.names, *added}
    joined = [one for one in fitted.model.names if one in modes_of(fitted.campaign) and one not in known]
    found = None if is_long(fitted.campaign) else without_one(fitted, joined, start)
    if found is None:
        return None
    less, regression, mode = found
    if not superfluous(regression, prepare(fitted), first) or hurts(fitted, less):
        return None
    report(f"now that it has {added[-1]}, {mode} rings no more")
    return less, regression


def _does_as_well(
    last: Fit, less: Fit, regression: Regression, mode: str, start: Fit, library: Registry, first: Regression
) -> bool:
    """Whether the model without a mode does, or with an effect in its place, taken to its end: a mode that mimics
    leaves a little, which had names of its own. With the true effect there is nothing for these to say."""
    full, rest = prepare(last), values_without(last, mode)
    if superfluous(regression, full, first) and not hurts(last, less):
        return True
    others = [name for name in less.model.names if name not in start.model.names]
    for rival in rivals(mode, regression, library):
        found = confirm(regression, library[rival.name], rival, ENOUGH, rest)
        if not found.possible or behind(found, regression) > 0:
            continue
        instead, names = accept(found, less), list(others)
        try:
            best = prepare(instead)
        except Diverged:  # its motion has no bound
            continue
        while fewer := without_one(instead, names, start):
            if behind(fewer[1], best) > 0:
                break
            instead, best, gone = fewer
            names.remove(gone)
        if behind(best, full) < 0 and not hurts_more(last, instead):
            return True
    return False
