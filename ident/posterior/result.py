"""A posterior as a value: what sampling found, and whether it may be called final."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from html import escape
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from ..fit.access import position
from ..fit.result import NEGLIGIBLE_STEP, Fit
from .chain_file import read_chain
from .convergence import judge
from .density import Density, make_density
from .evidence import Evidence, log_evidence
from .laplace import inverse
from .misfit import Doubts, misfit, too_narrow
from .priors import Prior
from .sampler import Progress, Sampled, sample, spread_evenly

if TYPE_CHECKING:
    from pandas import DataFrame

DECIDES = 1.25
"""The prior decides a parameter whose standard deviation grows by more than this where all priors are twice as broad:
records that determine it leave the ratio at 1, records that say nothing give 2."""
_EVIDENCE_DRAWS = 4000  # of the chain, to which the evidence may fit a mixture
_WORTH_A_WORD = 1.05  # times too narrow; intervals are printed with two digits


class Marginal(NamedTuple):
    """One parameter, SI: mean, sd, 5 %, 50 % and 95 % quantiles, Monte-Carlo `error` of the mean, `ess`, R̂;
    `contraction`, 1 − (posterior/prior variance), in p or ln p as its `prior` is written; `widens`, by how much it
    would were all priors twice as broad."""

    prior: Prior
    mean: float
    deviation: float
    low: float
    median: float
    high: float
    error: float
    ess: float
    rhat: float
    contraction: float
    widens: float

    @property
    def prior_decides(self) -> bool:
        return self.widens > DECIDES


@dataclass(frozen=True, eq=False)
class Posterior:
    """Draws of a fit's parameters; `reasons` why it is not final (none if it is), `notes` that do not stand against it.

    **Arguments:** `density`, in whose coordinates the draws are; `marginals` in the order of the unknowns;
    `evidence`; `sampled`, chain and convergence.
    """

    fit: Fit
    density: Density
    sampled: Sampled
    marginals: tuple[Marginal, ...]
    evidence: Evidence
    reasons: tuple[str, ...]
    notes: tuple[str, ...]

    @property
    def trusted(self) -> bool:
        return not self.reasons

    def draws(self, count: int) -> np.ndarray:
        """(count, m) parameter values SI, all parameters of the model."""
        return self.density.values(self.sampled.draws(count))

    def __getitem__(self, name: str) -> Marginal:
        """One parameter: `posterior["quality"].mean`, `.low`, `.high`."""
        return self.marginals[position([one.prior.name for one in self.marginals], name)]

    def to_dataframe(self) -> DataFrame:
        """Mean, standard deviation, 90 % interval (SI) and who decides it, per parameter, as a pandas table."""
        from pandas import DataFrame

        rows = [(m.mean, m.deviation, m.low, m.high, m.prior_decides) for m in self.marginals]
        names = [m.prior.name for m in self.marginals]
        return DataFrame(rows, columns=["mean", "sd", "low", "high", "prior decides"], index=names)

    def __repr__(self) -> str:
        state = "" if self.trusted else f", not final: {self.reasons[0]}"
        return f"<Posterior of {len(self.marginals)} parameters, {self.sampled.convergence.ess.min():.0f} draws{state}>"

    def _repr_html_(self) -> str:
        return f"<p>{escape(repr(self))}</p>{self.to_dataframe().to_html()}"


def draw_posterior(
    fit: Fit,
    chain_file: Path | None = None,
    *,
    seed: int = 0,
    seconds: float | None = None,
    resume: bool = False,
    report: Callable[[Progress], None] = lambda _: None,
    doubts: Doubts = lambda _: (),
) -> Posterior:
    """As `diagnosis.judged.sample`; `doubts`: of the model, with any of which no interval is final."""
    density = make_density(fit)
    key = run_key(density, seed)
    sampled = sample(density, chain_file, key, resume=resume, seed=seed, seconds=seconds, report=report)
    return judge_posterior(fit, sampled, doubts(fit))


def judge_posterior(fit: Fit, sampled: Sampled, doubts: Sequence[str]) -> Posterior:
    """The posterior that a chain describes, and whether it is final: not with `doubts` of the model."""
    density = sampled.laplace.density
    evidence = log_evidence(sampled.laplace, sampled.draws(_EVIDENCE_DRAWS))
    wrong = misfit(density)
    reasons = [*sampled.convergence.reasons]
    if sampled.stopped and reasons:
        reasons.insert(0, sampled.stopped)
    if wrong.reasons:
        first = wrong.reasons[0] + (f", and {len(wrong.reasons) - 1} more" if len(wrong.reasons) > 1 else "")
        asked = "" if doubts else "; ask `ident diagnose` what is missing"
        reasons.append(f"the model does not describe the records: {first}{asked}")
    reasons += doubts
    if not fit.converged:
        reasons.append("the fit had not converged")
    if not fit.step_error < NEGLIGIBLE_STEP:
        reasons.append(f"the solver's step moves the readings by {fit.step_error:.2f} noise floors")
    narrow, notes = too_narrow(density), []
    if narrow > _WORTH_A_WORD:
        notes.append(
            f"The noise is coloured, which the likelihood takes into account: taken as white, intervals would be up to "
            f"{narrow:.1f} times too narrow."
        )
    marginals = _marginals(density, sampled)
    decided = [m.prior.name for m in marginals if m.prior_decides]
    if decided:
        notes.append(f"The prior decides {', '.join(decided)}: the records say less of it than was assumed beforehand.")
    return Posterior(fit, density, sampled, marginals, evidence, tuple(reasons), tuple(notes))


def _marginals(density: Density, sampled: Sampled) -> tuple[Marginal, ...]:
    kept, judged = sampled.kept, sampled.convergence
    flat = density.values(kept.reshape(-1, density.size))[:, list(density.static.free)]
    widens = _widening(density)
    found = []
    for k, prior in enumerate(density.priors):
        values = flat[:, k]
        low, median, high = np.quantile(values, [0.05, 0.5, 0.95])
        variable = values if prior.kind == "normal" else np.log(values)
        ratio = float(variable.std()) / prior.deviation
        spread, ess = float(values.std()), float(judged.ess[k])
        found.append(
            Marginal(
                prior, float(values.mean()), spread, float(low), float(median), float(high), spread / np.sqrt(ess), ess,
                float(judged.rhat[k]), 1.0 - ratio**2, float(widens[k]),
            )
        )  # fmt: skip
    return tuple(found)


def _widening(density: Density) -> np.ndarray:
    """(p,) ratio of standard deviations at the peak, priors twice as broad over priors as they are."""
    told, bend = density.linearise().matrix, density.prior_slope()[1]
    as_is, broader = (np.diag(inverse(told + share * bend)) for share in (1.0, 0.25))
    return np.sqrt(broader / as_is)


def chain_draws(fit: Fit, chain_file: Path, count: int) -> np.ndarray | None:
    """(k, m) parameter values SI, at most `count`, of the chain that `draw_posterior` left of this fit; None where
    there is none, or it is another's, or its draws cannot be trusted yet.

    **Raises:** UserError if the chain is damaged.
    """
    if not chain_file.is_file():
        return None
    density, chain = make_density(fit), read_chain(chain_file)
    if chain.key.rpartition("-")[0] != run_key(density, 0).rpartition("-")[0]:
        return None
    judged = judge(chain.positions, chain.taus[:-1])
    if judged.reasons:
        return None
    return density.framed(chain.frame).values(spread_evenly(chain.positions[:, judged.burned :], count))


def run_key(density: Density, seed: int) -> str:
    """What a chain belongs to: a checksum of the records as measured, their noise, the model and its priors; then the
    seed."""
    told = hashlib.sha256()
    for record in density.records:
        for array in (record.time, record.drive, record.response):
            told.update(np.ascontiguousarray(array, float).tobytes())
        told.update(repr((record.name, record.noise, record.start, record.load, record.skip)).encode())
        # What is as usual is not told, so that the key of a chain stays what it was.
        if record.differs:
            told.update(repr(record.own).encode())
        if record.floats:
            told.update(b"its zero is fitted")
        if record.edge is not None:
            told.update(f"held {record.edge!r}".encode())
        if record.measures != "displacement":
            told.update(record.measures.encode())
        if record.masked is not None:
            told.update(np.ascontiguousarray(record.masked).tobytes())
    model = density.fit.model
    if model.form != "oscillator":
        told.update(model.form.encode())
    settings = [(e.name, sorted(e.settings.items())) for e in model.effects]
    priors = [tuple(p) for p in density.priors]
    template = np.asarray(density.data.template, float)
    told.update(json.dumps([repr(model.device), settings, priors, density.fit.sigma], default=str).encode())
    told.update(template.tobytes())
    return f"{told.hexdigest()}-{seed}"
