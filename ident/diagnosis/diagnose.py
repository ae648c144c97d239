"""The four questions after a fit: is it adequate, where does it fail, which effect is missing, what to measure next."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from ..campaign.campaign import Campaign
from ..campaign.held_drive import jumps
from ..campaign.quality.suspect import ALL, Suspect
from ..campaign.read import PathLike
from ..campaign.trust import trust
from ..effects.registry import Registry, registry
from ..errors import UserError
from ..fit import Fit, fit, fit_data
from ..fit.fit_data import Effects
from ..pulse import Report
from ..threads import one_thread
from .answer import Diagnosis
from .apart import Apart, apart_after, apart_before
from .doubts import beside_law, in_doubt
from .evidence.enough import adequate
from .evidence.held_out import contradicted, foretold
from .faulty.aside import left_out, without_them
from .faulty.odd_one import odd_one
from .faulty.suspects import find_suspects, judged_again
from .linearised.regression import Regression, prepare
from .linearised.shorten import working
from .linearised.trajectory import Diverged
from .next_record.experiments import NextExperiment, next_experiments, rank_experiments
from .ranking.look import Look, first_look
from .records.between import alike, differing
from .records.differing import without_common_zero
from .search.conclude import concluded, concluded_or_sharper
from .search.discover import Keep, walk_on
from .search.one_law import in_their_place, one_law
from .search.own_zeros import has_own_zeros
from .search.steps import Discovery, Walked
from .search.ties import unseen
from .search.together import two_names_do
from .search.written import AS_WELL, beyond_library
from .search.zero import zero_of_the_sensor
from .unknown.find import find_unknown
from .where.locate import Where, locate


@one_thread
def discover(
    data: Any,
    effects: Effects = None,
    *,
    report: Report = lambda _: None,
    effect_file: PathLike | None = None,
    **told: Any,
) -> Diagnosis:
    """Fit, see where the model fails, add what explains it, until the noise floor; `.final` is the last model.

    **Arguments:** `data`, `effects`, `told`: as in `ident.fit`; `effect_file`: as in `diagnose`; without one a law that
    the library lacks is told (`.unknown`), and `.final` is without it.
    """
    return diagnose(fit_data(data, effects, report=report, **told), None, report, effect_file, keeps_walk=True)


@one_thread
def diagnose(
    fitted: Fit | Walked,
    library: Registry | None = None,
    report: Report = lambda _: None,
    effect_file: PathLike | None = None,
    keeps_walk: bool = False,
    keep: Keep = lambda _: None,
) -> Diagnosis:
    """Locate the misfit, walk the loop, and look beyond the library where it does not reach.

    **Arguments:** `fitted`: or a walk that was stopped, which goes on; `library`: the effects to choose from, if not
    all that the campaign knows; `effect_file`: where to write what the library lacks; the model with it then ends the
    walk. `keeps_walk`: whether the caller goes on with the last model of the walk; what it lacks is then written, if
    named effects nearly explain the records, and else what the fit lacks. `keep`: as of `walk_on`.

    **Raises:** UserError if the `effect_file` exists.
    """
    written = None if effect_file is None else Path(effect_file)
    if written is not None and written.exists():
        raise UserError("this file exists already", where=str(written), do="choose another name, or move it away")
    walked = fitted if isinstance(fitted, Walked) else Walked(fitted)
    library = registry(walked.start.campaign.effect_files) if library is None else library
    said = _answered(_Asked(library, report, written, keeps_walk, keep), walked)
    if said.effect_file is not None:
        trust(said.effect_file)  # our own words
    aside = left_out(said.final)
    if aside and said.verdict == "identified":  # beside a suspect no name is sure
        said = replace(said, discovery=replace(said.discovery, verdict="ambiguous"))
    return replace(said, suspects=(*aside, *said.suspects))


@dataclass(frozen=True, eq=False)
class _Asked:
    """What was asked, the same however often the walk begins anew; each as of `diagnose`."""

    library: Registry
    report: Report
    effect_file: Path | None
    keeps_walk: bool
    keep: Keep


@dataclass(frozen=True, eq=False)
class _Seen:
    """What is seen of the fit with which a walk begins: its regression, `where` it fails, what the library says of it.

    **Arguments:** `suspects`: records that something is wrong with, and `first`, those of them that come before any
    physics; `apart`: records that differ in a number each, where that promises to spare the walk.
    """

    walked: Walked
    regression: Regression
    where: Where
    look: Look
    suspects: tuple[Suspect, ...]
    first: tuple[Suspect, ...]
    apart: Apart | None

    @property
    def fitted(self) -> Fit:
        """The fit that is looked at."""
        return self.walked.start


def _answered(asked: _Asked, walked: Walked) -> Diagnosis:
    """The first answer that there is: what comes before any physics, what is no effect of the library, and then what
    the walk names. An answer that reads the records otherwise asks again with the walk that begins there."""
    said = _beside_zero(asked, walked)
    if said is not None:
        return said
    seen = _seen(asked, walked)
    return (
        _records_differ(asked, seen, seen.apart)
        or _without_faulty(asked, seen)
        or _one_law_says_it(asked, seen)
        or _after_the_walk(asked, seen)
    )


def _beside_zero(asked: _Asked, walked: Walked) -> Diagnosis | None:
    """The answer beside the zero of a platform's sensor, which is the first step; None if it is not off."""
    zero = zero_of_the_sensor(walked, asked.library, asked.report)
    if zero is None:
        return None
    with_zero = lambda walked: zero.step.added in walked.start.model.names
    go_on = lambda walked: asked.keep(zero.before(walked) if with_zero(walked) else walked)
    said = _answered(replace(asked, keep=go_on), zero.beside(walked))
    if zero.step.added not in said.discovery.start.model.names:
        return said  # each record has a zero of its own
    discovery = zero.whole(said.discovery, asked.report)
    where = locate(prepare(working(discovery.start)), discovery.start)
    own = replace(discovery, steps=discovery.steps[:1])  # of the others the walk beyond it has said
    records = said.next_experiments or measure_next(own, asked.library, asked.report)
    return replace(said, discovery=discovery, where=where, next_experiments=records)


