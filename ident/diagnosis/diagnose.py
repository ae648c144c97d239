"""The four questions after a fit: is it adequate, where does it fail, which effect is missing, what to measure next."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import partial
from html import escape
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ..campaign.quality.suspect import Suspect
from ..effects.effect import AbstractEffect
from ..effects.registry import registry
from ..fit import Fit, fit, fit_data
from ..fit.fit_data import Effects
from ..fit.floors import sharpened
from ..fit.start_score import mostly_starts
from ..pulse import Report
from ..threads import one_thread
from .evidence.criterion import VERY_STRONG, behind
from .evidence.enough import adequate, superfluous, worth_a_name
from .faulty.between import differing
from .faulty.suspects import BY_OTHERS, find_suspects, judged_again
from .linearised.regression import Regression, prepare
from .linearised.shorten import is_long, working
from .linearised.trajectory import Diverged
from .next_record.experiments import NextExperiment, next_experiments, rank_experiments
from .ranking.look import BROKEN, first_look
from .search.beyond import alone, free_name, go_beyond
from .search.discover import Keep, continue_from
from .search.prune import confirmed, hurts
from .search.steps import Discovery, Step, Verdict, Walked
from .search.ties import Unseen, unseen
from .unknown.effect_file import write_effect
from .unknown.find import Unknown, find_unknown, followed_noise
from .where.locate import Where, locate
from .where.words import summary

if TYPE_CHECKING:
    from pandas import DataFrame

_EXPERIMENTS = 3
_NEARLY = 0.05  # of the first misfit: if named effects leave less, they are kept and the rest is looked for
_AS_WELL = 1.1  # of χ² per sample: what is left counts as no more, a twentieth of an error bar


@dataclass(frozen=True, eq=False)
class Diagnosis:
    """Answers about a fit.

    **Arguments:** `where`: where the fit fails; `unknown`: what the library lacks, if it lacks something, and
    `effect_file`, where that was written; `next_experiments`: records that would separate what ties; `unseen`: effects
    of which these records cannot say anything; `suspects`: records that something is wrong with. If a faulty record
    explains more than any effect does, the walk has no steps.
    """

    discovery: Discovery
    where: Where
    unknown: Unknown | None = None
    effect_file: Path | None = None
    next_experiments: tuple[NextExperiment, ...] = ()
    unseen: tuple[Unseen, ...] = ()
    suspects: tuple[Suspect, ...] = ()

    @property
    def summary(self) -> str:
        """Where the fit that was diagnosed fails, in one paragraph."""
        return summary(self.where)

    @property
    def verdict(self) -> Verdict:
        """Whether something is missing, and how sure its name is."""
        return self.discovery.verdict

    @property
    def final(self) -> Fit:
        """The fit with everything that was found."""
        return self.discovery.final

    def to_dataframe(self) -> DataFrame:
        """The candidates, best first: share of the error beyond noise that each removes, as scored and as refitted."""
        from pandas import DataFrame

        ranking, confirmed = self.discovery.ranking, self.discovery.confirmed
        rows = [(c.predicted_gain, confirmed.get(c.name), c.p_value) for c in ranking]
        return DataFrame(rows, columns=["predicted", "confirmed", "by chance"], index=[c.name for c in ranking])

    def __repr__(self) -> str:
        added = " + ".join(step.added for step in self.discovery.steps) or "nothing added"
        before, after = (f.fitted.error_over_noise for f in (self.discovery.start, self.final))
        suspect = f"; suspect: {', '.join(s.file for s in self.suspects)}" if self.suspects else ""
        return f"<Diagnosis: {self.verdict}; {added}; error over noise {before:#.3g} → {after:#.3g}{suspect}>"

    def _repr_html_(self) -> str:
        return f"<p>{escape(repr(self))}</p><p>{escape(self.summary)}</p>{self.to_dataframe().to_html()}"


@one_thread
def discover(
    data: Any, effects: Effects = None, *, report: Report = lambda _: None, effect_file: Path | None = None, **told: Any
) -> Diagnosis:
    """Fit, see where the model fails, add what explains it, until the noise floor; `.final` is the last model.

    **Arguments:** `data`, `effects`, `told`: as in `ident.fit`; `effect_file`: as in `diagnose`.
    """
    return diagnose(fit_data(data, effects, report=report, **told), None, report, effect_file, keeps_walk=True)


@one_thread
def diagnose(
    fitted: Fit | Walked,
    library: Mapping[str, type[AbstractEffect]] | None = None,
    report: Report = lambda _: None,
    effect_file: Path | None = None,
    keeps_walk: bool = False,
    keep: Keep = lambda _: None,
) -> Diagnosis:
    """Locate the misfit, walk the loop, and look beyond the library where it does not reach.

    **Arguments:** `fitted`: or a walk that was stopped, which goes on; `library`: the effects to choose from, if not
    all that the campaign knows; `effect_file`: where to write what the library lacks; the model with it then ends the
    walk. `keeps_walk`: whether the caller goes on with the last model of the walk; what it lacks is then written, if
    named effects nearly explain the records, and else what the fit lacks. `keep`: as of `continue_from`.
    """
    walked = fitted if isinstance(fitted, Walked) else Walked(fitted)
    fitted = walked.start
    library = registry(fitted.campaign.effect_files) if library is None else library
    report("locating the misfit")
    regression = prepare(working(fitted))
    where = locate(regression)
    look = first_look(fitted, library, report)
    suspects = find_suspects(fitted, lambda: look, report)
    if any(suspect.first for suspect in suspects):
        nothing = Discovery("ambiguous", fitted, (), (), {}, (), regression)
        return Diagnosis(nothing, where, suspects=suspects)
    found = continue_from(walked, library, report, keep=keep, look=look)
    sharper = sharpened(found.final)
    if sharper is not None:
        report("what the last model leaves tells the noise floors better: once more, with these")
        again = Walked(fit(fitted.model, sharper, initial=fitted.values))
        return diagnose(again, library, report, effect_file, keeps_walk, keep)
    if (
        found.verdict != "adequate"
        and not adequate(found.regression)
        and (apart := _apart(found, regression, library, report, keep)) is not None
    ):
        return apart
    suspects = judged_again(suspects, found.final, report)
    if found.verdict == "identified" and any(one.kind in BY_OTHERS for one in suspects):
        found = replace(found, verdict="ambiguous")
    if found.verdict == "not-in-library" and mostly_starts(found.final):
        found = replace(found, verdict="ambiguous", lacking=0.0)  # what is left may be no physics at all
    answer = partial(Diagnosis, found, where, unseen=unseen(regression, found.ranking, library), suspects=suspects)
    if not fitted.campaign.fitted:
        return answer()  # what a curve lacks beyond the library, and the next record, only traces tell
    if found.verdict != "not-in-library":
        unknown = _instead(regression, report) if found.lacking else None
        return answer(unknown, next_experiments=measure_next(found, library, report))
    if not found.steps and adequate(found.regression):
        return answer()  # the fitted records lack nothing: it is the held-out ones that contradict
    if effect_file is None:
        return answer(_instead(regression, report))
    kept = keeps_walk and _nearly_explained(found)
    base, unknown = _lacked(found, regression, report) if kept else (regression, _instead(regression, report))
    if unknown.written is None:
        return answer(unknown)
    kept = base is found.regression
    last = found.final if kept else fitted
    if kept and is_long(fitted.campaign):  # a refit of many terms to long records takes longer than the walk
        write_effect(unknown, effect_file, free_name(last))
        return answer(unknown, effect_file)
    beyond = go_beyond(last, base, unknown, effect_file, report)
    before, after = (one.fitted.error_over_noise for one in (last, beyond.fit))
    gain = 1 - (after**2 - 1) / max(before**2 - 1, 1e-9)
    helped = any(worth_a_name(kept * regression.excess, regression) for kept in found.confirmed.values())
    if gain < BROKEN * beyond.unknown.share and not found.steps and not helped:
        beyond.path.unlink()  # neither an effect of the library nor this one is there, once it is simulated
        nothing = replace(found, verdict="ambiguous", lacking=0.0)
        return replace(answer(followed_noise(beyond.unknown, gain)), discovery=nothing)
    better = after < found.final.fitted.error_over_noise and (
        kept or not found.steps or (beyond.unknown.told and _says_more(found.final, beyond.fit))
    )
    if better and not hurts(last, beyond.fit):  # what bends to the fitted records alone is written, but not kept
        name = beyond.fit.model.names[-1]
        step = Step(name, beyond.unknown.share, gain, (name,), "effect", beyond.fit)
        found = replace(found, steps=(*found.steps, step) if kept else (step,))
        if kept and (by_itself := _by_itself(found, regression, report)) is not None:
            found = replace(found, steps=(step._replace(fit=by_itself),))
        suspects = judged_again(suspects, found.final, report)  # the law that they had lacked may have made them so
    return replace(answer(beyond.unknown, beyond.path), discovery=found, suspects=suspects)


def _apart(
    found: Discovery,
    regression: Regression,
    library: Mapping[str, type[AbstractEffect]],
    report: Report,
    keep: Keep,
) -> Diagnosis | None:
    """The answer where records that differ in a number each, and the library, explain them to the noise; None where
    they do not, or one law of a single coordinate does, which is the shorter answer.

    The numbers are found beside the effects that a walk has named, or from where it began, if these are wrong; and
    again after the walk that they make possible, for what was missing had bent them.
    """
    start = found.start
    if is_long(start.campaign) or any(record.differs for record in start.campaign.records):
        return None
    report("does the device differ from record to record?")
    one = differing(found.final)
    if one is None or not adequate(prepare(working(one.fit))):
        one = differing(start) or one
    if one is None:
        return None
    if start.campaign.fitted:
        law = find_unknown(regression)
        if law.formula is not None and law.dimension < 2 and law.chi2_after < _AS_WELL:
            return None
    said = diagnose(one.begun(start), library, report, keep=keep)
    again = differing(fit(said.final.model, start.campaign, initial=said.final.values), (one.kind,))
    if again is None:
        return None
    if again.moved(one):
        said = diagnose(again.begun(start), library, report, keep=keep)
    if not adequate(said.discovery.regression):
        return None
    # An effect may be mistaken for what differs, as for what is faulty.
    sure = said.verdict == "identified"
    return replace(said, discovery=replace(said.discovery, verdict="ambiguous")) if sure else said


def _nearly_explained(found: Discovery) -> bool:
    """Whether named effects leave so little that the rest is looked for beside them, and not in their place."""
    before, after = (fit.fitted.error_over_noise**2 - 1 for fit in (found.start, found.final))
    return after < _NEARLY * before


def _by_itself(found: Discovery, first: Regression, report: Report) -> Fit | None:
    """The fit with the last step alone, where the named effects before it do no more beside it."""
    names = [step.added for step in found.steps[:-1]]
    if not names:
        return None
    report(f"does the model still need {' and '.join(names)}?")
    without = alone(found.final, names)
    try:
        fine = superfluous(prepare(working(without)), prepare(working(found.final)), first)
    except Diverged:  # without them the motion has no bound
        return None
    return without if fine else None


def _says_more(named: Fit, written: Fit) -> bool:
    """Whether what was written in the place of named effects is better than they are by the criterion, which counts its
    numbers, and on records held out."""
    try:
        return behind(prepare(working(written)), prepare(working(named))) < -VERY_STRONG and confirmed(named, written)
    except Diverged:  # a motion without bound says nothing
        return False


def _lacked(found: Discovery, start: Regression, report: Report) -> tuple[Regression, Unknown]:
    """Where what the library lacks is looked for: beside the effects that were named; or in their place, where that
    leaves less, for a wrong law may have taken the motion to where it forgets how it began."""
    beside, instead = (_instead(regression, report) for regression in (found.regression, start))
    said = beside.written is not None
    if said and beside.chi2_after < _AS_WELL:
        # One law of fewer coordinates that says everything is a shorter answer than names and another law.
        alone = instead.written is not None and instead.chi2_after < _AS_WELL and instead.dimension < beside.dimension
        return (start, instead) if alone else (found.regression, beside)
    as_well = said and beside.chi2_after < _AS_WELL * instead.chi2_after
    return (found.regression, beside) if as_well else (start, instead)


def _instead(regression: Regression, report: Report) -> Unknown:
    report("estimating what the library lacks, as a function of its coordinates")
    return find_unknown(regression)


def measure_next(
    found: Discovery, library: Mapping[str, type[AbstractEffect]], report: Report = lambda _: None
) -> tuple[NextExperiment, ...]:
    """Records that would separate the first tie between effects, best first; none if nothing ties or none would."""
    for step in found.steps:
        if step.role != "effect" or len(step.tie_set) < 2 or step.regression is None:
            continue
        report(f"what would tell {' from '.join(step.tie_set[:2])}?")
        if step.instead is not None and len(step.tied) < 2:
            rivals = {step.instead.whole: step.instead.undivided, " and ".join(step.instead.names): step.instead.fit}
            return tuple(rank_experiments(rivals, count=_EXPERIMENTS))
        return tuple(next_experiments(step.regression, step.tied, library, _EXPERIMENTS))
    return ()
