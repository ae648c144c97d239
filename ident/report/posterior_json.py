"""A posterior as the numbers of `posterior.json`, format 1."""

from __future__ import annotations

from typing import Any

from ..campaign.device import Device
from ..posterior.evidence import Evidence
from ..posterior.result import Marginal, Posterior
from .words.quantity import display_unit, finite


def posterior_dict(posterior: Posterior) -> dict[str, Any]:
    """A posterior as plain numbers; values SI, of an oscillator in the units of its columns."""
    judged, device = posterior.sampled.convergence, posterior.fit.model.device
    ensembles, steps, walkers, _ = posterior.sampled.kept.shape
    return {
        "format": 1,
        "trusted": posterior.trusted,
        "reasons": list(posterior.reasons),
        "notes": list(posterior.notes),
        "draws": ensembles * steps * walkers,
        "ess_min": float(judged.ess.min()),
        "rhat_max": float(judged.rhat.max()),
        "autocorrelation_time": float(judged.tau.max()),
        "ensembles": ensembles,
        "walkers": walkers,
        "steps": steps,
        "burn_in": judged.burned,
        "log_evidence": evidence_dict(posterior.evidence),
        "parameters": [_parameter(m, device) for m in posterior.marginals],
    }


def evidence_dict(evidence: Evidence) -> dict[str, Any]:
    """An evidence as plain numbers."""
    return {
        "value": finite(evidence.value),
        "error": evidence.error,
        "method": evidence.method,
        "pareto_k": finite(evidence.shape),
        "efficiency": evidence.efficiency,
        "laplace": evidence.laplace,
        "trusted": evidence.trusted,
    }


def _parameter(marginal: Marginal, device: Device) -> dict[str, Any]:
    prior = marginal.prior
    limits = [finite(prior.lower), finite(prior.upper)]
    return {
        "name": prior.name,
        "mean": marginal.mean,
        "sd": marginal.deviation,
        "median": marginal.median,
        "interval90": [marginal.low, marginal.high],
        "unit": display_unit(prior.unit, device, plain=True),
        "prior_decides": marginal.prior_decides,
        "contraction": marginal.contraction,
        "monte_carlo_error": marginal.error,
        "ess": marginal.ess,
        "rhat": marginal.rhat,
        "prior": {
            "kind": prior.kind, "centre": prior.centre, "spread": prior.spread, "limits": limits,
            "source": prior.source,
        },
    }  # fmt: skip
