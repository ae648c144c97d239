"""The tables of a fit: parameters, error per record, what is undetermined, starts."""

from __future__ import annotations

import math
from collections.abc import Sequence

from ...campaign.apart import TOLD, size_of
from ...campaign.device import Device
from ...fit.identifiability import Combination
from ...fit.judge import GOOD, RecordScore, Score
from ...fit.result import Estimate, Fit
from ...units import ratio_text, significant
from .quantity import Scale, reading_unit, scale, show, show_in
from .sheet import Column, Mark, Sheet, file_words

_FLAGS = {
    "undetermined": "undetermined",
    "at-bound": "at the edge of its range",
    "not-significant": "not significant: may be zero",
    "held": "held",
}
_CORRELATED = 0.9  # correlation from which two parameters are said to be poorly told apart
_MOST_PAIRS = 6  # of such parameters that are told: a table of fifty numbers has a thousand
_SAME_MINIMUM = 1e-3  # relative difference of the error within which two starts reached the same minimum


def flag_words(flags: tuple[str, ...]) -> str:
    """Flags of an estimate in words."""
    return "; ".join(_FLAGS.get(flag, flag.replace("-", " ")) for flag in flags)


def parameter_sheet(fit: Fit) -> Sheet:
    """Every parameter with value, standard error, unit and what is wrong with it."""
    device, rows, marks = fit.model.device, [], []
    unsure = False
    unused = {f"{effect.name}.{name}" for effect in fit.model.effects for name in effect.unused()}
    for e in fit.estimates:
        shown = show(e.value, e.standard_error, e.unit, device)
        alone = "undetermined" in e.flags
        unsure |= alone
        remark = "not used with these settings" if e.name in unused else flag_words(e.flags) or _unexplained(e)
        value = f"({shown.value})" if alone else shown.value
        rows.append((e.name, value, f"± {shown.error}" if shown.error else "", shown.unit, remark))
        marks.append(_mark(e))
    note = "A value in brackets is one of many that fit equally well." if unsure else ""
    columns = (
        Column("parameter"), Column("value", True), Column("std. error"), Column("unit"), Column("remark", wraps=True),
    )  # fmt: skip
    return Sheet("Parameters", columns, tuple(rows), tuple(marks), note)


def _unexplained(estimate: Estimate) -> str:
    return "no error bar: its covariance is singular" if estimate.fitted and estimate.standard_error is None else ""


def _mark(estimate: Estimate) -> Mark:
    return "quiet" if "held" in estimate.flags else "warning" if estimate.flags else ""


def record_sheet(fit: Fit) -> Sheet:
    """Error per record beside its noise floor, and the totals of fitted and held-out records."""
    totals = [("all fitted", fit.fitted)] + ([("all held out", fit.holdout)] if fit.holdout else [])
    unit = reading_unit(fit.campaign.records)
    common = error_scale(fit.fitted, fit.model.device, unit)
    ordered = sorted(fit.scores, key=lambda s: s.holdout)
    rows = [_score_row(file_words(s.name), "held out" if s.holdout else "fitted", s, common) for s in ordered]
    marks: list[Mark] = ["warning" if s.error_over_noise > GOOD else "" for s in ordered]
    rows += [_score_row(name, "", score, common) for name, score in totals]
    marks.extend("total" for _ in totals)
    note = "error/noise = 1 is as good as the data allow; 100 % of the signal is no better than a constant."
    columns = (
        Column("record", wraps=True), Column("use"), Column("samples", True),
        Column(f"rms error ({common.unit})", True, True), Column(f"noise floor ({common.unit})", True, True),
        Column("error/noise", True), Column("of signal", True),
    )  # fmt: skip
    own = {r.name: size_of(r) for r in fit.campaign.traces if r.own is not None}
    if own:
        kind = next(TOLD[r.own[0]] for r in fit.campaign.traces if r.own is not None)
        told = Scale(1.0, kind.unit) if kind.unit else scale(max(map(abs, own.values())), unit, fit.model.device)
        sizes = [f"{own[s.name] / told.factor:+.3g}" if s.name in own else "" for s in ordered]
        rows = [(*row, size) for row, size in zip(rows, [*sizes, *("" for _ in totals)], strict=True)]
        columns = (*columns, Column(f"own {kind.what} ({told.unit})", True, True))
    return Sheet("Error per record", columns, tuple(rows), tuple(marks), note)


def error_scale(score: RecordScore | Score, device: Device, unit: str = "m") -> Scale:
    """The unit for an error and its noise floor, a multiple of the SI `unit`: that of the noise while the error has
    four digits at most."""
    chosen = scale(score.noise_rmse, unit, device)
    return chosen if score.rmse < 1e4 * chosen.factor else scale(score.rmse, unit, device)


def _score_row(name: str, use: str, score: RecordScore | Score, common: Scale) -> tuple[str, ...]:
    error, noise = (show_in(value, None, common, 3).value for value in (score.rmse, score.noise_rmse))
    shares = ratio_text(score.error_over_noise), percent_text(score.error_over_signal)
    return (name, use, str(score.n), error, noise, *shares)


