"""What the missing effect could be mistaken for: the names between which these records do not choose."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import NamedTuple

import numpy as np
from scipy.special import chdtrc  # not `scipy.stats`, whose import takes half a second

from ...campaign.device import Platform
from ...effects.effect import AbstractEffect
from ...effects.registry import Registry
from ...fit.assemble import bounds_of
from ...fit.finish import at_bound
from ...fit.linear.independent import independent_samples
from ..evidence.criterion import VERY_STRONG
from ..evidence.enough import ANOTHER_LAW, at_floor
from ..evidence.equivalences import equivalence, exact_partners, what_separates
from ..evidence.family import is_that_member
from ..evidence.held_out import behind_held_out
from ..linearised.regression import Regression
from ..ranking.confirm import Confirmed, confirm, leaves_noise
from ..ranking.look import possible
from ..ranking.score import lacks_a_smooth_drive
from ..ranking.weigh import Candidate
from ..side_by_side import at_once

_TIED = 0.99  # share of a signature that another effect reproduces, above which a refit has to decide
_KNOWN = 0.95  # the same for effects that are known to pass for one another
_EXACT = 0.9  # the same for effects that no record of a linear device tells apart
_AS_MUCH = 0.9  # of what the best one explains: an effect that explains less is no rival, however few samples there are
_ABSORBED = "the model's own parameters absorb all that it adds to these records"
_HELD = "where a drive jumps, what it does is how steep the edge is drawn; a drive without jumps shows it"
_SETTLED = "curves of settled motion show only the mean that it comes to"
_REFITTED = 12  # of the names that tie by their scores; a record that says little leaves more than that
_CHANCE = 0.05  # probability, below which the further numbers of a law that contains another say something


class Tie(NamedTuple):
    """An effect that explains the misfit as well.

    **Arguments:** `behind`: by how much its information criterion is worse than the best one's; `why`, `separate`: in
    words.
    """

    name: str
    behind: float
    why: str
    separate: str


class TieSet(NamedTuple):
    """The best effect and those that these records do not tell from it, nearest first."""

    best: str
    ties: tuple[Tie, ...]

    @property
    def names(self) -> tuple[str, ...]:
        return (self.best, *(tie.name for tie in self.ties))

    @property
    def reasons(self) -> tuple[str, ...]:
        """One sentence per tie."""
        return tuple(f"{self.best} or {t.name}: {t.why}; to tell them apart: {t.separate}" for t in self.ties)


def tie_set(
    regression: Regression,
    best: Candidate,
    candidates: Iterable[Candidate],
    library: Registry,
    confirmed: Iterable[Confirmed] = (),
) -> TieSet:
    """The effects between which the records do not choose.

    With χ² left after each, n effective samples and d parameters, effect j stays beside the best b while

        n ln(χ²_j/χ²_b) + d_j − d_b < 10,

    as long as it explains nearly as much, so that a misfit of the laws themselves widens the set. A parameter counts
    what chance gives it, 1, and not the ln n that selects a model: an effect that explains the data with one number
    more is still an explanation. Only a law that contains the best one as a part pays, where there are traces, the full
    price for its other parts, unless it predicts the held-out records so much better, and is that one itself where they
    take no more than chance; a family is its member also where it takes less than puts a name in doubt, if the member
    leaves nothing to be seen. n counts the independent samples in what the best one leaves. Refits replace predictions
    where there are any; where there are none, an effect whose signature is nearly the same, or is known to pass for the
    other, stays in. Where noise is small against the misfit, laws of one kind differ by more than noise: a refit within
    that stays in, unless it needs several numbers more to come as close. Where a shape of the best one ended at its
    limits, which is where one effect turns into another, what it is mistaken for stays in.

    **Arguments:** `candidates`: as scored on the same regression; `confirmed`: refits of some of them.
    """
    refits = {c.candidate.name: c for c in confirmed}
    n = independent_of(regression, best)
    on_edge = best.name in refits and _on_edge(refits[best.name], regression)
    found = []
    for other in candidates:
        if other.name == best.name:
            continue
        both = best.name in refits and other.name in refits
        chosen = refits if both else {}
        least, left = left_after(regression, best, chosen), left_after(regression, other, chosen)
        # Its further parts would show in traces; on curves without harmonics they are not seen, and say nothing.
        wider = best.name in library[other.name].contains and regression.fit.campaign.shows_shape
        price = float(np.log(regression.n)) if wider else 1.0
        behind = n * float(np.log(left / least)) + price * (other.dof - best.dof)
        if wider and both and behind >= VERY_STRONG:  # what its other parts say, held-out records may tell
            behind += behind_held_out(regression.fit.campaign, refits[best.name], refits[other.name])
        as_much = left - least < max(VERY_STRONG, (1.0 - _AS_MUCH) * (regression.excess + regression.n - least))
        alike = reproduced(regression, best, other)
        enough = _KNOWN if equivalence(library[best.name], library[other.name]) else _TIED
        shape = ANOTHER_LAW * regression.excess
        as_simple = both and refits[other.name].model.numbers <= refits[best.name].model.numbers + 1
        # Of two laws the one that leaves nothing to be seen is not as far from the device's as one that leaves more
        # than it by what would be seen above noise.
        told_apart = at_floor(least, regression) and not at_floor(regression.n + left - least, regression)
        near = as_simple and not wider and left - least < shape and not told_apart
        unseen_yet = (
            not both and regression.credible and not wider and alike > enough and _may_catch_up(library[other.name])
        )
        if both and _is_itself(refits[best.name], refits[other.name], n if wider else None, regression):
            continue
        turns_into = on_edge and other.name in library[best.name].mistaken_for and not told_apart
        if ((behind < VERY_STRONG or turns_into) and as_much) or near or unseen_yet:
            found.append(_tie(best, other, behind, alike, library, turns_into))
    named = {tie.name for tie in found}
    in_motion = all(record.start != "rest" for record in regression.fit.campaign.fitted)
    exact = exact_partners(library[best.name], library, _is_linear(regression), in_motion)
    for other in candidates:
        # Where both were refitted, transients may have told them apart: a force rings where a reading does not.
        judged = best.name in refits and other.name in refits
        similar = in_motion or (not judged and reproduced(regression, best, other) > _EXACT)
        if other.name in exact and other.name not in named and similar:
            found.append(_tie(best, other, float("nan"), 1.0, library))
    return TieSet(best.name, tuple(sorted(found, key=lambda t: (not np.isnan(t.behind), t.behind))))


def _is_itself(part: Confirmed, whole: Confirmed, n: float | None, regression: Regression) -> bool:
    """Whether a law has become one that it contains: what its further numbers take is no more than chance, so many `n`
    independent samples given, or no more than members of a family differ by and nothing that anybody would miss."""
    laws = type(whole.model.effects[-1]), part.model.effects[-1]
    if is_that_member(*laws, whole.chi2, part.chi2, regression.excess) and at_floor(part.chi2, regression):
        return True
    more = whole.model.numbers - part.model.numbers
    return n is not None and bool(chdtrc(more, max(n * np.log(part.chi2 / whole.chi2), 0.0)) > _CHANCE)


def _on_edge(found: Confirmed, regression: Regression) -> bool:
    """Whether a shape of the last effect ended at the edge of its range. (Those that may be negative go beyond.)"""
    model, scales = found.model, regression.fit.scales
    own = [i for i, p in enumerate(model.parameters) if p.limits and p.name.startswith(f"{model.effects[-1].name}.")]
    ends = [(float(found.values[i]), *bounds_of(model.parameters[i], float(found.values[i]), scales)) for i in own]
    return any(at_bound(*end, error=0.0) for end in ends)


def left_after(regression: Regression, candidate: Candidate, refits: Mapping[str, Confirmed]) -> float:
    """χ² left with the candidate: of its refit if there is one, else as predicted; where scores cannot be believed, by
    a short refit, which is compared with the fit as it was."""
    before = regression.chi2 if regression.credible else regression.best_chi2
    chi2 = refits[candidate.name].chi2 if candidate.name in refits else before - candidate.drop
    return max(chi2, 1e-6 * regression.n)


def independent_of(regression: Regression, best: Candidate) -> float:
    """Effective number of independent samples in what the best candidate leaves."""
    return independent_samples(regression.residual - (best.signature @ regression.residual) @ best.signature)


def reproduced(regression: Regression, best: Candidate, other: Candidate) -> float:
    """Share of what the best candidate takes from the residual that the other's columns reproduce, 0 to 1."""
    taken = (best.signature @ regression.residual) @ best.signature
    power = float(taken @ taken)
    return float(np.sum((other.signature @ taken) ** 2) / power) if power > 0 else 0.0