def _seen(asked: _Asked, walked: Walked) -> _Seen:
    fitted, report = walked.start, asked.report
    report("locating the misfit")
    regression = prepare(working(fitted))
    where = locate(regression, fitted)
    look = first_look(fitted, asked.library, report)
    looked = lambda one: look if one is fitted else first_look(one, asked.library, report)
    suspects = find_suspects(fitted, looked, report, lambda: two_names_do(look, regression))
    first = tuple(suspect for suspect in suspects if suspect.first)
    faulty = any(suspect.settles for suspect in first)  # else it may be the worst of several that each have a number
    if first and not faulty:
        first = beside_law(first, find_unknown(regression))
    apart = None if walked.steps or faulty else apart_before(look, report)
    return _Seen(walked, regression, where, look, suspects, first, apart)


def _records_differ(asked: _Asked, seen: _Seen, apart: Apart | None) -> Diagnosis | None:
    """The answer where records that differ in a number each, and the library, explain them to the noise; None where
    they do not, or one law of a single coordinate does, which is the shorter answer.

    The numbers are found again after the walk that they make possible, for what was missing had bent them. Where all
    but one record then agree, the answer is that of these, if they stand at their noise.
    """
    if apart is None:
        return None
    start, one = apart
    if start.campaign.fitted:
        law = find_unknown(seen.regression)
        if law.formula is not None and law.of_one_law and law.chi2_after < AS_WELL:
            return None
    walk = lambda one: concluded(walk_on(Walked(one.begun(start)), asked.library, asked.report))
    found = walk(one)
    again = differing(fit(found.final.model, start.campaign, initial=found.final.values), alike(one.kind))
    if again is None:
        return None
    quietly, odd = replace(asked, keep=lambda _: None), odd_one(again)
    if odd is not None and (said := _of_the_others(quietly, seen, (odd,))) is not None:
        return said
    if again.kind != one.kind or again.moved(one):
        found = walk(again)
    if not adequate(found.regression) or contradicted(found.final):
        return None
    beside = replace(asked, effect_file=None, keeps_walk=False)
    said = _answered(beside, Walked(found.start, found.steps, found.confirmed))
    # An effect may be mistaken for what differs, as for what is faulty.
    sure = said.verdict == "identified"
    said = replace(said, discovery=replace(said.discovery, verdict="ambiguous")) if sure else said
    return said if odd is None else replace(said, suspects=(*said.suspects, odd))


