"""A start from which the motion has no bound ends a search without an answer, and never in a traceback."""

from __future__ import annotations

import warnings

import numpy as np

from ident.campaign.campaign import Campaign
from ident.campaign.device import Oscillator
from ident.campaign.record import Channel, NoiseFloor, Trace
from ident.effects.registry import built_in
from ident.fit.minimise import minimise
from ident.fit.solve import How
from ident.model import Model

VALUES = np.array([100.0, 20.0, 4e4])  # frequency, quality, gain


def driven() -> Campaign:
    """A linear oscillator at its resonance."""
    time = np.linspace(0, 0.3, 1500)
    drive = np.sin(2 * np.pi * 100 * time)
    rise = 1 - np.exp(-np.pi * 100 * time / 20)
    response = -VALUES[2] * 20 / (2 * np.pi * 100) ** 2 * rise * np.cos(2 * np.pi * 100 * time)
    channel = Channel("V", 1.0)
    record = Trace("a.csv", time, drive, response, channel, channel, NoiseFloor(0.02), "rest")
    return Campaign("escape", (record,), Oscillator())


def test_a_softening_spring_lets_go():
    campaign = driven()
    softening = Model(campaign.device) + built_in()["cubic-stiffness"]()
    escapes, stays = np.append(VALUES, [-1e9, 0.0]), np.append(VALUES, [0.0, 0.0])
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        lost = minimise(softening, campaign, How(most=5), initial=escapes)
        found = minimise(softening, campaign, How(most=20), initial=[escapes, stays])
    assert not lost.best.cost < 1e12
    assert found.best.cost < 1e3
    assert abs(found.values[0] / VALUES[0] - 1) < 0.01
