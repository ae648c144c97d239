"""Posterior, comparison and attribution, with the library's word on the model: nothing is final of one that lacks an
effect which the records see."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path

import numpy as np

from ..campaign.read import PathLike
from ..effects.registry import registry
from ..fit import Fit
from ..posterior import attribution, result
from ..posterior import compare as comparison
from ..posterior.sampler import Progress
from ..threads import one_thread
from .ranking.missing import missing


def doubts(fit: Fit) -> tuple[str, ...]:
    """What the effects of the library, and the user's own, say against the model of a fit."""
    return missing(fit, registry(fit.campaign.effect_files))


@one_thread
def sample(
    fit: Fit,
    chain_file: PathLike | None = None,
    *,
    seed: int = 0,
    seconds: float | None = None,
    resume: bool = False,
    report: Callable[[Progress], None] = lambda _: None,
) -> result.Posterior:
    """Sample the posterior of a fit until it can be trusted, or until the `seconds` are over.

    **Arguments:** `chain_file`: keeps the chain, with which `resume` goes on; `seed`: of the walkers and their moves;
    `report`: called with the progress.

    **Raises:** UserError if there is no chain to go on with, or it is another's.
    """
    kept = None if chain_file is None else Path(chain_file)
    return result.draw_posterior(fit, kept, seed=seed, seconds=seconds, resume=resume, report=report, doubts=doubts)


@one_thread
def compare(fits: Sequence[tuple[str, Fit]] | Mapping[str, Fit]) -> comparison.Comparison:
    """Weigh named fits by evidence, by what they predict of left-out stretches, by held-out records.

    **Raises:** UserError if there are fewer than two, or they are not of the same records with the same noise.
    """
    return comparison.compare(list(fits.items()) if isinstance(fits, Mapping) else fits, doubts)


@one_thread
def attribute(
    fit: Fit, draws: np.ndarray | None = None, *, chain_file: PathLike | None = None, seed: int = 0
) -> attribution.Attribution:
    """Attribute the offset of every periodic record of a fit.

    **Arguments:** `draws` (k, m) parameter values SI of the posterior; if not given, those of `chain_file` where it
    holds a finished chain of this fit, and else drawn by importance sampling.

    **Raises:** UserError if there is no effect, or no periodic record, to attribute to.
    """
    if draws is None and chain_file is not None:
        draws = result.chain_draws(fit, Path(chain_file), attribution.DRAWS)
    return attribution.attribute(fit, draws, doubts=doubts, seed=seed)