def _without_faulty(asked: _Asked, seen: _Seen) -> Diagnosis | None:
    """The answer of the other records, where some are faulty; that there is none, if these are too few."""
    first, campaign = seen.first, seen.fitted.campaign
    late = bool(first) and all(suspect.file == ALL for suspect in first)
    # A drive that jumps tells by its edges how late it acts, and the walk begins again with that.
    held = late and any(jumps(record.drive) for record in campaign.fitted if record.between == "auto")
    if not first or held:
        return None
    rest = without_them(seen.fitted, first)
    if rest is None:
        nothing = Discovery("ambiguous", seen.fitted, (), (), {}, (), seen.regression)
        return Diagnosis(nothing, seen.where, suspects=seen.suspects)
    asked.report(f"going on without {', '.join(one.file for one in first)}")
    return replace(_answered(asked, Walked(rest)), where=seen.where)


def _without_faults(asked: _Asked, seen: _Seen, suspects: tuple[Suspect, ...]) -> Diagnosis | None:
    """The same where faults settle everything: that of one record is one number, and then none of all records' own is
    asked."""
    settled = any(one.first and one.settles for one in suspects)
    return _without_those_seen_now(asked, seen, suspects) if settled else None


def _without_those_seen_now(asked: _Asked, seen: _Seen, suspects: tuple[Suspect, ...]) -> Diagnosis | None:
    """The answer without records whose fault only shows beside what a walk has named, if all others then stand at their
    noise; None if there are none, or these do not. What is wrong in one record and a missing effect hide one another.
    """
    known = {(one.file, one.kind) for one in seen.suspects if one.first}
    new = tuple(one for one in suspects if one.first and (one.file, one.kind) not in known)
    return _of_the_others(asked, seen, new)


def _of_the_others(asked: _Asked, seen: _Seen, faulty: tuple[Suspect, ...]) -> Diagnosis | None:
    """The answer without some records, if all others then stand at their noise; None if there are none, or these do
    not."""
    rest = without_them(seen.fitted, faulty) if faulty else None
    if rest is None:
        return None
    asked.report(f"once more without {', '.join(one.file for one in faulty)}")
    try:
        said = _answered(asked, Walked(rest))
        if adequate(said.discovery.regression) and foretold(said.final):
            return replace(said, where=seen.where)
    except Diverged:  # without them a motion has no bound
        pass
    if asked.effect_file is not None:  # of a law that is not believed: there was none before
        asked.effect_file.unlink(missing_ok=True)
    return None


def _one_law_says_it(asked: _Asked, seen: _Seen) -> Diagnosis | None:
    """The answer where one law that the library lacks says everything: no walk is needed."""
    if seen.walked.steps or seen.first:
        return None
    with TemporaryDirectory() as folder:
        path = asked.effect_file or Path(folder) / "law.py"
        law = one_law(seen.look, seen.fitted, seen.regression, path, asked.report)
        if isinstance(law, Campaign):
            return _once_more(asked, seen, law)
        if law is None:
            return None
        hidden = unseen(seen.regression, law.discovery.ranking, asked.library)
        suspects = judged_again(seen.suspects, law.discovery.final, asked.report)
        told = law.discovery if asked.effect_file is not None else replace(law.discovery, steps=())
        return Diagnosis(told, seen.where, law.unknown, asked.effect_file, unseen=hidden, suspects=suspects)


