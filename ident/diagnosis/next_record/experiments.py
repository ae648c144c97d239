"""What to measure next: the record that would tell apart the effects between which the present ones do not choose.

Each rival, fitted to the present records, predicts every proposed record; what counts is the part d of the difference
of two predictions that neither rival can absorb by moving its parameters as far as the present records let it,

    Δχ² = min over δ₁, δ₂ of |d + J₁ δ₁ − J₂ δ₂|²/σ² + δ₁ᵀ F₁ δ₁ + δ₂ᵀ F₂ δ₂,

F the Fisher information of the present records. The proposals are ranked by the smallest Δχ² of any pair.

Source: G. Buzzi-Ferraris, P. Forzatti, 1983, Chem. Eng. Sci. 38, 225 (discrimination with the uncertainty of both
predictions); W. G. Hunter, A. M. Reiner, 1965, Technometrics 7, 307.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations
from typing import NamedTuple

import numpy as np

from ...campaign.campaign import Campaign
from ...campaign.record import Channel, NoiseFloor, Trace
from ...effects.registry import Registry
from ...fit import Fit
from ...fit.assemble import assemble, begin_at
from ...fit.problem import evaluate
from ...response import Tape, divided
from ..evidence.equivalences import equivalence
from ..linearised.regression import Regression
from ..ranking.confirm import accept, confirm
from ..ranking.weigh import Candidate
from .waveforms import Waveform, limits_of, proposals

SEPARATED = 10.0  # expected Δχ² from which a record is worth taking
_MOST_RIVALS = 4  # effects that tie, the best first: each is refitted
_PROPOSED = 3  # records, the best first
_STEPS = 80  # of the solver per period of the resonance: 3e-7 rad of phase error per radian
_NEAR = 0.03  # relative distance within which two frequencies are one proposal


@dataclass(frozen=True, eq=False)
class NextExperiment:
    """A record to take.

    **Arguments:** `record`: in words; `groups`: the effects between which it chooses, those that it leaves tied
    together; `expected_delta_chi2`: the smallest χ² by which any two that it tells apart would then differ;
    `waveform`: its drive, or how far a decay begins; `time` (n,), s, its samples.
    """

    record: str
    groups: tuple[tuple[str, ...], ...]
    expected_delta_chi2: float
    waveform: Waveform
    time: np.ndarray

    @property
    def separates(self) -> tuple[str, ...]:
        """Every effect that it tells from another."""
        return tuple(name for group in self.groups for name in group)

    @property
    def voltage(self) -> np.ndarray:
        """Drive (n,), V."""
        return self.waveform.voltage(self.time)


class _Prediction(NamedTuple):
    """What a rival says of the proposals: readings (k, n), their derivatives (k, p, n), last those by initial states
    that would have to be fitted, and the present information (p, p)."""

    readings: np.ndarray
    slopes: np.ndarray
    information: np.ndarray


def next_experiments(regression: Regression, tied: Sequence[Candidate], library: Registry) -> list[NextExperiment]:
    """Refit the model with each of the tied effects (at most four) and rank what would tell them apart."""
    rivals = {c.name: accept(confirm(regression, library[c.name], c), regression.fit) for c in tied[:_MOST_RIVALS]}
    return rank_experiments(rivals)


def rank_experiments(rivals: Mapping[str, Fit]) -> list[NextExperiment]:
    """The proposals that tell apart most, best first; none if no proposal tells any two of the rivals apart.

    `rivals`: effect name → the fit of its model to the present records.
    """
    pairs = [pair for pair in combinations(rivals, 2) if not _never_apart(*pair, rivals)]
    if not pairs:
        return []
    first = next(iter(rivals.values()))
    resonance = 1.0 / first.scales.period
    limits = limits_of(first.campaign, resonance)
    waves = proposals(limits, resonance)
    if not waves:  # such records are too short, or too coarse, for a sine anywhere near the resonance
        return []
    laid_out = _lay_out(list(rivals.values()), waves, limits.time)
    predictions = {name: _predict(fitted, waves, *laid_out) for name, fitted in rivals.items()}
    noise = _noise(first, [p.readings for p in predictions.values()])
    table = np.array(
        [[_gain(predictions[a], predictions[b], k, noise[k]) for a, b in pairs] for k in range(len(waves))]
    )  # (k, pairs)
    open_pairs = np.nanmax(np.where(np.isfinite(table), table, 0.0), axis=0) > SEPARATED
    if not np.any(open_pairs):
        return []
    worth = np.where(np.all(np.isfinite(table), axis=1), table[:, open_pairs].min(axis=1), -np.inf)
    if worth.max() <= SEPARATED:  # no record tells all of them apart: take the one that tells most pairs apart
        worth = np.where(np.isfinite(worth), (table > SEPARATED).sum(axis=1) + 0.0, -np.inf)
    chosen: list[NextExperiment] = []
    for k in np.argsort(-worth):
        apart = [pair for pair, gain in zip(pairs, table[k], strict=True) if gain > SEPARATED]
        if not apart or not np.isfinite(worth[k]) or any(_alike(waves[k], c.waveform) for c in chosen):
            continue
        least = float(min(gain for gain in table[k] if gain > SEPARATED))
        chosen.append(NextExperiment(waves[k].words, grouped(rivals, apart), least, waves[k], limits.time))
        if len(chosen) == _PROPOSED:
            break
    return chosen


def grouped(names: Iterable[str], apart: Sequence[tuple[str, str]]) -> tuple[tuple[str, ...], ...]:
    """The names that some pair tells apart, each in the first group with none of which it is such a pair."""
    groups: list[list[str]] = []
    for name in names:
        others = {other for pair in apart if name in pair for other in pair}
        group = next((g for g in groups if not others & set(g)), None)
        if others and group is None:
            groups.append([name])
        elif others and group is not None:
            group.append(name)
    return tuple(tuple(group) for group in groups)


def _never_apart(one: str, other: str, rivals: Mapping[str, Fit]) -> bool:
    """Whether physics forbids any record to tell two effects apart: what differs is how their laws are approximated."""
    effects = rivals[one].model.effects, rivals[other].model.effects
    if any(len(own) != 1 for own in effects):
        return False
    known = equivalence(*(type(own[0]) for own in effects))
    return known is not None and known.linear_exact


def _alike(one: Waveform, other: Waveform) -> bool:
    return one.kind == other.kind and abs(one.hertz / other.hertz - 1) < _NEAR and one.begun == other.begun


def _lay_out(rivals: Sequence[Fit], waves: Sequence[Waveform], time: np.ndarray) -> tuple[Campaign, Tape]:
    """The proposals as records from rest, or let go, laid out once for all rivals."""
    first = rivals[0]
    channel, floor = Channel("", 1.0), NoiseFloor(1.0)
    records = tuple(
        Trace(
            w.words, time, w.voltage(time), np.full(len(time), w.begun), channel, channel, floor,
            "unknown" if w.begun else "rest", measures=w.measures,
        )
        for w in waves
    )  # fmt: skip
    resonance = 1.0 / first.scales.period
    finest = max(_STEPS, *(fitted.model.steps_per_period for fitted in rivals))
    substeps = max(math.ceil(finest * resonance * (time[1] - time[0])), 1)
    return Campaign("proposals", records, first.campaign.device), divided(records, [substeps] * len(records))


def _predict(fitted: Fit, waves: Sequence[Waveform], campaign: Campaign, tape: Tape) -> _Prediction:
    """Readings of a fitted model and their derivatives by its fitted parameters."""
    static, data = assemble(fitted.model, campaign, campaign.fitted, tape, fitted.values)
    begun = np.zeros_like(data.start_scale)
    omega = 2 * np.pi / fitted.scales.period
    begun[:, 0] = [wave.begun / omega**record.order for wave, record in zip(waves, campaign.fitted, strict=True)]
    found = evaluate(static, data, begin_at(data, static, begun))
    readings = np.stack([found.readings[own] for own in tape.slices])
    by_all = np.concatenate([found.by_x / data.scale[:, None], found.by_start])
    slopes = np.stack([by_all[:, own] for own in tape.slices])
    doubt = max(fitted.fitted.error_over_noise, 1.0)  # a model that does not reach the noise floor knows less
    p = len(found.by_x)
    information = np.zeros((len(by_all), len(by_all)))
    information[:p, :p] = fitted.linear.jacobian.T @ fitted.linear.jacobian / doubt**2
    return _Prediction(readings, slopes, information)


def _noise(fitted: Fit, readings: Sequence[np.ndarray]) -> np.ndarray:
    """Noise floor to expect of each proposal, (k,) m: that of the present records, growing with the signal if theirs
    does.

    With fewer than three records nobody knows; then it is taken to grow with the signal and never to shrink.
    """
    records = fitted.campaign.fitted
    sigma = np.log([r.noise.sigma for r in records])
    size = np.log([float(np.std(r.response[r.skip :])) or r.noise.sigma for r in records])
    expected = np.log(np.maximum(np.mean([np.std(r, axis=1) for r in readings], axis=0), 1e-300))
    known = len(records) >= 3 and np.ptp(size) > 0.7
    slope = float(np.clip(np.polyfit(size, sigma, 1)[0], 0.0, 1.0)) if known else 1.0
    change = slope * (expected - float(np.median(size)))
    floor = float(np.median(sigma)) + (change if known else np.maximum(change, 0.0))
    return np.exp(floor) * max(fitted.fitted.error_over_noise, 1.0)


def _gain(one: _Prediction, other: _Prediction, k: int, noise: float) -> float:
    """Expected Δχ² between two rivals from proposal k; NaN if either has no finite prediction."""
    difference = (one.readings[k] - other.readings[k]) / noise
    slopes = np.concatenate([one.slopes[k], -other.slopes[k]]) / noise
    if not (np.all(np.isfinite(difference)) and np.max(np.abs(difference)) < 1e6 and np.all(np.isfinite(slopes))):
        return float("nan")
    p = len(one.information)
    with np.errstate(over="ignore"):  # a proposal on which a rival's motion is not sure at all
        gram = slopes @ slopes.T
    gram[:p, :p] += one.information
    gram[p:, p:] += other.information
    along = slopes @ difference
    if not np.all(np.isfinite(gram)):
        return float("nan")
    size = np.sqrt(np.maximum(np.diag(gram), 1e-300))
    absorbed, _, _, _ = np.linalg.lstsq(gram / np.outer(size, size), along / size, rcond=1e-12)
    return max(float(difference @ difference - absorbed @ (along / size)), 0.0)
