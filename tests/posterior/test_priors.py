"""Priors: proper densities, in values and in coordinates, chosen in the order that their docstring says."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.integrate import quad

from ident.campaign.campaign import Prior as ToldPrior
from ident.effects.effect import Expected
from ident.model import ModelParameter
from ident.posterior.priors import Prior, choose_prior, log_prior, table

KINDS = {
    "normal": Prior("a", "N", "normal", 3.0, 2.0, -math.inf, math.inf, ""),
    "normal, positive": Prior("a", "N", "normal", 1.0, 2.0, 0.0, math.inf, ""),
    "normal, far outside": Prior("a", "N", "normal", -30.0, 2.0, 0.0, math.inf, ""),
    "normal, between": Prior("a", "N", "normal", 1.0, 2.0, 0.5, 5.0, ""),
    "log-normal": Prior("a", "N", "log-normal", 3.0, 0.7, 0.0, math.inf, ""),
    "log-normal, between": Prior("a", "N", "log-normal", 3.0, 0.7, 1.0, 20.0, ""),
    "log-uniform": Prior("a", "N", "log-uniform", 1.0, 0.0, 0.01, 100.0, ""),
}


@pytest.mark.parametrize("kind", KINDS)
def test_mass_is_one_in_values_and_in_coordinates(kind):
    prior = KINDS[kind]
    low, high = max(prior.lower, -60.0), min(prior.upper, 200.0)
    in_values = quad(lambda v: float(prior.density(np.array([v]))[0]), low, high, limit=400, points=[0.05, 1.0, 3.0])[0]
    assert in_values == pytest.approx(1.0, abs=1e-4)

    arrays, lower, upper = table([prior]), np.array([prior.lower]), np.array([prior.upper])
    grid = np.linspace(-60, 60, 240_001)
    density = np.exp(log_prior(arrays, grid[:, None], lower, upper)[:, 0])
    assert np.trapezoid(np.nan_to_num(density), grid) == pytest.approx(1.0, abs=1e-4)


def parameter(**changed) -> ModelParameter:
    return ModelParameter("gas.c", "N s/m", 1.0, **changed)


def choose(p: ModelParameter, lower=-math.inf, upper=math.inf, told=None) -> Prior:
    return choose_prior(p, lower, upper, told, 7.0, 2.0)


def test_what_is_known_decides_in_order():
    known = Expected(4.0, 0.5, "a book")
    told = choose(parameter(expected=known), told=ToldPrior(1.0, 0.1))
    assert (told.kind, told.centre, told.spread, told.source) == ("normal", 1.0, 0.1, "the campaign")
    assert choose(parameter(expected=known))[2:5] == ("normal", 4.0, 0.5)
    assert choose(parameter(expected=known, positive=True), 0.0)[2:5] == ("log-normal", 4.0, 0.5)
    assert choose(parameter(positive=True), 0.1, 10.0).kind == "log-uniform"
    assert choose(parameter())[2:5] == ("normal", 0.0, 7.0)
    assert choose(parameter(positive=True), 0.0)[2:4] == ("log-normal", 2.0)
