"""Which mechanism explains the zero-point offset, and how sure that is.

At draws of the posterior every subset of the model's effects is switched on and the rest off (amplitudes zero), each
record is simulated, and each measure of the offset is shared among the effects by its Shapley value. The second harmonic
is shared as a vector: a share is the part of it that points along the whole.
"""

from __future__ import annotations

from typing import Literal, NamedTuple

import numpy as np

from ..campaign.record import Trace
from ..errors import UserError
from ..fit.result import Fit
from .density import Density, make_density
from .evidence import log_evidence
from .misfit import misfit
from .offset import MEASURES, Measure, Offset, fold, offsets
from .pareto import TRUSTED
from .shapley import shapley, subsets

Verdict = Literal["one mechanism", "several", "undecided"]
MINOR = 0.1
"""Share below which a mechanism is called minor: it modulates the offset (a weaker drive moves less) without causing it."""
_DRAWS = 128
_MOST = 8  # mechanisms; 256 subsets of each draw
_SEEN = 3.0  # standard errors from zero beyond which a record has an offset at all, and beyond which a model misses it
_EVEN = (0, 1, 3, 4)  # positions of the measures that are zero for symmetric physics; they decide


class Share(NamedTuple):
    """What one mechanism explains of a measure: median `share` of the whole, 5 % and 95 % quantiles, and `alone`, what
    it explains when it is the only one."""

    mechanism: str
    share: float
    low: float
    high: float
    alone: float


class Attributed(NamedTuple):
    """One measure of one record: `offset`, data and model; `shares`, none where there is nothing to share; `counts`,
    whether it decides: the record has that offset, and the model explains it."""

    offset: Offset
    shares: tuple[Share, ...]
    counts: bool

    @property
    def measure(self) -> Measure:
        return self.offset.measure


class RecordAttribution(NamedTuple):
    """All measures of one record."""

    record: Trace
    measures: tuple[Attributed, ...]


class Attribution(NamedTuple):
    """`verdict`, in `words`; `reasons` why it is undecided although shares could be computed; `mechanisms`; `leading`,
    those that explain something."""

    verdict: Verdict
    words: str
    reasons: tuple[str, ...]
    mechanisms: tuple[str, ...]
    leading: tuple[str, ...]
    records: tuple[RecordAttribution, ...]


def attribute(fit: Fit, draws: np.ndarray | None = None, *, seed: int = 0) -> Attribution:
    """Attribute the offset of every periodic record of a fit.

    **Arguments:** `draws` (k, m) parameter values SI of the posterior; drawn by importance sampling if not given.

    **Raises:** UserError if there is no effect, or no periodic record, to attribute to.
    """
    names = fit.model.names
    if not names:
        what = "the model has no effect, and a linear platform has no offset"
        raise UserError(what, do="fit with the effects that may explain it, or let `ident discover` find them")
    if len(names) > _MOST:
        raise UserError(f"{len(names)} effects have too many subsets to try", do=f"attribute to at most {_MOST}")
    periodic = tuple(r for r in fit.campaign.traces if fold(r, r.response[None]) is not None)
    if not periodic:
        what = "no record has a periodic drive on which an offset could be folded"
        raise UserError(what, do="measure a sine for two periods or more")
    density = make_density(fit)
    reasons: list[str] = []
    if draws is None:
        evidence = log_evidence(density, seed=seed)
        density, draws = evidence.density, evidence.density.values(evidence.resampled(_DRAWS, seed))
        if not evidence.trusted:
            k = evidence.shape
            reasons.append(f"the posterior is not described by one peak (Pareto k {k:.2f} > {TRUSTED}): sample it first")
    wrong = misfit(density)
    if wrong.reasons:
        reasons.append(f"the model does not describe the records ({wrong.reasons[0]}): ask `ident diagnose`")
    records = _share(fit, make_density(fit, periodic), periodic, draws)
    return _judge(names, records, reasons)


