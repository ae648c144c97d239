"""Records that differ in a number each: told before a walk from what one effect beside those numbers promises, or after
it beside what was named.

Under numbers of the records' own no score sees an effect, and the effect bends the numbers. Their columns are taken
along the measured motion and out of what the fit leaves; every effect is then scored beside them. Asked only of
records that are not long: read so they may count as such, and are still taken whole.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..campaign.record import Kind
from ..fit import Fit, fit
from ..pulse import Report
from .evidence.criterion import VERY_STRONG, Left, behind, criteria
from .evidence.enough import MOST_OF_IT, adequate
from .evidence.held_out import contradicted
from .linearised.regression import Regression, prepare
from .linearised.shorten import is_long
from .linearised.trajectory import Diverged
from .ranking.confirm import accept, confirm
from .ranking.look import Look
from .ranking.score import score, score_beside, significant
from .records.between import comparable, differing, kinds_of, rows_of
from .records.differing import Differing, numbers_of
from .search.change import add, without
from .search.drive import edges_of, other_drive, with_edges
from .search.own_zeros import histories
from .search.written import AS_WELL, little_of

_DRIVES = 3  # tried one after the other, each sought beside a model that had bent to the one before


class _Promise(NamedTuple):
    """What a kind of number for each record and one effect, if one helps, leave by their scores, (n,)."""

    kind: Kind
    effect: str | None
    left: np.ndarray
    numbers: float


class Apart(NamedTuple):
    """Records that differ, and the fit from which a walk begins once they are read so."""

    start: Fit
    found: Differing


def apart_before(look: Look, report: Report) -> Apart | None:
    """Records that differ, and reach the noise floor beside at most one effect, where no two effects promise that: the
    walk that would look for more of them is spared."""
    regression = look.regression
    campaign = regression.fit.campaign
    if any(record.differs for record in campaign.records) or any(record.excerpt for record in campaign.traces):
        return None  # what differs between excerpts may be what changes within a record
    if not comparable(regression.fit) or not look.worth_it:
        return None
    tried = [found for found in look.tried if found.possible]
    settles = [found.candidate.name for found in tried if found.chi2 < AS_WELL * regression.n]
    if any(histories(name, look) == 0 for name in settles):
        return None
    plain = _of_one_mode(look)
    promise = _best(plain, report)
    alone = [Left(found.left, found.numbers + histories(found.candidate.name, look)) for found in tried]
    if plain is look and any(behind(promise, one) > VERY_STRONG for one in alone):
        return None  # one effect has kept more than they promise beside one
    pair = look.pair
    if pair is not None:
        pair = pair._replace(numbers=pair.numbers + sum(histories(name, look) for name in pair.names))
    says_all = pair is not None and float(pair.left @ pair.left) < AS_WELL * regression.n
    if behind(promise, pair or regression) > (-VERY_STRONG if says_all or pair is None else VERY_STRONG):
        return None
    found = _simulated(plain, promise)
    if found is None or not adequate(prepare(found.fit)) or contradicted(found.fit) or _told_by_another(found, plain):
        return None
    if found.kind == "delay" and _told_by_drive(found, plain):
        return None
    return Apart(plain.regression.fit, found)


def apart_after(look: Look, final: Fit, report: Report) -> Apart | None:
    """Records that differ beside what a walk has named; or beside what promises most, if that was wrong.

    Each starts another walk, believed if it reaches the noise: the first has to take away most of what the walk
    has left; the second to leave less, and little of what was missing first.
    """
    campaign = final.campaign
    if is_long(campaign) or any(record.differs for record in campaign.records):
        return None
    report("does the device differ from record to record?")
    start = look.regression.fit
    found = differing(final)
    if found is None or not adequate(prepare(found.fit)):
        if comparable(final):
            look = _of_one_mode(look)
            other = _simulated(look, _best(look, report))
        else:
            other = differing(start)
        if other is not None and _excess(other.fit) < _excess(final) and _nearly_all(other.fit, look.first):
            return Apart(look.regression.fit, other)
    takes = found is not None and _excess(found.fit) < MOST_OF_IT * _excess(final)
    return Apart(start, found) if found is not None and takes else None


def _excess(fit: Fit) -> float:
    regression = prepare(fit)
    return regression.chi2 - regression.n


def _nearly_all(found: Fit, first: Regression) -> bool:
    """Whether a fit explains all, or nearly all, that was missing first."""
    left = prepare(found)
    return adequate(left) or little_of(left.chi2 / left.n, first.chi2 / first.n)


def _told_by_drive(found: Differing, look: Look) -> bool:
    """Whether other drives between the samples say enough, or about as much as delays of the records' own.

    Where some drives jump and others are smooth, they differ by half a sample if all are taken for held.
    """
    campaign = look.regression.fit.campaign
    numbers = found.fit.freedom + found.numbers + edges_of(campaign).numbers
    delays = Left(prepare(found.fit).left, numbers)
    try:
        one = fit(found.fit.model, campaign, initial=found.fit.values)
        for _ in range(_DRIVES):
            other = other_drive(one, prepare(one), lambda _: None)
            if other is None:
                break
            one = fit(one.model, with_edges(one.campaign, other), initial=one.values)
        there = prepare(one)
    except (Diverged, np.linalg.LinAlgError):  # a motion without bound tells nothing
        return False
    told = Left(there.left, one.freedom + edges_of(one.campaign).numbers)
    return adequate(there) or behind(delays, told) > -VERY_STRONG


def _told_by_another(found: Differing, look: Look) -> bool:
    """Whether one effect more, the same in all records, says about as much as the numbers of their own: far from the
    device's motion the scores of two did not see it, and the numbers may have mimicked the second."""
    numbers = Left(prepare(found.fit).left, found.fit.freedom + found.numbers)
    try:
        one = fit(found.fit.model, look.regression.fit.campaign, initial=found.fit.values)
        for name in set(look.regression.fit.model.names) - set(one.model.names):  # the common zero
            one = add(one, name, others=0)
        tried = Look(prepare(one), look.first, look.library, look.report, answered=True).tried
    except Diverged:
        return False
    told = [Left(one.left, one.numbers + histories(one.candidate.name, look)) for one in tried if one.possible]
    return any(behind(numbers, one) > -VERY_STRONG for one in told)


