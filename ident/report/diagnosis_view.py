"""A diagnosis in words and tables: verdict, ranking, ties, what to do next."""

from __future__ import annotations

import numpy as np

from ..campaign.quality.suspect import ALL, Suspect
from ..diagnosis.answer import Diagnosis
from ..diagnosis.evidence.enough import ANOTHER_LAW, adequate, noise_of_force
from ..diagnosis.evidence.held_out import contradicted
from ..diagnosis.faulty.suspects import BY_OTHERS
from ..diagnosis.search.beyond import NAME
from ..diagnosis.search.steps import Discovery, Step
from ..diagnosis.unknown.simulated import curve_of
from ..fit import Fit
from ..fit.judge import GOOD
from ..fit.start_score import mostly_starts
from ..units import ratio_text
from .candidates_view import later_sheet, ranking_sheet
from .figures.picture import draw
from .figures.where import where_figure
from .html import Section
from .words.data import one_frequency
from .words.tables import listed, percent_text

_OTHER_STARTS = (
    "with other starts than are claimed the model leaves less than half of that. "
    'Write start = "unknown" in these records, and ask again: what is then left is no matter of starts.'
)


def verdict_words(found: Diagnosis) -> str:
    """The verdict in one or two sentences."""
    without = [record.name for record, _ in found.final.campaign.left_out]
    be = "is" if len(without) == 1 else "are"
    return f"{listed(without)} {be} left out. {_by_the_rest(found)}" if without else _by_the_rest(found)


def _by_the_rest(found: Diagnosis) -> str:
    held = found.discovery.final.holdout
    if held is None or not contradicted(found.discovery.final):
        return _verdict_words(found)
    return (
        f"The held-out records contradict this model: it stands at {ratio_text(held.error_over_noise)} noise floors "
        f"there, {percent_text(held.error_over_signal)} of their signal, which no error of its parameters makes. They "
        f"may be of another device or wrongly labelled, or what they need cannot be seen in the fitted ones. "
        f"{_verdict_words(found) if found.discovery.steps else ''}"
    ).strip()


def _verdict_words(found: Diagnosis) -> str:
    """The verdict by the fitted records."""
    loop = found.discovery
    final = loop.final
    first = [suspect.file for suspect in _unsettled(found)]
    if first == [ALL]:
        return "No physics is named: that all responses come late explains more of the misfit than any effect does."
    if first:
        what = "that explains more of the misfit than any effect does"
        be = "is" if len(first) == 1 else "are"
        return f"No physics is named before {listed(first)} {be} corrected or left out: {what}."
    error = f"error over noise {ratio_text(final.fitted.error_over_noise)}{_no_shortcoming(loop)}"
    if loop.verdict == "adequate":
        return f"The model is adequate: {error}, and no effect of the library would lower it beyond chance."
    named = [s for s in loop.steps if s.role == "effect"]
    shaped = [s.added for s in loop.steps if s.role == "shape-refinement"]
    names = " and ".join(s.added for s in named)
    one = len(named) == 1
    was, them, s = ("was", "it", "s") if one else ("were", "them", "")
    refine = "refines its shape" if len(shaped) == 1 else "refine its shape"
    refined = f" ({' and '.join(shaped)} only {refine})" if shaped else ""
    if loop.verdict == "ambiguous" and not named:
        if mostly_starts(final):
            return f"Nothing is named, {error}: {_OTHER_STARTS}"
        return (
            f"Nothing is named, {error}: what the model leaves looks like no law that a simulation keeps; it may be "
            "noise that the floors do not know."
        )
    if loop.verdict == "ambiguous" and not adequate(loop.regression) and mostly_starts(final):
        return f"{names}{refined} come{s} near, {error}: {_OTHER_STARTS}"
    if loop.shorter:
        return (
            f"Missing {was} {names}{refined}, {error}, or one law in their place, which says more "
            f"with fewer numbers: {loop.shorter}."
        )
    if loop.verdict == "ambiguous" and not loop.lacking and not any(len(s.tie_set) > 1 for s in named):
        seen = "On the fitted records"
        if any(record.differs for record in final.campaign.records):
            each = "level" if final.campaign.sweeps else "record"
            seen = f"Beside a number of its own for each {each}"
        return f"{seen} {names}{refined} {'is' if one else 'are'} what was missing, {error}."
    if loop.verdict == "identified" and adequate(loop.regression):
        return f"Missing {was} {names}{refined}: with {them} the model is adequate, {error}."
    if loop.verdict == "identified":
        return f"Missing {was} {names}{refined}; the device's own law has a slightly other shape, {error}."
    if loop.verdict == "ambiguous" and 0 < loop.lacking < ANOTHER_LAW:
        return (
            f"Missing {was} {names}{refined}, {error}, or a law much like it: {100 * loop.lacking:.1g} % of the misfit "
            "is left with a structure. The missing term is also given below as a function of its coordinates: is its "
            "curve the one that you expect?"
        )
    if loop.verdict == "ambiguous" and loop.lacking:
        return (
            f"{names}{refined} come{s} near, {error}, but leave{s} {100 * loop.lacking:.2g} % of the first misfit with "
            "a structure, more than laws of one kind differ by: the device may obey another law, which is given below "
            "as a function of its coordinates."
        )
    if loop.verdict == "ambiguous":
        ties = [f"{s.added} cannot be told from {' or '.join(s.tie_set[1:])}" for s in named if len(s.tie_set) > 1]
        doubt = [f"{s.file} is suspect" for s in found.suspects if s.kind in BY_OTHERS]
        return f"Missing {was} {names}{refined}, {error}; but in these records {'; '.join(ties + doubt)}."
    return _not_in_library(loop, [s for s in named if not s.added.startswith(NAME)], named)


