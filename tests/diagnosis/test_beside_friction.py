"""What a model with friction absorbs, along its motion, is what its own derivatives say."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from ident.campaign.campaign import Campaign
from ident.campaign.device import Oscillator
from ident.campaign.record import Channel, NoiseFloor, Trace
from ident.diagnosis.linearised.regression import prepare
from ident.effects.registry import built_in
from ident.fit import fit
from ident.model import Model
from ident.response import Equation, respond
from ident.response.lane import lane_of
from ident.response.tape import lay

STEP, COUNT, NOISE = 0.02, 400, 1e-4
ONE, VOLT = Channel("m", 1.0), Channel("V", 1.0)


@pytest.mark.parametrize("share", [0.03, 0.1])
@pytest.mark.parametrize("turn", [3e-5, 2e-2])
def test_two_ways_to_the_same_derivatives_agree(share, turn):
    """Cosines of the angles between them were 0.97 and 0.70: no slope at a point tells how far a friction turns between
    two points, and what the model could not absorb was left to other effects."""
    device = Oscillator("m", "V")
    model = Model(device) + built_in()["coulomb-friction"](device)
    friction = share * (2 * np.pi) ** 2 * float(Equation(model).constants[0])
    values, t = np.array([1.0, 60.0, 1.0, friction, turn]), STEP * np.arange(COUNT)
    drive = 8.0 * np.sin(2 * np.pi * 0.8 * t)
    record = Trace("a", t, drive, 1e-9 + 0 * t, VOLT, ONE, NoiseFloor(NOISE), "rest")
    moved = respond(Equation(model), lay([lane_of(record, 10)], [10]), values, np.zeros((1, 2))).readings
    noisy = moved + NOISE * np.random.default_rng(1).standard_normal(COUNT)
    fitted = fit(model, Campaign("a", (replace(record, response=noisy),), device), initial=values)
    assert fitted.fitted.error_over_noise < 1.1
    regression, free = prepare(fitted), list(fitted.solved.static.free)
    for along, direction in zip(regression.known, regression.directions, strict=True):
        own = int(np.flatnonzero(direction)[0])
        if own in free and not model.parameters[own].name.endswith("velocity"):  # of which the records say nothing
            exact = fitted.solved.found.by_x[free.index(own)][: len(along)]
            cosine = abs(along @ exact) / np.linalg.norm(along) / np.linalg.norm(exact)
            assert cosine > 0.998, model.parameters[own].name