def _of_one_mode(look: Look) -> Look:
    """The look at the model without the further modes that the records have asked for: where records differ, modes
    follow one after the other."""
    fitted = look.regression.fit
    named = fitted.campaign.effects
    further = [e.name for e in fitted.model.effects if e.further_mode and e.name not in named]
    if not further or fitted.campaign.modes is not None:
        return look
    try:
        return Look(prepare(without(fitted, further)), look.first, look.library, look.report)
    except Diverged:  # without them its motion has no bound
        return look


def _best(look: Look, report: Report) -> _Promise:
    """The kind of number that leaves least with the effect that it goes with."""
    report("does one effect explain more where records differ in a number each?")
    regression = look.regression
    promises, kinds = [], kinds_of(regression.fit.campaign)
    besides = [regression.beside(rows_of(regression, kind)) for kind in kinds]
    for kind, beside, scored in zip(kinds, besides, score_beside(besides, look.library), strict=True):
        best = next(iter(significant(scored)), None)
        left, numbers = beside.residual, regression.numbers + numbers_of(regression.fit, kind)
        if best is not None:
            left, numbers = left - best.signature.T @ (best.signature @ left), numbers + best.dof
        promises.append(_Promise(kind, best and best.name, left, numbers))
    return promises[int(np.argmin(criteria(promises)))]


def _simulated(look: Look, promise: _Promise) -> Differing | None:
    """The records read so beside the effect that goes with it; or beside the one that is seen from there without any,
    if that leaves less: far from the device's own motion scores say little."""
    found = _beside(look, promise, promise.effect)
    if found is not None and adequate(prepare(found.fit)):
        return found
    alone = _beside(look, promise, None)
    if alone is None:
        return found
    there = prepare(alone.fit)
    (scored,) = score_beside([there.beside(rows_of(there, promise.kind))], look.library)
    best = next(iter(significant(scored)), None)
    if best is None or best.name == promise.effect:
        return found
    other = _beside(look, promise, best.name)
    tried = [one for one in (found, other) if one is not None]
    return min(tried, key=lambda one: one.fit.fitted.error_over_noise, default=None)


def _beside(look: Look, promise: _Promise, effect: str | None) -> Differing | None:
    try:
        return differing(look.regression.fit if effect is None else _with(look, effect), (promise.kind,))
    except (Diverged, np.linalg.LinAlgError):  # a motion without bound tells nothing
        return None


def _with(look: Look, effect: str) -> Fit:
    """The fit with an effect more, as it is weighed in a walk: where numbers of the records' own are missing a search
    to its end crawls for long, and goes on from there once they are in."""
    regression, law = look.regression, look.library[effect]
    scored = next(iter(score(regression, {effect: law})), None)
    return regression.fit if scored is None else accept(confirm(regression, law, scored), regression.fit)
