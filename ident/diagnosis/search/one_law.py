"""One law that says everything, or nearly, kept before a walk whose names could only mimic it.

Where no effect reaches the noise, nor two promise to, but one function of a single coordinate does, or one term or
product of two, or terms that all need both, the library may still have that function in pieces: a cubic and a quintic
spring are one function of z. If all its effects of these coordinates together do not say it, no names will, however
many a walk puts side by side.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np

from ...campaign.campaign import Campaign
from ...effects.dependence import depends_on
from ...fit import Fit
from ...fit.floors import sharpened
from ...pulse import Report
from ..evidence.enough import FAR, MOST_OF_IT, adequate, speaks_for
from ..evidence.held_out import contradicted, hurts
from ..linearised.basis import orthonormal
from ..linearised.regression import Regression, prepare
from ..linearised.shorten import working
from ..linearised.trajectory import Diverged
from ..ranking.look import Look
from ..unknown.find import Unknown, as_table, better_than, without_memory
from ..unknown.formula import Formula
from ..unknown.subsets import NEAR, rank
from .beyond import Beyond
from .drive import other_drive
from .steps import Discovery
from .together import two_names_do
from .written import (
    AS_WELL,
    Written,
    as_good_as_named,
    ended,
    kept_if_it_ends,
    lacked_by,
    little_of,
    nearly_explained,
    outdoes,
    simulated,
    step_of,
)


def one_law(look: Look, fitted: Fit, start: Regression, path: Path, report: Report) -> Written | Campaign | None:
    """The answer with the law written, if there is one and its simulation reaches the noise, or leaves little of the
    misfit, and of what names leave, and no more than a wrong noise floor would; or the campaign with the noise floors
    that it tells better. `fitted`: with which a walk would begin; `start`: of its `working` excerpt;
    `path`: where no file is yet.
    """
    regression = look.regression
    if not fitted.campaign.fitted or fitted.campaign.fitted_sweeps or not look.worth_it:
        return None
    named = _left_by_names(look)
    if as_good_as_named(named, regression) or not _may_be_one(start, named):
        return None
    found = _said(start, named, report)
    if found is None:
        return None
    unknown, formula = found
    # What a formula of kinks leaves along a motion with noise, names of the same law leave too.
    as_much = AS_WELL * max(formula.chi2_per_sample, 1.0) * start.n
    if said_in_pieces(look, unknown, as_much) or two_names_do(look, start, as_much):
        return None
    if other_drive(start.fit, regression, report, look) is not None:
        return None
    enough = lambda fit, left: (
        left.chi2 < FAR * left.n
        and little_of(left.chi2 / left.n, start.chi2 / start.n)
        and says_more(left.chi2 / left.n, named, start)
        and speaks_for(left, fit)
        and not contradicted(fit)
    )
    told = _holds(fitted, fitted, start, unknown, path, report, enough)
    if told is None:
        return None
    left = prepare(working(told[0].fit))
    only_noise = adequate(left) and speaks_for(left, told[0].fit)
    sharper = sharpened(told[0].fit) if only_noise else None
    if sharper is not None:
        told[0].path.unlink()
        return replace(sharper, effect_files=fitted.campaign.effect_files)
    gains = {one.candidate.name: one.gain for one in look.tried}
    nothing = Discovery("not-in-library", fitted, (), tuple(look.candidates), gains, (), regression)
    return _written(nothing, *told)


def in_their_place(found: Discovery, start: Regression, path: Path, report: Report) -> Written | None:
    """The answer with the law in the place of a walk's names, where these do not reach the noise: before it they, or
    pieces of the law, had promised to. The law must not predict held-out records worse than they do.

    `start`: of the `working` excerpt of the fit with which the walk began.
    """
    asked = found.verdict == "not-in-library" and found.steps and not adequate(found.regression)
    if not asked or found.start.campaign.fitted_sweeps:
        return None
    said = _said(start, found.regression.chi2, report)
    enough = lambda fit, _: not nearly_explained(found) and outdoes(found.final, fit)
    told = None if said is None else _holds(found.start, found.final, start, said[0], path, report, enough)
    return None if told is None else _written(found, *told)


def _said(start: Regression, named: float, report: Report) -> tuple[Unknown, Formula] | None:
    """What a fit lacks, where that is one law whose formula says all of it, and more than names do, χ² `named`; of sets
    of coordinates that explain almost as much the one that the criterion prefers, if the simplest is no such law, or
    the best that needs no memory."""
    unknown = lacked_by(start, report)
    law = _one_of(unknown) or _one_better(start, unknown)
    if law is None and "history" in unknown.coordinates:
        law = _one_of(without_memory(start))
    if law is None or law.formula is None:
        return None
    return (law, law.formula) if says_more(law.formula.chi2_per_sample, named, start) else None


def _written(found: Discovery, beyond: Beyond, gain: float) -> Written:
    """A law in the place of what was found."""
    return Written(replace(found, steps=(step_of(beyond, gain),)), beyond.unknown, beyond.path)


def _holds(
    fitted: Fit,
    rival: Fit,
    start: Regression,
    unknown: Unknown,
    path: Path,
    report: Report,
    enough: Callable[[Fit, Regression], bool],
) -> tuple[Beyond, float] | None:
    """The fit with a law beside `fitted`, taken to its end, whose simulation reaches the noise, and which held-out
    records do not refute, nor find worse than the `rival`; of a product they may refute how its formula runs on beyond
    the fitted ones, and not its table. Where the simulation leaves more, a law that says more is asked; if there is
    none, it may still be `enough`, by its fit and what that leaves."""
    law: Unknown | None = unknown
    while law is not None:
        try:
            with kept_if_it_ends(path):
                beyond, gain = simulated(fitted, start, law, path, report)
                left = prepare(working(beyond.fit))
                fine = adequate(left) and speaks_for(left, beyond.fit)
                after = None if fine else _one_better(start, law)
                holds = not contradicted(beyond.fit) if fine else after is None and enough(beyond.fit, left)
                if holds and not hurts(rival, beyond.fit):
                    last = ended(beyond.fit)
                    if last is beyond.fit or not hurts(rival, last):
                        return beyond._replace(fit=last), gain
        except Diverged:  # with it the motion has no bound
            return None
        beyond.path.unlink()
        law = as_table(start, law) if fine else after
    return None


def _one_better(start: Regression, refuted: Unknown) -> Unknown | None:
    """The law that says more along the measured motion than one whose simulation left more than noise, or than what is
    no law, if it is one."""
    return _one_of(better_than(start, refuted))


def _one_of(law: Unknown | None) -> Unknown | None:
    """What is missing, if it is one law whose formula says all of it."""
    one = law is not None and law.formula is not None and law.formula.complete and law.of_one_law
    return law if one else None


def _may_be_one(start: Regression, named: float) -> bool:
    """Whether splines of one or two coordinates say nearly everything, or more than names do; a formula that has its
    kinks may say the rest."""
    few = [found for found in rank(start.of_traces())[1] if "history" not in found.coordinates]
    return any(found.share > 1.0 - NEAR or says_more(found.chi2_per_sample, named, start) for found in few)


def says_more(left: float, named: float, start: Regression) -> bool:
    """Whether a law that leaves so much χ² per sample says everything, or most of what the names leave, χ² `named`:
    along a motion that was measured a kink leaves what noise does to it, and only its simulation tells how much."""
    return left < AS_WELL or (left - 1.0) * start.n < MOST_OF_IT * (named - start.n)


def _left_by_names(look: Look) -> float:
    """The least χ² that an effect leaves, refitted, or two promise to leave."""
    promised = np.inf if look.pair is None else float(look.pair.left @ look.pair.left)
    return min([promised, *(one.chi2 for one in look.tried if one.possible)])


def said_in_pieces(look: Look, unknown: Unknown, as_much: float) -> bool:
    """Whether effects that depend on nothing else than a law, and act where it does, explain `as_much` together: the
    best one and the best beside it, or more of them with no more numbers than its formula has. A dozen mimic any
    function, and a table has as many numbers as they need."""
    regression, own = look.regression, set(unknown.coordinates)
    pieces = []
    for candidate in look.candidates:
        law = depends_on(look.library[candidate.name]())
        if law is not None and law[0] == unknown.side and set(law[1]) <= own:
            rows = np.concatenate([candidate.signature, *candidate.near_signatures])
            pieces.append((candidate.dof, rows, rows))
    left, spent, formula = regression.residual, 0, unknown.formula
    most = 0 if formula is None or formula.tabled else formula.numbers
    for count in range(len(pieces)):
        spans = [orthonormal(rows, whole) for _, rows, whole in pieces]
        best = int(np.argmax([float(np.sum((span.T @ left) ** 2)) for span in spans]))
        basis = spans[best]
        spent += pieces.pop(best)[0]
        if count >= 2 and spent > most:
            return False
        left = left - basis @ (basis.T @ left)
        pieces = [(dof, rows - (rows @ basis) @ basis.T, whole) for dof, rows, whole in pieces]
        said = float(left @ left)
        if said < as_much or as_good_as_named(said, regression):
            return True
    return False