def _unsettled(found: Diagnosis) -> list[Suspect]:
    """Suspects that come before any physics, and could not be left out."""
    aside = [record.name for record, _ in found.final.campaign.left_out]
    return [one for one in found.suspects if one.first and one.file not in aside]


def _no_shortcoming(loop: Discovery) -> str:
    """What of an error above the noise floors is no shortcoming of a model: noise of the force, or that of a colour."""
    noise, left = noise_of_force(loop.regression), loop.regression
    if noise is not None:
        size = f", {percent_text(noise.share)} of the drive," if noise.share > 0 else ""
        return (
            f" (what is above one noise of the force{size} leaves: of its measurement, an amplifier, the surroundings)"
        )
    white = float(np.sqrt(left.chi2 / left.n))
    if loop.final.fitted.error_over_noise <= GOOD or white > GOOD or left.fit is not loop.final:
        return ""
    return f" ({ratio_text(white)} where mains hum and the noise's colour are taken out)"


def _not_in_library(loop: Discovery, known: list[Step], named: list[Step]) -> str:
    """What the effects of the library do together, and what a written one adds."""
    start, after = loop.start.fitted.error_over_noise, [s.fit.fitted.error_over_noise for s in known]
    if known:
        share = 1 - (after[-1] ** 2 - 1) / max(start**2 - 1, 1e-9)
        lower = "lowers" if len(known) == 1 else "lower"
        said = (
            f"No effects of the library explain these records to the noise: {' and '.join(s.added for s in known)} "
            f"{lower} error over noise from {ratio_text(start)} to {ratio_text(after[-1])}, {100 * share:.3g} % of the "
            "misfit, which is no proof."
        )
    else:
        best = max(loop.confirmed, key=loop.confirmed.__getitem__, default="")
        share = 100 * loop.confirmed.get(best, 0.0)
        helps = f"the best, {best}, takes {share:.3g} % of the misfit" if share > 1 else "none helps"
        said = f"No effect of the library explains these records (error over noise {ratio_text(start)}; {helps})."
    if len(named) == len(known):
        return said
    left = ratio_text(named[-1].fit.fitted.error_over_noise)
    return f"{said} {named[-1].added}, written from what is missing, lowers it to {left}."


def why_not_written(found: Diagnosis) -> str:
    """Why nothing was written of what the library lacks."""
    loop, unknown = found.discovery, found.unknown
    if _unsettled(found) and not loop.steps:
        return "what is wrong with the records comes before any law"
    if loop.verdict == "adequate":
        return "nothing is missing"
    if not loop.final.campaign.fitted:
        return "a law beyond the library is looked for in traces only, and none is fitted"
    if loop.verdict == "not-in-library" and unknown is not None:
        return "no term describes what is missing"
    if loop.verdict == "not-in-library" and not contradicted(loop.final):
        return "the excerpts on which laws are compared lack nothing: what is missing shows in whole records only"
    if loop.verdict == "not-in-library":
        return "the fitted records lack nothing, it is the held-out ones that contradict"
    if not loop.steps:
        return "what is left looks like no law that a simulation keeps"
    if loop.lacking:
        return "effects of the library come near, and what they leave may be a slightly other shape of theirs"
    return "effects of the library explain these records"