def percent_text(share: float) -> str:
    """A fraction of the signal as "4.3 %"."""
    return f"{significant(100 * share, 2 if share < 0.1 else 3)} %"


def combination_sentences(fit: Fit) -> tuple[str, ...]:
    """What is determined of the parameters that are not determined one by one."""
    sentences = [_combination(c, fit) for c in fit.combinations]
    covered = {name for c in fit.combinations for name in c.names}
    alone = [e.name for e in fit.estimates if "undetermined" in e.flags and e.name not in covered]
    if alone:
        sentences.append(f"the records say nothing about {listed(alone)}")
    return tuple(sentences)


def _combination(c: Combination, fit: Fit) -> str:
    effects = {name.rpartition(".")[0] for name in c.names}
    same = len(effects) == 1
    names = [name.rpartition(".")[2] if same else name for name in c.names]
    owner = f" of {next(iter(effects))}" if same else ""
    if not c.logarithmic:
        value = show(c.value, c.deviation, c.unit, fit.model.device)
        return f"only {_sum(c.weights, names)}{owner} is determined; its value is {value}; the rest is not"
    largest = max(c.weights, key=abs)
    powers = [w / largest for w in c.weights]
    parts = zip(powers, names, strict=True)
    product = " · ".join(name if abs(p - 1) < 5e-3 else f"{name}^{p:.2f}" for p, name in parts)
    percent = significant(100 * c.deviation / abs(largest), 2)
    value = significant(math.exp(min(max(c.value / largest, -700.0), 700.0)), 4)
    known = f"its value is {value} in SI, to {percent} %"
    return f"only the product {product}{owner} is determined; {known}; the rest is not"


def _sum(weights: tuple[float, ...], names: list[str]) -> str:
    text = ""
    for weight, name in zip(weights, names, strict=True):
        sign = ("−" if weight < 0 else "") if not text else (" − " if weight < 0 else " + ")
        factor = f"{abs(weight):.2f}"
        text += sign + (name if factor == "1.00" else f"{factor}·{name}")
    return text


def listed(names: Sequence[str]) -> str:
    """ "a, b and c"."""
    return names[0] if len(names) == 1 else f"{', '.join(names[:-1])} and {names[-1]}"


def start_sheet(fit: Fit) -> Sheet:
    """Every start of the fit: where it began and ended, in units of the noise floor."""
    best = min((s.end for s in fit.starts if math.isfinite(s.end)), default=math.inf)
    rows = tuple(
        (str(i), significant(s.begin, 3), significant(s.end, 5), str(s.steps), "yes" if s.converged else "no")
        for i, s in enumerate(fit.starts, 1)
    )
    marks: tuple[Mark, ...] = tuple("" if s.end <= best * (1 + _SAME_MINIMUM) else "quiet" for s in fit.starts)
    columns = (
        Column("start", True), Column("error/noise at start", True), Column("at end", True), Column("steps", True),
        Column("converged"),
    )  # fmt: skip
    return Sheet("Starts", columns, rows, marks, start_sentence(fit) + ".")


def start_sentence(fit: Fit) -> str:
    """How many starts reach the best minimum."""
    ends = [s.end for s in fit.starts]
    finite = [end for end in ends if math.isfinite(end)]
    if not finite:
        return "no start could be solved"
    if len(ends) == 1:
        if fit.fitted.error_over_noise <= GOOD:  # no minimum is deeper than the noise
            return "there was one start, and it reaches the noise floor"
        return "there was one start, so nothing shows that its minimum is the deepest"
    best = min(finite)
    same = sum(end <= best * (1 + _SAME_MINIMUM) for end in finite)
    text = f"{same} of {len(ends)} starts reach the same minimum"
    other = sorted(end for end in finite if end > best * (1 + _SAME_MINIMUM))
    if other:
        text += f"; the next best ends at {significant(other[0], 3)} instead of {significant(best, 3)}"
    failed = len(ends) - len(finite)
    return text + (f"; {failed} could not be solved" if failed else "")


def correlation_sentences(fit: Fit) -> tuple[str, ...]:
    """Pairs of determined parameters that the records hardly tell apart, the closest first, and how many there are
    beside these."""
    deviation = [math.sqrt(max(v, 0.0)) for v in fit.covariance.diagonal()] if len(fit.free) else []
    known = [k for k, i in enumerate(fit.free) if fit.estimates[i].standard_error is not None and deviation[k] > 0]
    pairs = []
    for a, i in enumerate(known):
        for j in known[a + 1 :]:
            r = float(fit.covariance[i, j]) / (deviation[i] * deviation[j])
            if abs(r) > _CORRELATED:
                pairs.append((r, fit.estimates[fit.free[i]].name, fit.estimates[fit.free[j]].name))
    words = {True: "both can grow together", False: "one can grow as the other shrinks"}
    pairs.sort(key=lambda pair: -abs(pair[0]))
    told = [f"{a} and {b} are poorly told apart: {words[r > 0]} (correlation {r:.2f})" for r, a, b in pairs]
    more = len(told) - _MOST_PAIRS
    if more > 1:
        told[_MOST_PAIRS:] = [f"so are {more} more pairs, with correlations beyond ±{_CORRELATED}"]
    return tuple(told)
