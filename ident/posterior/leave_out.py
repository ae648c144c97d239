"""How well a model predicts what it has not seen: leave one block of time out, and held-out records.

    elpd = Σ_blocks ln p(block | all other blocks), by Pareto-smoothed importance sampling over the posterior's draws

Source: A. Vehtari, A. Gelman, J. Gabry, Statistics and Computing 27 (2017) 1413.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from .block_likelihood import block_likelihood
from .density import Density
from .log_sum import log_sum
from .pareto import TRUSTED, smooth


class LeaveOut(NamedTuple):
    """`by_block` (blocks,) ln predictive densities, `elpd` their sum with standard `error`; `bad`, blocks whose Pareto
    k̂ is above 0.7."""

    by_block: np.ndarray
    elpd: float
    error: float
    bad: int


def leave_out(density: Density, draws: np.ndarray) -> LeaveOut:
    """From draws (k, p) of the posterior in the density's coordinates."""
    logs = block_likelihood(density, draws).log_likelihood
    found, bad = [], 0
    for column in logs.T:
        weights = smooth(-column)
        found.append(float(log_sum(weights.log_weights + column)))
        bad += not weights.shape <= TRUSTED
    by_block = np.array(found)
    return LeaveOut(by_block, float(by_block.sum()), float(np.sqrt(len(by_block) * np.var(by_block, ddof=1))), bad)


def heldout_score(density: Density, draws: np.ndarray) -> float | None:
    """ln predictive density of the held-out records per sample, in nats; None if there are none.

    ln (1/k) Σ p(record | draw): parameters as uncertain as they are, initial states integrated out.
    """
    records = density.fit.campaign.heldout
    if not records:
        return None
    outside = density.over(records)
    _, logs = outside.parts(draws)
    total = float(np.sum(log_sum(logs, axis=0) - np.log(len(draws))))
    return total / sum(noise.count for noise in outside.noises)
