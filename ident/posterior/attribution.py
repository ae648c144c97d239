"""Which mechanism explains the zero-point offset, and how sure that is.

An offset is what symmetric physics has none of: turn its drive round, and its motion turns round with it, also while it
settles. So every record is simulated twice, driven as it was and by the drive turned round, and of each measure that is
taken of the offset which the odd part of the two does not show:

    m(z₊) − m((z₊ − z₋)/2)

A start transient, which may be a thousand times as large, is then no offset. At draws of the posterior every subset of
the model's effects is switched on and the rest off (amplitudes zero), and each measure is shared among the effects by
its Shapley value. The second harmonic is shared as a vector: a share is the part of it that points along the whole.
What an effect with several amplitudes explains is shared among these in the same way, all other effects staying on.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Literal, NamedTuple

import numpy as np

from ..campaign.record import Trace
from ..errors import UserError
from ..fit.result import Fit
from .density import Density, make_density
from .evidence import log_evidence
from .misfit import Doubts, misfit
from .offset import EVEN, Folded, Measure, Measured, Offset, fold, offsets
from .pareto import TRUSTED
from .shapley import shapley, subsets

Verdict = Literal["one mechanism", "several", "undecided"]
Switched = dict[tuple[int, ...], Folded]  # by the mechanisms that are on
MINOR = 0.1
"""Share below which what a mechanism makes by itself is called minor."""
MODULATES = 0.25
"""Shapley share up to which a mechanism that makes nothing by itself only modulates what others make: a drive weakened
by a tenth changes an offset, which goes with the square of the motion, by a fifth."""
DRAWS = 128
"""Of the posterior."""
_SOME = 4  # every so many of them are enough where shares hardly differ from draw to draw
_NARROW = 0.1
"""Width of a 90 % interval of a share up to which those tell its ends to a hundredth: a quantile of 32 draws is known
to 0.37 standard deviations."""
_WEIGHED = 512  # importance draws of which they are chosen
_MOST = 8  # mechanisms; 256 subsets of each draw
_SEEN = 3.0  # standard errors from zero beyond which a record has an offset at all, and beyond which a model misses it
_BIASED = 0.1  # mean of a drive over its rms, from which a reader may take what it does for an offset


class Share(NamedTuple):
    """What one mechanism explains of a measure: median `share` of the whole, 5 % and 95 % quantiles, and `alone`, what
    it explains when it is the only one."""

    mechanism: str
    share: float
    low: float
    high: float
    alone: float

    @property
    def innocent(self) -> bool:
        """Whether it surely makes no offset by itself and hardly changes that of others."""
        return abs(self.alone) < MINOR and self.low > -MODULATES and self.high < MODULATES

    @property
    def guilty(self) -> bool:
        """Whether it surely makes part of the offset, by itself or together with others."""
        return self.low > (MINOR if abs(self.alone) >= MINOR else MODULATES)


class Attributed(NamedTuple):
    """One measure of one record: `offset`, data and model; `beyond`, what of the data symmetric physics has none of;
    `shares`, none where there is nothing to share; `seen`, whether the record has that offset; `explained`, whether the
    model has it too; `counts`, whether it decides."""

    offset: Offset
    beyond: Measured
    shares: tuple[Share, ...]
    seen: bool
    explained: bool
    counts: bool

    @property
    def measure(self) -> Measure:
        return self.offset.measure


class _Parts(NamedTuple):
    """Per draw: part of each mechanism along the whole (m, k), the same alone, and the whole's square (k,); in units of
    the measure's error."""

    along: np.ndarray
    alone: np.ndarray
    size: np.ndarray

    def shares(self, names: tuple[str, ...]) -> tuple[Share, ...]:
        found = []
        for name, part, alone in zip(names, self.along / self.size, self.alone / self.size, strict=True):
            low, middle, high = np.quantile(part, [0.05, 0.5, 0.95])
            found.append(Share(name, float(middle), float(low), float(high), float(np.median(alone))))
        return tuple(found)


class RecordAttribution(NamedTuple):
    """All measures of one record."""

    record: Trace
    measures: tuple[Attributed, ...]


class Attribution(NamedTuple):
    """`verdict`, in `words`; `reasons` why it is undecided although shares could be computed; `mechanisms`; `leading`,
    those that explain something; `overall`, shares of all measures of all records that count taken together, each in
    units of its error; `within`, how the share of a leading effect divides among its own amplitudes."""

    verdict: Verdict
    words: str
    reasons: tuple[str, ...]
    mechanisms: tuple[str, ...]
    leading: tuple[str, ...]
    overall: tuple[Share, ...]
    records: tuple[RecordAttribution, ...]
    within: tuple[Share, ...] = ()

    def __repr__(self) -> str:
        shares = _each(self.overall, self.mechanisms) or "nothing shared"
        return f"<Attribution: {self.verdict}; {shares}>"


