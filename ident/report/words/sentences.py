"""What whoever reads a fit must know, in sentences: the verdict, what error bars mean, the limits of the physics."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from ...campaign.apart import TOLD, size_of, told_in
from ...campaign.device import Platform
from ...campaign.drive import drive_frequency
from ...campaign.record import VAGUE
from ...diagnosis.evidence.enough import FAR
from ...diagnosis.faulty.aside import left_out
from ...diagnosis.faulty.suspects import alone_off, told_by_data
from ...effects.registry import built_in
from ...fit.carry_over import expected_error
from ...fit.judge import GOOD
from ...fit.linear.one_tone import gain_of
from ...fit.result import NEGLIGIBLE_STEP, Fit
from ...model import QUALITY, open_words
from ...units import format_quantity, ratio_text, significant
from .linear import worse_than_static
from .own_numbers import own_number_words
from .quantity import display_unit, reading_unit, show
from .tables import listed

_LOW = 0.8  # below this the floor must be too high: a fit of few parameters cannot get under the noise
_SURPRISE = 4.0  # spreads from what is known beforehand: not one device in ten thousand


_OTHER_KINDS = {"no-spring": "mass and damper without a spring", "quasi-static": "gain without inertia",
                "base": "linear oscillator on the base that the drive moves",
                "shaken": "linear oscillator shaken by its base"}  # fmt: skip


class Sentence(NamedTuple):
    """A sentence; a `warning` is one that changes what may be done with the numbers."""

    text: str
    warning: bool = False


def verdict(fit: Fit) -> str:
    """One paragraph: how well the model describes the records, and what of it is known."""
    effects = listed(fit.model.names) if fit.model.names else ""
    kind = "linear platform" if isinstance(fit.model.device, Platform) else "linear oscillator"
    kind = _OTHER_KINDS.get(fit.model.form, kind)
    model = f"The {kind} with {effects}" if effects else f"The {kind} alone"
    n = sum(not s.holdout for s in fit.scores)
    ratio = fit.fitted.error_over_noise
    records = f"the {n} fitted records" if n > 1 else "the fitted record"
    if ratio <= GOOD:
        text = f"{model} describes {records} to the noise floor (error/noise {ratio_text(ratio)})."
    else:
        worst = max((s for s in fit.scores if not s.holdout), key=lambda s: s.error_over_noise)
        text = f"{model} does not describe {records}: the error is {ratio_text(ratio)} times the noise floor"
        text += f" (worst in {worst.name}, {ratio_text(worst.error_over_noise)})." if n > 1 else "."
        text += (
            " Something may be missing from it, or the noise may be more than its floors say: `ident diagnose` tells."
            if ratio**2 < FAR
            else " Something is missing from it; `ident diagnose` looks for it."
        )
    text += _held(fit) + _differing(fit) + _heldout(fit) + _not_counted(fit)
    if ratio <= GOOD:
        fitted = [e for e in fit.estimates if e.fitted]
        known = sum(not e.flags for e in fitted)
        text += f" {known} of {len(fitted)} fitted parameters are determined and differ from zero."
    return text if fit.converged else text + " The fit did not converge; its numbers are provisional."


def _not_counted(fit: Fit) -> str:
    clipped = [(r.name, r.masked) for r in fit.campaign.traces if r.masked is not None and np.any(r.masked)]
    if not clipped:
        return ""
    share = listed([f"{np.mean(masked):.1%} of {name}" for name, masked in clipped])
    return f" Samples that clipped or are missing were not counted, {share}: there nothing judges the model."


def _held(fit: Fit) -> str:
    """How the drive ran between its samples, where the records have told it to be no smooth curve."""
    free = [r.edge for r in fit.campaign.traces if r.between == "auto" and r.driven]
    edges = [edge for edge in free if edge is not None]
    if not edges:
        return ""
    apart = max(edges, key=abs)
    where = " in the records where it jumps" if None in free else ""
    when = "" if round(apart, 1) == 0 else f", and acts {abs(apart):.2g} samples {'late' if apart > 0 else 'early'}"
    return f" The drive is held between its samples{where}{when}: so the records ask, and the campaign does not say."


def _differing(fit: Fit) -> str:
    """What is another number in every record, if there is such a one."""
    traces = fit.campaign.traces
    drives = [sweep.stronger for sweep in fit.campaign.sweeps if sweep.stronger is not None]
    if drives:
        apart = significant(100 * float(np.ptp(np.concatenate(drives))), 2)
        return (
            f" Each level, held-out ones too, has a drive of its own in this, up to {apart} % apart: one device driven "
            "as the levels are called does not reach so far."
        )
    if not any(trace.differs for trace in traces):
        return ""
    kind, _ = next(trace.own for trace in traces if trace.own is not None)
    apart = float(np.ptp([size_of(trace) for trace in traces]))
    apart = format_quantity(apart, told_in(kind, traces, fit.model.device), 2)
    return (
        f" Each record, held-out ones too, has a {TOLD[kind].what} of its own in this, up to {apart} apart: one device "
        "for all of them does not reach so far."
    )


def _heldout(fit: Fit) -> str:
    if fit.holdout is None:
        return " No record was held out, so nothing shows how well it predicts."
    ratio = fit.holdout.error_over_noise
    number = ratio_text(ratio)
    if ratio <= max(GOOD, 1.1 * fit.fitted.error_over_noise):
        as_well = "to the noise floor too" if ratio <= GOOD else "no worse"
        seen = "but for that number it has" if any(r.differs for r in fit.campaign.records) else "it has"
        return f" Held-out records, which {seen} never seen, are predicted {as_well} ({number})."
    worst = max((s for s in fit.scores if s.holdout), key=lambda s: s.error_over_noise)
    expected = expected_error(fit) if fit.fitted.error_over_noise <= GOOD else math.inf
    why = "so the model does not carry over to them."
    # The square of one uncertain direction scatters: it is twice its standard error in one case of twenty.
    if math.isfinite(expected) and ratio**2 - 1 < 4 * (expected**2 - 1) + GOOD**2 - 1:
        why = f"but by no more than the errors of the parameters can make ({ratio_text(expected)} expected)."
    return (
        f" Held-out records are predicted worse ({number} times the noise floor; worst: {worst.name}, "
        f"{ratio_text(worst.error_over_noise)}), {why}"
    )


def sentences(fit: Fit) -> tuple[Sentence, ...]:
    """What must be known before a number of this fit is used, warnings first."""
    found = (*told_by_data(fit), *alone_off(fit))
    suspects = [Sentence(f"Left out as suspect: {one.left_out}", True) for one in left_out(fit)]
    suspects += [Sentence(f"Suspect record {one.sentence}", True) for one in found]
    starts = [*_starts(fit), *_off_orbit(fit)]
    own = [Sentence(text, True) for text in own_number_words(fit)]
    told = [*suspects, *starts, *own, *_error_bars(fit), *_noise(fit), *_numerics(fit)]
    told += _physics(fit)
    return tuple(sorted(told, key=lambda s: not s.warning))


def _starts(fit: Fit) -> list[Sentence]:
    """Records that do not begin as the campaign says."""
    if fit.fitted.error_over_noise <= GOOD:
        return []
    claimed = {record.name: record.start for record in fit.campaign.fitted}
    found = []
    for start, asked in (
        ("rest", "to begin at rest. Was the drive on before? Then write"),
        ("steady", "to be steady. Had the switching-on not died away? Then write"),
    ):
        moving = [f"{name} ({100 * share:.0f} %)" for name, share in fit.begun_otherwise if claimed[name] == start]
        if not moving:
            continue
        text = (
            f"Another start would take the greater part of what is left of {listed(moving)}, which the campaign says "
            f'{asked} start = "unknown" there: its start is fitted, and no physics is named for it.'
        )
        found.append(Sentence(text, True))
    return found


def _off_orbit(fit: Fit) -> list[Sentence]:
    """Steady records whose start had to be fitted."""
    found = []
    for why in dict.fromkeys(why for _, why in fit.off_orbit):
        names = listed([name for name, reason in fit.off_orbit if reason == why])
        found.append(Sentence(f"The initial state of {names} is fitted, though the campaign calls it steady: {why}."))
    return found


def _error_bars(fit: Fit) -> list[Sentence]:
    ratio = fit.fitted.error_over_noise
    meaning = {
        "known": 'sigma = "known": the error bars (one standard deviation) take each record\'s noise floor as it was '
        "given or estimated, and say nothing of errors of the model.",
        "scaled": f'sigma = "scaled": the error bars are multiplied by the error over noise ({ratio_text(ratio)}), as '
        "if all that the model misses were noise.",
        "fitted": 'sigma = "fitted": the noise of each record is what the fit left over, so that error/noise is 1 by '
        "construction and cannot judge the model; judge it by the held-out records and the residuals.",
    }[fit.sigma]
    found = [Sentence(meaning, warning=fit.sigma == "fitted")]
    quality = fit.estimates[QUALITY]
    if quality.name in fit.model.undetermined:
        text = (
            f"The quality factor is held at {quality.value:.3g}, without an error bar: a steady sine of one frequency "
            "gives two numbers, and resonance, quality and gain are three. Add a record at another frequency, or one "
            "that starts from rest."
        )
        found.append(Sentence(text, True))
    if gain_of(fit.model) in fit.model.undetermined:
        text = (
            "No record has a drive that changes, so these records say nothing about the drive's gain: it is left out."
        )
        found.append(Sentence(text))
    if worse := worse_than_static(fit):
        found.append(Sentence(worse, True))
    if not fit.converged:
        found.append(Sentence("The fit did not converge: neither values nor error bars are final.", True))
    if ratio > GOOD:
        found.append(
            Sentence(
                f"Do not trust the error bars: the model misses the records by {ratio_text(ratio)} times the noise "
                "floor, and the error bars only say how sharply this model was fitted, not how near its parameters are "
                "to the truth.",
                True,
            )
        )
    return found


def _noise(fit: Fit) -> list[Sentence]:
    """Where the noise floor itself is in doubt."""
    found = []
    vague = [r for r in fit.campaign.records if r.noise.relative_error >= VAGUE]
    if vague:
        names = listed([f"{r.name} (±{100 * r.noise.relative_error:.0f} %)" for r in vague])
        unit = display_unit(reading_unit(vague[:1]), fit.campaign.device, plain=True)
        example = format_quantity(vague[0].noise.sigma, unit, 3)
        advice = f'give it (for example noise = "{example}"), or record some periods at rest'
        text = f"The data alone leave the noise floor uncertain in {names}, so error/noise says little there: {advice}."
        found.append(Sentence(text, True))
    low = [s for s in fit.scores if s.error_over_noise < _LOW]
    if low:
        names = listed([f"{s.name} ({ratio_text(s.error_over_noise)})" for s in low])
        text = (
            f"The error is well below the noise floor in {names}: that floor is too high, and the error bars too wide."
        )
        found.append(Sentence(text, True))
    return found


def _numerics(fit: Fit) -> list[Sentence]:
    found = []
    error = significant(fit.step_error, 2)
    if fit.step_error <= NEGLIGIBLE_STEP:
        text = f"Halving the solver's step changes no record by more than {error} of its noise floor: negligible."
        found.append(Sentence(text))
    else:
        text = (
            f"Halving the solver's step changes a record by {error} of its noise floor, more than a tenth: "
            "part of the error may be the solver's."
        )
        own = [effect.name for effect in fit.model.effects if effect.name not in built_in() and not effect.has_kink]
        if own:
            text += f" If a force of {listed(own)} turns or jumps, write has_kink = True in the effect's file."
        found.append(Sentence(text, True))
    return [*found, *_curves(fit)]


def _curves(fit: Fit) -> list[Sentence]:
    """What the numbers of sweeps leave out."""
    found = []
    apart = sum(int(np.count_nonzero(curve.apart)) for curve in fit.curves)
    if apart:
        many = f"{apart} points of the sweeps lie" if apart > 1 else "One point of the sweeps lies"
        text = (
            f"{many} where device and model were on different branches, between their jumps: rms errors leave them out."
        )
        found.append(Sentence(text))
    beside = sum(int(np.count_nonzero(~curve.settled)) for curve in fit.curves)
    if beside:
        text = (
            f"{beside} points of the sweeps lie beside a jump, or differ on the ways up and down where nothing jumps, "
            "and do not count: where a branch ends, or a curve is about to fold, a motion settles as slowly as one "
            "likes."
        )
        found.append(Sentence(text))
    for curve in fit.curves:
        volts = curve.sweep.drive_channel
        for run in curve.backwards:
            called, way = ("up", "down") if run.up else ("down", "up")
            level = f"{run.level / volts.factor:.4g} {volts.unit}"
            text = (
                f"{curve.sweep.name}: the sweep {called} at {level} jumps where this model does on its way {way}. Was "
                f"it swept {way}? The parameters do not depend on it; the jumps and the rms errors do."
            )
            found.append(Sentence(text, True))
    for curve in fit.curves:
        if curve.of_harmonics:
            rms = lambda left: significant(float(np.sqrt(np.nanmean(left**2))), 3)
            told = ", ".join(f"of harmonic {order} {rms(left)}" for order, left in curve.of_harmonics)
            text = f"{curve.sweep.name}: the error over noise of the amplitudes is {rms(curve.residual)}, {told}."
            found.append(Sentence(text))
    lost = sum(curve.unsolved for curve in fit.curves)
    if lost:
        many = f"{lost} points" if lost > 1 else "one point"
        text = (
            f"At {many} of the sweeps the model has no steady response of the measured amplitude that could be found."
        )
        found.append(Sentence(text, True))
    return found


def _physics(fit: Fit) -> list[Sentence]:
    found, device = [*_words_found(fit), *_unexpected(fit)], fit.model.device
    if isinstance(device, Platform):
        gain = fit.value("platform.d31") * fit.model.linear.force_per_gain
        text = (
            f"K_f and d31 enter as a product: the records give the drive force, {show(gain, None, 'N/V', device)}, and "
            "d31 is what follows with K_f from the device's geometry."
        )
        found.append(Sentence(text))
    cautions = [effect.caution(*_band(fit)) for effect in fit.model.effects]
    return found + [Sentence(text, warning) for text, warning in cautions if text]


def _words_found(fit: Fit) -> list[Sentence]:
    """Words of choices that the records have told, where they are not the usual ones: who fits again needs them."""
    found = []
    for effect in fit.model.effects:
        for name, usual in open_words(fit.campaign, type(effect))[0].items():
            if (word := getattr(effect, name)) != usual:
                text = f'Of {effect.name} the records say {name} = "{word}": to fit it again, write that under '
                found.append(Sentence(f"{text}[effect.{effect.name}] in the campaign."))
    return found


def _unexpected(fit: Fit) -> list[Sentence]:
    """Parameters far from what is known of the device before it is measured: is it the device that is described?"""
    found, device = [], fit.model.device
    told = (
        ' Give its geometry (device = "device.toml"), or say that it is no platform: device = { kind = "oscillator", '
        'output = "m", input = "V" }.'
    )
    for parameter, estimate in zip(fit.model.parameters, fit.estimates, strict=True):
        known, value = parameter.expected, estimate.value
        if known is None or not estimate.fitted:
            continue
        off = math.log(value / known.centre) if parameter.positive else value - known.centre
        if abs(off) > _SURPRISE * known.spread:
            usual = show(known.centre, None, parameter.unit, device)
            text = (
                f"{parameter.name} = {show(value, None, parameter.unit, device)} is far from the {usual} that are "
                f"expected ({known.source}): is this that device?"
            )
            found.append(Sentence(text + (told if isinstance(device, Platform) else ""), True))
    return found


def _band(fit: Fit) -> tuple[float, float]:
    """The lowest and the highest frequency of the drives that were fitted, Hz."""
    frequencies = [drive_frequency(r) / (2 * math.pi) for r in fit.campaign.fitted if np.ptp(r.drive) > 0]
    frequencies += [float(f) for sweep in fit.campaign.fitted_sweeps for f in sweep.frequency]
    return min(frequencies, default=0.0), max(frequencies, default=0.0)
