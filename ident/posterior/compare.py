"""Weighing models of the same records: by evidence, by what they predict of left-out stretches, by held-out records.

    P(model | records) = Z/Σ Z, every model as likely as any other beforehand

Sources: H. Jeffreys, Theory of Probability, 1961, app. B, and R. E. Kass, A. E. Raftery, J. Am. Stat. Assoc. 90 (1995)
773 (words for odds).
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Literal, NamedTuple

import numpy as np

from ..campaign.apart import as_it_came
from ..campaign.record import Trace
from ..errors import UserError
from ..fit.result import Fit
from .evidence import Evidence, log_evidence
from .leave_out import LeaveOut, heldout_score, leave_out
from .log_sum import log_sum
from .misfit import Doubts, Misfit, misfit
from .pareto import TRUSTED

DECISIVE = 5.0
"""Difference of ln Z from which a model is called decided: odds of 150 to 1, "very strong" (Kass & Raftery 1995)."""
_WORDS = ((1.0, "hardly worth a mention"), (3.0, "positive"), (5.0, "strong"), (np.inf, "very strong"))
_DRAWS = 500  # of a posterior, by which left-out stretches are predicted


class Weighed(NamedTuple):
    """One model: its fit, evidence, `probability` among those compared (NaN where none has evidence), left-out and
    held-out scores, and what it fails to describe."""

    name: str
    fit: Fit
    evidence: Evidence
    probability: float
    left_out: LeaveOut
    heldout: float | None
    misfit: Misfit


class Comparison(NamedTuple):
    """Models in the order given; the position of the `best`; `lead`, ln of its odds over the next (NaN where one of the
    two has no evidence), with `error`; and whether the best one describes the records, which a verdict among models
    does not say."""

    models: tuple[Weighed, ...]
    best: int
    lead: float
    error: float
    verdict: Literal["decided", "undecided"]
    words: str
    describes: bool


def compare(fits: Sequence[tuple[str, Fit]], doubts: Doubts = lambda _: ()) -> Comparison:
    """Weigh named fits.

    **Arguments:** `doubts`: of the best model.

    **Raises:** UserError if there are fewer than two, or they are not of the same records with the same noise.
    """
    if len(fits) < 2:
        raise UserError("one run has nothing to be compared with", do="name two runs or more")
    _same_records(fits)
    evidences = [log_evidence(fit) for _, fit in fits]
    values = np.array([e.value if e.found else -np.inf for e in evidences])
    shares = np.exp(values - log_sum(values)) if np.any(np.isfinite(values)) else np.full(len(values), np.nan)
    models = []
    for (name, fit), evidence, share in zip(fits, evidences, shares, strict=True):
        draws = evidence.resampled(_DRAWS)
        density = evidence.density
        models.append(
            Weighed(
                name, fit, evidence, float(share), leave_out(density, draws), heldout_score(density, draws[::5]),
                misfit(density),
            )
        )  # fmt: skip
    return _judge(tuple(models), doubts)


_ROUNDING = 1e-9  # of the largest reading


def _same_records(fits: Sequence[tuple[str, Fit]]) -> None:
    first_name, first = fits[0]
    for name, fit in fits[1:]:
        mine, theirs = first.campaign.fitted, fit.campaign.fitted
        same = len(mine) == len(theirs) and all(
            a.skip == b.skip and a.start == b.start and _read_alike(a, b) for a, b in zip(mine, theirs, strict=True)
        )
        if not same:
            what = f"its fitted records are not those of {first_name}, so evidences mean nothing beside each other"
            raise UserError(what, where=name, do="fit both models to one campaign")
        if any(a.noise != b.noise for a, b in zip(mine, theirs, strict=True)) or fit.sigma != first.sigma:
            what = f"it stands on other noise floors than {first_name}"
            raise UserError(what, where=name, do="fit both with one --sigma, known or scaled")


def _read_alike(one: Trace, other: Trace) -> bool:
    """Whether two traces are the same measurement, read in the same way: a zero of their own that is fitted with every
    model is a number that both have, whatever it is beside each."""
    fitted = lambda trace: trace.floats and trace.own and trace.own[0]
    if fitted(one) != fitted(other):
        return False
    if not one.floats:
        return bool(np.array_equal(one.response, other.response))
    first, second = as_it_came(one).response, as_it_came(other).response
    return bool(np.allclose(first, second, rtol=0.0, atol=_ROUNDING * float(np.max(np.abs(first)))))


def _judge(models: tuple[Weighed, ...], doubts: Doubts) -> Comparison:
    order = sorted(range(len(models)), key=lambda i: -models[i].evidence.value if models[i].evidence.found else np.inf)
    first, second = models[order[0]], models[order[1]]
    both = first.evidence.found and second.evidence.found
    lead = first.evidence.value - second.evidence.value if both else np.nan
    error = float(np.hypot(first.evidence.error, second.evidence.error))
    parts = _how_far(first, second, lead, error) if both else []
    without = [m.name for m in models if not m.evidence.found]
    if without:
        parts.append(
            f"No evidence was found of {', '.join(without)}: the records are impossible at every draw near the fit, so "
            "nothing is known of its odds."
        )
    unsure = [m.name for m in (first, second) if m.evidence.found and not m.evidence.trusted]
    decided = lead - 2 * error > DECISIVE and not unsure and not without
    if unsure:
        parts.append(f"The evidence of {', '.join(unsure)} is not to be trusted (Pareto k above {TRUSTED}).")
    if lead <= DECISIVE:
        parts.append("The records cannot separate them.")
    wrong = (*first.misfit.reasons, *doubts(first.fit))
    if wrong:
        parts.append(
            f"Even the best does not describe the records ({wrong[0]}): the right model is not among "
            "them; `ident diagnose` says what is missing."
        )
    verdict = "decided" if decided else "undecided"
    return Comparison(models, order[0], lead, error, verdict, " ".join(parts), not wrong)


def _how_far(first: Weighed, second: Weighed, lead: float, error: float) -> list[str]:
    """How far one model is ahead of another: by evidence, left-out stretches and held-out records."""
    strength = next(word for limit, word in _WORDS if lead < limit)
    odds = f"{np.exp(lead):.2g}" if lead < 13.8 else "more than a million"
    difference = first.left_out.by_block - second.left_out.by_block
    elpd, elpd_error = float(difference.sum()), float(np.sqrt(len(difference) * np.var(difference, ddof=1)))
    whom = "it" if elpd >= 0 else "the other"
    parts = [
        f"ln Z of [{_effects(first)}] exceeds that of [{_effects(second)}] by {lead:.1f} ± {error:.1f}: "
        f"odds of {odds} to 1, {strength}.",
        f"Left-out stretches of time prefer {whom} by {abs(elpd):.1f} ± {elpd_error:.1f} nats.",
    ]
    if first.fit.holdout is not None and second.fit.holdout is not None:
        ratios = (m.fit.holdout.error_over_noise for m in (first, second) if m.fit.holdout is not None)
        parts.append("Held-out error over noise: {:.3g} against {:.3g}.".format(*ratios))
    return parts


def _effects(model: Weighed) -> str:
    return " + ".join(["linear", *model.fit.model.names])