def _once_more(asked: _Asked, seen: _Seen, campaign: Campaign) -> Diagnosis:
    """The answer to the records as they are to be read."""
    asked.report("what the last model leaves tells better how the records are to be read: once more, so")
    before = without_common_zero(seen.fitted) if has_own_zeros(campaign) else seen.fitted
    return _answered(asked, Walked(fit(before.model, campaign, initial=before.values)))


def _after_the_walk(asked: _Asked, seen: _Seen) -> Diagnosis:
    """The answer of the walk; or of one that begins again, where it shows that records differ, or are to be read
    otherwise."""
    ended = walk_on(seen.walked, asked.library, asked.report, keep=asked.keep, look=seen.look)
    last, as_it_is = ended.walked.final, replace(asked, keep=lambda _: asked.keep(ended.walked))  # till one is believed
    suspects: tuple[Suspect, ...] | None = None
    if ended.anew is None and last is not seen.fitted and not adequate(ended.look.regression):
        suspects = judged_again(seen.suspects, last, asked.report)
        if (said := _without_faults(as_it_is, seen, suspects)) is not None:  # a walk that need not be questioned first
            return said
    found = concluded_or_sharper(ended)
    if isinstance(found, Campaign):
        return _once_more(asked, seen, found)
    if found.start is not seen.fitted:  # the walk has begun again, from a better first model
        regression = prepare(working(found.start))
        seen = replace(seen, regression=regression, where=locate(regression, found.start))
    if suspects is None or found.final is not last:
        suspects = judged_again(seen.suspects, found.final, asked.report)
        if not adequate(found.regression) and (said := _without_faults(as_it_is, seen, suspects)) is not None:
            return said
    if not adequate(found.regression):
        if found.verdict != "adequate" and seen.apart is None:
            said = _records_differ(asked, seen, apart_after(seen.look, found.final, asked.report))
            if said is not None:
                return said
        if any(one.first for one in suspects) and not any(one.first and one.settles for one in suspects):
            sound = beside_law(suspects, find_unknown(seen.regression))
            if (said := _without_those_seen_now(as_it_is, seen, sound)) is not None:
                return said
    found = in_doubt(found, suspects)
    hidden = unseen(seen.regression, found.ranking, asked.library)
    said = Diagnosis(found, seen.where, unseen=hidden, suspects=suspects)
    # What a curve lacks beyond the library, and the next record, only traces tell.
    return _and_beyond(asked, seen, said) if seen.fitted.campaign.fitted else said


def _and_beyond(asked: _Asked, seen: _Seen, said: Diagnosis) -> Diagnosis:
    """The answer of a walk with what the library lacks, or else with the records that would tell what ties."""
    found, start, path, report = said.discovery, seen.regression, asked.effect_file, asked.report
    instead = in_their_place(found, start, path, report) if asked.keeps_walk and path else None
    written = instead or beyond_library(found, start, path, asked.keeps_walk, report)
    kept = written.discovery
    suspects = beside_law(said.suspects, written.unknown)
    if suspects and kept is not found and kept.steps:
        # The law that they had lacked may have made them suspects.
        suspects = judged_again(suspects, kept.final, report)
    said = replace(said, discovery=kept, unknown=written.unknown, effect_file=written.path, suspects=suspects)
    if kept.verdict == "not-in-library" or kept is not found:
        return said
    return replace(said, next_experiments=measure_next(found, asked.library, report))


def measure_next(found: Discovery, library: Registry, report: Report = lambda _: None) -> tuple[NextExperiment, ...]:
    """Records that would separate the first tie between effects, best first; none if nothing ties or none would."""
    for step in found.steps:
        if step.role != "effect" or len(step.tie_set) < 2 or step.regression is None:
            continue
        report(f"what would tell {' from '.join(step.tie_set[:2])}?")
        if step.instead is not None and len(step.tied) < 2:
            rivals = {step.instead.whole: step.instead.undivided, " and ".join(step.instead.names): step.instead.fit}
            return tuple(rank_experiments(rivals))
        return tuple(next_experiments(step.regression, step.tied, library))
    return ()