def advice(found: Diagnosis) -> list[str]:
    """What ties, what is unknown, and what to measure next, one sentence each."""
    sentences = [f"Suspect record: {suspect.sentence}" for suspect in found.suspects]
    sentences += [*_scored_from(found.discovery), *_together(found.discovery)]
    sentences += [reason for step in found.discovery.steps if step.role == "effect" for reason in step.reasons]
    for experiment in found.next_experiments[:1]:
        pair = " from ".join(" or ".join(group) for group in experiment.groups)
        gain = experiment.expected_delta_chi2
        sentences.append(f"To tell {pair}, measure: {experiment.record} (expected Δχ² {gain:.3g}).")
    sentences += _not_identified(found.discovery.final)
    absorbed, settled = ([one.name for one in found.unseen if one.settled is kind] for kind in (False, True))
    if settled:
        sentences.append(
            f"Curves of settled motion show only the mean that {listed(settled)} come to, and are not asked for them: "
            "records in time are."
        )
    if absorbed:
        names, them = listed(absorbed), "it" if len(absorbed) == 1 else "them"
        model = "the first model" if found.discovery.steps else "this model"
        sentences.append(f"Beside {model} these records cannot show {names}: its parameters absorb {them}.")
    if found.unknown is not None:
        sentences += found.unknown.sentences
    if found.effect_file is not None:
        sentences.append(f"It is written as an effect of your own to refine: {found.effect_file}")
    return sentences


def _scored_from(loop: Discovery) -> list[str]:
    """Where the effects were scored, if not from the first fit."""
    regression = loop.steps[0].regression if loop.steps else None
    if regression is None or regression.instead_of is None:
        return []
    if not regression.alone:
        return [
            "No values of the first model come near the records; effects were scored from those that its equation of "
            "motion has along the measured motion."
        ]
    alone = next(s for s in regression.fit.scores if s.name == regression.alone)
    return [
        f"No values of the first model come near all records; effects were scored from those that describe "
        f"{alone.name} alone (error over noise {ratio_text(alone.error_over_noise)} there)."
    ]


def _together(loop: Discovery) -> list[str]:
    """Which effects were added at once, and why the table of single ones does not show them."""
    said, before = [], loop.start
    for one, other in zip(loop.steps, loop.steps[1:], strict=False):
        if one.partner == other.added:
            first, last = before.fitted.error_over_noise, other.fit.fitted.error_over_noise
            builds = any((e.name, e.needs) == (other.added, one.added) for e in other.fit.model.effects)
            why = (
                f"{other.added} builds on {one.added} and could be asked for only beside it" if builds
                else f"{one.added} and {other.added} each hide what the other does, so neither stands out alone"
            )  # fmt: skip
            fall = f"from {ratio_text(first)} to {ratio_text(last)}"
            said.append(f"{why}: together they lower error over noise {fall}.")
        before = one.fit
    return said


def _not_identified(final: Fit) -> list[str]:
    """A warning where effects with memory were fitted to records at one frequency only."""
    memory = [effect.name for effect in final.model.effects if effect.hidden_units]
    frequency = one_frequency(final.campaign.fitted)
    if not memory or frequency is None:
        return []
    return [
        f"All fitted records are driven at {frequency:.3g} Hz: how {listed(memory)} and a delay share what comes late "
        "is not identified, and the model may fail at other frequencies. Add a record at another one."
    ]


def sections(found: Diagnosis) -> list[Section]:
    """The diagnosis as parts of the report."""
    device = found.discovery.start.model.device
    where = draw("Error over noise by record, time, motion, phase and harmonic", where_figure(found.where))
    parts = [Section("Where the first model fails", (), (), (where,))]
    if found.suspects and not found.discovery.ranking:
        parts.append(Section("Which record is suspect", (verdict_words(found), *advice(found))))
    if found.discovery.ranking:
        words = (verdict_words(found), *advice(found))
        sheets = [sheet for sheet in (ranking_sheet(found), later_sheet(found)) if sheet is not None]
        parts.append(Section("Which effect is missing", words, sheets))
    if found.unknown is not None:
        from .figures.unknown import unknown_figure

        picture = draw("The missing term against its coordinates", unknown_figure(found.unknown, device, _law(found)))
        parts.append(Section("What the library lacks", found.unknown.sentences, (), (picture,)))
    return parts


def _law(found: Diagnosis) -> np.ndarray | None:
    """The curve of the missing term as the last fit has it, if what was written of it is kept there."""
    steps, final = found.discovery.steps, found.discovery.final
    kept = found.effect_file in final.campaign.effect_files and steps and steps[-1].added.startswith(NAME)
    if found.unknown is None or not kept:
        return None
    bound = {effect.name: effect for effect in final.model.bind(final.values)[1]}
    constant = any(effect.is_constant for effect in bound.values())
    return curve_of(bound[steps[-1].added], found.unknown, constant)
