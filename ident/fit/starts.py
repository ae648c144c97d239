"""Where a fit starts: the linear guess from the records, the grids of the shape parameters, and random ones on
request."""

from __future__ import annotations

import itertools
from collections.abc import Sequence

import numpy as np

from ..campaign.campaign import Campaign
from ..model import Model, ModelParameter
from .linear.curve_guess import curve_scales, guess_curves, joined_scales
from .linear.guess import DataScales, LinearGuess, data_scales, guess_linear, told_guess
from .start_scale import small_size


def first_guess(model: Model, campaign: Campaign) -> LinearGuess:
    """The linear model to start from: as the model was told, or as the fitted records say, the traces before the
    sweeps."""
    first, quality, gain = model.parameters[:3]
    start = dict(model.start)
    told = told_guess(start, [first.name, quality.name, gain.name])
    if told is not None or model.form in ("no-spring", "quasi-static"):
        return told or LinearGuess(start[first.name], start[quality.name], 0.0, float("nan"))
    held = None if quality.fitted else quality.value
    if not campaign.fitted:
        return guess_curves(campaign.fitted_sweeps, held)
    return guess_linear(campaign.fitted, model.linear.nominal_frequency, held, model.linear.mass)


def scales_of(campaign: Campaign, frequency: float) -> DataScales:
    """The largest values in the fitted records."""
    if not campaign.fitted_sweeps:
        return data_scales(campaign.fitted, frequency)
    of_curves = curve_scales(campaign.fitted_sweeps, frequency)
    return joined_scales(data_scales(campaign.fitted, frequency), of_curves) if campaign.fitted else of_curves


def base_values(model: Model, guess: LinearGuess, scales: DataScales) -> np.ndarray:
    """Starting value of every parameter of the model, SI; a positive one cannot leave zero, and starts small."""
    linear, told = model.linear, dict(model.start)
    found = {
        f"{linear.prefix}.frequency": guess.frequency,
        f"{linear.prefix}.quality": guess.quality,
        f"{linear.prefix}.{linear.gain_name}": guess.gain * linear.mass / linear.force_per_gain,
    }
    return np.array(
        [
            told.get(p.name, found.get(p.name, p.value * getattr(scales, p.scale)))
            or (small_size(p.unit, scales, linear.mass) if p.positive else 0.0)
            for p in model.parameters
        ]
    )  # fmt: skip


def starting_points(model: Model, base: np.ndarray, scales: DataScales, limit: int = 24) -> list[np.ndarray]:
    """The base start and every combination of the grids of the fitted parameters, at most `limit` of them."""
    grids = [(i, np.array(p.grid) * getattr(scales, p.scale)) for i, p in _gridded(model.parameters)]
    points = [base]
    for combination in itertools.islice(itertools.product(*(g for _, g in grids)), limit if grids else 0):
        point = base.copy()
        point[[i for i, _ in grids]] = combination
        if not np.array_equal(point, base):
            points.append(point)
    return points


def _gridded(parameters: Sequence[ModelParameter]) -> list[tuple[int, ModelParameter]]:
    return [(i, p) for i, p in enumerate(parameters) if p.grid and p.fitted]


def random_points(model: Model, base: np.ndarray, count: int, spread: float, seed: int) -> list[np.ndarray]:
    """`count` starts with every fitted parameter moved by up to ±`spread` of itself."""
    fitted = np.array([p.fitted for p in model.parameters])
    moves = np.random.default_rng(seed).uniform(1 - spread, 1 + spread, (count, len(base)))
    return [np.where(fitted, base * move, base) for move in moves]