def _may_catch_up(effect: type[AbstractEffect]) -> bool:
    """Whether a refit can move a shape off the grid on which the effect was scored."""
    return any(p.kind == "shape" and p.fitted for p in effect.parameters)


def _is_linear(regression: Regression) -> bool:
    return not regression.fit.model.effects


def _tie(
    best: Candidate, other: Candidate, behind: float, alike: float, library: Registry, turns_into: bool = False
) -> Tie:
    one, another = library[best.name], library[other.name]
    known = equivalence(one, another)
    if known is not None:
        why = known.why
    elif behind >= VERY_STRONG and turns_into:
        why = f"{best.name} ended at the edge of its range, where it turns into another effect"
    elif behind >= VERY_STRONG:
        why = f"it explains within {100 * ANOTHER_LAW:.2g} % as much, and laws of one kind differ by that"
    elif alike > _KNOWN:
        why = f"on these records it reproduces {100 * alike:.3g} % of the same trace"
    else:
        why = "it explains the misfit as well within the noise"
    return Tie(other.name, behind, why, what_separates(one, another))


class Unseen(NamedTuple):
    """An effect of which these records say nothing, and why; `settled`: because they are curves that have settled."""

    name: str
    why: str
    settled: bool = False


def unseen(regression: Regression, candidates: Sequence[Candidate], library: Registry) -> tuple[Unseen, ...]:
    """Effects that cannot be seen in these records: whatever they do, the model's own parameters absorb it."""
    model = regression.fit.model
    scored = {c.name for c in candidates} | set(model.names)
    found = []
    for effect in library.values():
        absent = effect.platform_only and not isinstance(model.device, Platform)
        other = effect.form_of or (effect.needs and effect.needs not in model.names)
        if effect.name in scored or absent or other:
            continue
        settled = effect.settles_to_a_mean and regression.fit.campaign.shows_settled_motion_only
        held = lacks_a_smooth_drive(regression.fit.campaign, effect)
        found.append(Unseen(effect.name, _SETTLED if settled else _HELD if held else _ABSORBED, settled))
    return tuple(found)


def weighed_ties(
    regression: Regression, found: Confirmed, real: list[Candidate], library: Registry, tried: list[Confirmed]
) -> tuple[TieSet, tuple[Candidate, ...]]:
    """What an effect ties with, the nearest of those that had only been scored refitted; and the candidates that do."""
    rivals = possible(real, tried)
    ties = tie_set(regression, found.candidate, rivals, library, tried)
    known = {one.candidate.name for one in tried}
    scored = [tie.name for tie in ties.ties if tie.name not in known][:_REFITTED]
    if scored:
        finer = not leaves_noise(found, regression)
        refit = lambda one: confirm(regression, library[one.name], one, refining=finer)
        more = at_once(refit, [c for c in rivals if c.name in scored])
        tried = [*tried, *more]
        rivals = possible(real, tried)
        ties = tie_set(regression, found.candidate, rivals, library, tried)
    return ties, tuple(c for c in real if c.name in ties.names)