def attribute(
    fit: Fit, draws: np.ndarray | None = None, *, doubts: Doubts = lambda _: (), seed: int = 0
) -> Attribution:
    """Attribute the offset of every periodic record of a fit.

    **Arguments:** `draws` (k, m) parameter values SI of the posterior; drawn by importance sampling if not given;
    `doubts`: of the model, which make the verdict undecided; asked of what can be attributed only.

    **Raises:** UserError if there is no effect, or no periodic record, to attribute to.
    """
    names = fit.model.names
    if not names:
        what = "the model has no effect, and a linear platform has no offset"
        raise UserError(what, do="fit with the effects that may explain it, or let `ident discover` find them")
    if len(names) > _MOST:
        raise UserError(
            f"{len(names)} effects have too many subsets to try",
            do=f"leave at most {_MOST} in the model (`ident remove`)",
        )
    periodic = tuple(r for r in fit.campaign.traces if fold(r, r.response[None]) is not None)
    if not periodic:
        what = "no record has a periodic drive on which an offset could be folded"
        raise UserError(what, do="measure a sine for two periods or more")
    density = make_density(fit)
    every = density.over(periodic)
    reasons: list[str] = []
    if draws is None:
        evidence = log_evidence(density, count=_WEIGHED, seed=seed)
        density, draws = evidence.density, evidence.density.values(evidence.resampled(DRAWS, seed))
        if not evidence.trusted:
            k = evidence.shape
            reasons.append(
                f"the posterior is not described by one peak (Pareto k {k:.2f} > {TRUSTED}): sample it first"
            )
    wrong, said = misfit(density), doubts(fit)
    if wrong.reasons:
        asked = "" if said else ": ask `ident diagnose`"
        reasons.append(f"the model does not describe the records ({wrong.reasons[0]}){asked}")
    reasons += said
    records, parts = _share(fit, every, periodic, draws, {name: _amplitudes(fit, name) for name in names})
    told = _judge(names, records, _together(parts, names), reasons)
    within: tuple[Share, ...] = ()
    words = told.words
    for name in told.leading:
        own = {fit.model.parameters[i].name: [i] for i in _amplitudes(fit, name) if fit.values[i] != 0}
        if len(own) > 1:
            shares = _together(_share(fit, every, periodic, draws, own)[1], tuple(own))
            words += f" Within {name}: {_each(shares, tuple(own)).replace(f'{name}.', '')}."
            within += shares
    return told._replace(words=words, within=within)


def _together(parts: list[_Parts], names: tuple[str, ...]) -> tuple[Share, ...]:
    """Shares of all measures, each in units of its error."""
    return _Parts(*(np.sum(a, axis=0) for a in zip(*parts, strict=True))).shares(names) if parts else ()


def _amplitudes(fit: Fit, effect: str) -> list[int]:
    """Positions of the amplitudes of an effect; without them it is absent."""
    return [i for i, p in enumerate(fit.model.parameters) if p.kind == "amplitude" and p.effect == effect]


def _share(
    fit: Fit, density: Density, records: tuple[Trace, ...], draws: np.ndarray, mechanisms: dict[str, list[int]]
) -> tuple[tuple[RecordAttribution, ...], list[_Parts]]:
    """`mechanisms`: the amplitudes that switch each of them, by name; an amplitude of none of them stays on."""
    names, columns = tuple(mechanisms), list(mechanisms.values())
    at_fit = dict(zip(map(id, fit.campaign.traces), fit.readings, strict=True))  # excerpts and files may share a name
    turned = density.mirrored()
    measured = []
    for record, back in zip(records, turned.readings(np.asarray(fit.values)[None]), strict=True):
        reading = at_fit[id(record)]
        measured.append((offsets(record, reading) or (), offsets(record, (reading - back[0]) / 2) or ()))
    few = np.arange(len(draws)) % _SOME == 0
    switched = _switch((density, turned), draws[few], columns)
    told, counted = _read(names, measured, switched)
    if any(share.high - share.low > _NARROW for share in _together(counted, names)):
        rest = _switch((density, turned), draws[~few], columns)
        both = [{on: _joined(a[on], b[on]) for on in a} for a, b in zip(switched, rest, strict=True)]
        told, counted = _read(names, measured, both)
    return tuple(RecordAttribution(*pair) for pair in zip(records, told, strict=True)), counted


def _read(
    names: tuple[str, ...],
    measured: Sequence[tuple[tuple[Offset, ...], tuple[Offset, ...]]],
    switched: list[Switched],
) -> tuple[list[tuple[Attributed, ...]], list[_Parts]]:
    """All measures of every record shared, and the parts of those that count; `measured`: each record beside its model,
    and beside the odd part of that."""
    told, counted = [], []
    for (whole, odd), folded in zip(measured, switched, strict=True):
        attributed = []
        for i, (offset, symmetric) in enumerate(zip(whole, odd, strict=True)):
            values = {on: f.second if i == 1 else f.measures[:, i : i + 1] for on, f in folded.items()}
            parts = None if offset.measure.unit == "rad" else _parts(len(names), values, offset)
            seen, missed = _stands_out(symmetric.difference), _stands_out(offset.difference)
            # Of an offset of hundreds of errors a model may miss a few, and still say what makes it.
            explained = not missed or abs(offset.difference.value) < MINOR * abs(symmetric.difference.value)
            counts = i in EVEN and parts is not None and seen and explained
            shares = () if parts is None else parts.shares(names)
            beyond = symmetric.difference if i in EVEN else offset.data
            attributed.append(Attributed(offset, beyond, shares, seen, explained, counts))
            if counts and parts is not None:
                counted.append(parts)
        told.append(tuple(attributed))
    return told, counted


