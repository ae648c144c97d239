"""Adding two effects at once, where neither explains alone what both do together (see `pairs`)."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from ..effects.effect import AbstractEffect
from ..fit import Fit
from .bench import Bench, prepare
from .confirm import accept, confirm
from .enough import adequate, not_worth_adding, worth_a_name
from .evidence import VERY_STRONG, Left, behind
from .pairs import best_pair
from .prune import hurts
from .score import Candidate, score
from .shorten import working
from .steps import Step
from .trajectory import Diverged


def hidden_by_each_other(
    bench: Bench, candidates: Sequence[Candidate], single: tuple[str, Bench] | None, first: Bench
) -> tuple[str, str] | None:
    """Names of two effects that by their scores explain clearly more than the best single one, and than any two of
    which that is one: those the next step finds.

    `single`: its name and the bench with it, if there is one; `first`: the bench before any effect was added.
    """
    pair = best_pair(bench, candidates) if bench.credible else None
    if pair is None:
        return None
    drop = (bench.chi2 - float(pair.left @ pair.left)) / max(bench.chi2 - bench.n, 1e-9) * bench.to_explain
    if not_worth_adding(bench, drop, first) or not worth_a_name(drop, first):
        return None
    if single is not None:
        name, left = single
        with_it = best_pair(bench, candidates, name)
        if adequate(left) or with_it is None or behind(pair, with_it) > -VERY_STRONG:
            return None
    return pair.names if behind(pair, _instead(bench, single and single[1])) < -VERY_STRONG else None


def both(
    current: Fit, bench: Bench, names: Sequence[str], library: Mapping[str, type[AbstractEffect]], single: Bench | None
) -> tuple[list[Step], Bench] | None:
    """Steps that add the named effects whatever the first of them gains alone, and the bench after them; None if their
    refits are not clearly better than the `single` one, or than the model as it is, or worse than either on held-out
    records."""
    steps, before, now = [], current, bench
    try:
        for name, partner in zip(names, reversed(names), strict=True):
            candidate = score(now, {name: library[name]})[0]
            found = confirm(now, library[name], candidate)
            if not np.isfinite(found.chi2) or (name == names[-1] and not found.possible):
                return None
            before = accept(found, before)
            # What either is mistaken for shows only once both are in: the walk asks it at its end.
            alike = (name, partner)
            steps.append(
                Step(name, candidate.predicted_gain, found.gain, alike, "effect", before, bench=now, partner=partner)
            )
            now = prepare(working(before))
    except Diverged:
        return None
    better = behind(Left(now.residual, now.numbers), _instead(bench, single)) < -VERY_STRONG
    rivals = (current,) if single is None else (current, single.fit)
    return (steps, now) if better and not any(hurts(rival, before) for rival in rivals) else None


def _instead(bench: Bench, single: Bench | None) -> Left:
    there = single or bench
    return Left(there.residual, there.numbers)