def _share(fit: Fit, density: Density, records: tuple[Trace, ...], draws: np.ndarray) -> tuple[RecordAttribution, ...]:
    names, chosen = fit.model.names, subsets(len(fit.model.names))
    switched = np.concatenate([_with_only(fit, draws, {names[i] for i in s}) for s in chosen])
    readings = density.readings(switched)
    at_fit = dict(zip((r.name for r in fit.campaign.traces), fit.readings, strict=True))
    found = []
    for record, reading in zip(records, readings, strict=True):
        folded = fold(record, reading)
        told = offsets(record, at_fit[record.name])
        assert folded is not None and told is not None  # periodic records were chosen
        by_subset = lambda a: dict(zip(chosen, np.split(a, len(chosen)), strict=True))
        second = by_subset(folded.second)
        measures = []
        for i, offset in enumerate(told):
            values = second if i == 1 else by_subset(folded.measures[:, i : i + 1])
            shares = () if offset.measure.unit == "rad" else _shares(names, values, offset)
            explained = abs(offset.difference.value) <= _SEEN * offset.difference.error
            seen = abs(offset.data.value) > _SEEN * offset.data.error
            measures.append(Attributed(offset, shares, bool(i in _EVEN and shares and seen and explained)))
        found.append(RecordAttribution(record, tuple(measures)))
    return tuple(found)


def _with_only(fit: Fit, draws: np.ndarray, on: set[str]) -> np.ndarray:
    """The draws with the amplitudes of all other effects zero."""
    off = [i for i, p in enumerate(fit.model.parameters) if p.kind == "amplitude" and p.effect not in on]
    changed = draws.copy()
    changed[:, off] = 0.0
    return changed


def _shares(names: tuple[str, ...], values: dict[tuple[int, ...], np.ndarray], offset: Offset) -> tuple[Share, ...]:
    """Shares of v(all) − v(none), values (k, d) being scalars or vectors; none where that is lost in the noise."""
    count = len(names)
    whole = values[tuple(range(count))] - values[()]
    size = np.sum(whole**2, axis=1)
    if not np.all(np.isfinite(size)) or np.median(np.sqrt(size)) <= _SEEN * offset.data.error:
        return ()
    along = lambda part: np.sum(part * whole, axis=1) / size
    found = []
    for i, part in enumerate(shapley(values, count)):
        share = along(part)
        if not np.all(np.isfinite(share)):
            return ()
        low, middle, high = np.quantile(share, [0.05, 0.5, 0.95])
        alone = float(np.median(along(values[(i,)] - values[()])))
        found.append(Share(names[i], float(middle), float(low), float(high), alone))
    return tuple(found)


def _judge(names: tuple[str, ...], records: tuple[RecordAttribution, ...], reasons: list[str]) -> Attribution:
    counted = [m for r in records for m in r.measures if m.counts]
    missed = [
        (r.record.name, m.measure.name)
        for r in records
        for i, m in enumerate(r.measures)
        if i in _EVEN and abs(m.offset.difference.value) > _SEEN * m.offset.difference.error
        and abs(m.offset.data.value) > _SEEN * m.offset.data.error
    ]  # fmt: skip
    if not counted and not missed:
        words = "No record has an offset that stands out of its noise: there is nothing to attribute."
        return Attribution("undecided", words, tuple(reasons), names, (), records)
    if len(missed) > len(counted):
        reasons.append(f"the model misses the {missed[0][1]} of {missed[0][0]} by more than three standard errors")
    large, unsure = [], []
    for name in names:
        own = [s for m in counted for s in m.shares if s.mechanism == name]
        if any(s.low > MINOR for s in own):
            large.append(name)
        elif not all(-MINOR < s.low and s.high < MINOR for s in own):
            unsure.append(name)
    if reasons:
        words = f"Undecided: {'; '.join(reasons)}."
        return Attribution("undecided", words, tuple(reasons), names, tuple(large), records)
    if len(large) == 1 and not unsure:
        others = [s for m in counted for s in m.shares if s.mechanism != large[0]]
        most = max((max(abs(s.low), abs(s.high)) for s in others), default=0.0)
        words = f"{large[0]} explains the offset; every other mechanism explains less than {max(100 * most, 1):.0f} %."
        return Attribution("one mechanism", words, (), names, tuple(large), records)
    if len(large) > 1:
        words = f"Several mechanisms explain the offset: {', '.join(large)} each explain more than {100 * MINOR:.0f} % of a measure."
        return Attribution("several", words, (), names, tuple(large), records)
    words = f"Undecided: the records do not tell how much {', '.join(unsure or names)} explains."
    return Attribution("undecided", words, (), names, tuple(large), records)