def _switch(both: tuple[Density, Density], draws: np.ndarray, columns: list[list[int]]) -> list[Switched]:
    """Per record the measures (k, …) with each subset of the mechanisms on, the amplitudes of the others zero; `both`:
    the records as driven, and with their drive turned round."""
    found: list[Switched] = [{} for _ in both[0].records]
    for on in subsets(len(columns)):
        changed = draws.copy()
        changed[:, [i for k, own in enumerate(columns) if k not in on for i in own]] = 0.0
        pairs = zip(*(density.readings(changed) for density in both), strict=True)
        for record, (reading, back), own in zip(both[0].records, pairs, found, strict=True):
            own[on] = _beyond_symmetry(record, reading, back)
    return found


def _beyond_symmetry(record: Trace, reading: np.ndarray, back: np.ndarray) -> Folded:
    """The measures of readings (k, n) less those of their odd part; the loop's opening, which is odd itself, as it
    is."""
    whole, odd = fold(record, reading), fold(record, (reading - back) / 2)
    assert whole is not None and odd is not None  # periodic records were chosen
    measures = whole.measures.copy()
    measures[:, EVEN] -= odd.measures[:, EVEN]
    return Folded(measures, whole.second - odd.second)


def _joined(first: Folded, second: Folded) -> Folded:
    return Folded(*(np.concatenate(pair) for pair in zip(first, second, strict=True)))


def _parts(count: int, values: dict[tuple[int, ...], np.ndarray], offset: Offset) -> _Parts | None:
    """Parts of v(all) − v(none), values (k, d) being scalars or vectors; none where that is lost in the noise."""
    error = offset.difference.error or 1.0
    values = {chosen: value / error for chosen, value in values.items()}
    whole = values[tuple(range(count))] - values[()]
    size = np.sum(whole**2, axis=1)
    if not np.all(np.isfinite(size)) or np.median(np.sqrt(size)) <= _SEEN:
        return None
    along = np.sum(shapley(values, count) * whole, axis=2)
    alone = np.array([np.sum((values[(i,)] - values[()]) * whole, axis=1) for i in range(count)])
    return _Parts(along, alone, size) if np.all(np.isfinite(along)) else None


def _judge(
    names: tuple[str, ...], records: tuple[RecordAttribution, ...], overall: tuple[Share, ...], reasons: list[str]
) -> Attribution:
    missed = [
        (r.record.name, m.measure.name)
        for r in records
        for i, m in enumerate(r.measures)
        if i in EVEN and m.seen and not m.explained
    ]
    counted = sum(m.counts for r in records for m in r.measures)
    if not counted and not missed:
        words = "No record has an offset that stands out of its noise: there is nothing to attribute."
        if any(abs(float(np.mean(r.record.drive))) > _BIASED * float(np.std(r.record.drive)) for r in records):
            words += (
                " A drive that is biased moves the mean of a motion by the spring and by symmetric physics alike: that "
                "is no offset, and a model without an effect shows by its error what the effect does to it."
            )
        return Attribution("undecided", words, tuple(reasons), names, (), overall, records)
    if len(missed) > counted:
        reasons.append(f"the model misses the {missed[0][1]} of {missed[0][0]} by more than three standard errors")
    large = tuple(s.mechanism for s in overall if s.guilty)
    unsure = [s.mechanism for s in overall if not s.guilty and not s.innocent]
    verdict: Verdict = "undecided"
    if reasons:
        words = f"Undecided: {'; '.join(reasons)}."
    elif len(large) > 1:
        verdict, words = "several", f"Several mechanisms explain the offset: {_each(overall, large)}."
    elif len(large) == 1 and not unsure:
        verdict = "one mechanism"
        others = tuple(name for name in names if name != large[0])
        beside = f"; beside it {_each(overall, others)}" if others else ""
        words = f"One mechanism explains the offset: {_each(overall, large)}{beside}."
    else:
        words = f"Undecided: the records do not tell how much {', '.join(unsure or names)} explains."
    return Attribution(verdict, words, tuple(reasons), names, large, overall, records)


def _stands_out(measured: Measured) -> bool:
    return abs(measured.value) > _SEEN * measured.error


def _each(overall: tuple[Share, ...], names: tuple[str, ...]) -> str:
    """ "residual-stress 102 % (101 … 103)"."""
    parts = []
    for share in overall:
        if share.mechanism in names:
            middle, low, high = (f"{round(100 * x) + 0:d}" for x in (share.share, share.low, share.high))
            parts.append(f"{share.mechanism} {middle} %" + ("" if low == high else f" ({low} … {high})"))
    return ", ".join(parts)
