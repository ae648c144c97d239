"""The posterior of steady records: their initial states move with the parameters, and none is integrated out."""

from __future__ import annotations

import numpy as np
import pytest

from experiments.recovery.steady import draw
from ident.fit import fit
from ident.fit.problem import Unknowns, evaluate
from ident.posterior.density import make_density


@pytest.fixture(scope="module")
def density():
    campaign, model, _ = draw(0, "bouc-wen")
    return make_density(fit(model, campaign))


def test_every_point_begins_on_its_own_orbit(density):
    assert len(density.data.steady) == 3
    x = 3 * np.random.default_rng(0).normal(size=(20, density.size))
    _, likelihood = density.parts(x)
    costs = []
    for one in x:
        left = evaluate(density.static, density.data, Unknowns(one, density.starts)).residuals
        costs.append([float(left[own] @ left[own]) for own in density.data.tape.slices])
    change = -0.5 * (np.array(costs) - costs[0])  # the noise floors are known
    assert np.allclose(likelihood - likelihood[0], change, rtol=0, atol=1e-3)


def test_a_mirrored_device_is_simulated_on_the_mirrored_orbit(density):
    turned = density.mirrored()
    values = density.values(np.zeros((1, density.size)))
    for plain, other in zip(density.readings(values), turned.readings(values), strict=True):
        assert np.max(np.abs(plain + other)) < 1e-4 * np.max(np.abs(plain))
