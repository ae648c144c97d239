"""Terms that a greedy walk picked up too early: taken out when later ones make them superfluous, or swapped."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import NamedTuple

from ..effects.effect import AbstractEffect
from ..fit import Fit
from ..fit.rebuild import fit_at
from .change import ENOUGH, try_without
from .confirm import accept, confirm
from .enough import superfluous
from .parts import take_apart
from .score import Bench, Candidate, prepare, score, significant
from .shorten import working

_CLEARLY = 10.0  # of the information criterion: by so much a rival must be better to be swapped in
_PROMISING = (
    0.5  # share of the excess that a rival's score must promise to be asked in: the one in place explains it all
)
_HURT = 1.02  # held-out error may grow by this factor before a term is refused


class Pruned(NamedTuple):
    """The effects that are needed, in order, and the fit with them."""

    names: tuple[str, ...]
    fit: Fit


def hurts(before: Fit, after: Fit) -> bool:
    """Whether held-out records are predicted worse."""
    if before.holdout is None or after.holdout is None:
        return False
    return after.holdout.error_over_noise > _HURT * before.holdout.error_over_noise


def _rivals(name: str, bench: Bench, library: Mapping[str, type[AbstractEffect]]) -> list[Candidate]:
    """Who may stand in an effect's place: whoever scores better, and the best of those that it is mistaken for."""
    candidates = [c for c in significant(score(bench, library)) if c.predicted_gain > _PROMISING]
    better = [c for c in candidates[:1] if c.name != name]
    alike = [c for c in candidates if c.name in library[name].mistaken_for and c.name not in {b.name for b in better}]
    return [*better, *alike[:1]]


def prune(
    last: Fit,
    added: list[str],
    library: Mapping[str, type[AbstractEffect]],
    first: Bench,
    report: Callable[[str], None],
) -> Pruned | None:
    """What is left of the added effects once each has been questioned; None if all are needed.

    The last one was weighed against its rivals when it was added, and is asked again only if something changed.

    `first`: the bench before any was added.
    """
    names, changed_once, changed = list(added), False, True
    given, last = last, working(last)
    while changed and len(names) > 1:
        changed, full = False, prepare(last)
        for i, name in enumerate(names if changed_once else names[:-1]):
            report(f"does the model still need {name}?")
            without = try_without(last, name)
            bench = prepare(without)
            if superfluous(bench, full, first):
                names, last, changed = [*names[:i], *names[i + 1 :]], without, True
                break
            if not full.credible:
                continue  # every effect has been refitted where this one was chosen
            tried = [confirm(bench, library[rival.name], rival, ENOUGH) for rival in _rivals(name, bench, library)]
            better = min(tried, key=lambda found: found.criterion, default=None)
            if better is not None and better.criterion < full.criterion - _CLEARLY:
                after = accept(better, without)
                if not hurts(last, after):
                    names, last, changed = [*names[:i], better.candidate.name, *names[i + 1 :]], after, True
                    break
        changed_once = changed_once or changed
    if parts := take_apart(last, names, library, report):
        at = names.index(parts.whole)
        names, last, changed_once = [*names[:at], *parts.names, *names[at + 1 :]], parts.fit, True
    if not changed_once:
        return None
    if last.campaign is given.campaign:
        return Pruned(tuple(names), last)
    # Swaps were judged on excerpts, which hold nothing out.
    on_all = fit_at(last.model, given.campaign, last.values)
    return None if hurts(given, on_all) else Pruned(tuple(names), on_all)
