"""A free decay has no drive to come late to."""

from __future__ import annotations

import numpy as np

from ident.campaign.campaign import Campaign
from ident.campaign.device import Oscillator
from ident.campaign.record import Channel, NoiseFloor, Trace
from ident.diagnosis.faulty.faults import common_delay
from ident.diagnosis.faulty.nuisance import nuisances
from ident.diagnosis.linearised.regression import prepare
from ident.diagnosis.where.locate import locate
from ident.diagnosis.where.words import summary
from ident.fit import fit
from ident.model import Model
from ident.report.figures.where import where_figure


def decay(size: float) -> Trace:
    """A pendulum that loses speed: no linear decay fits it."""
    t, one, noise = np.arange(600) / 50.0, Channel("m", 1.0), np.random.default_rng(1).normal(size=600)
    response = size / (1 + 0.2 * t) * np.cos(2 * np.pi * (2.0 * t - 0.3 * size**2 * np.exp(-t))) + 0.005 * noise
    return Trace("a.csv", t, np.zeros(600), response, one, one, NoiseFloor(0.005), "unknown")


def test_no_decay_is_late():
    """Read late it lost its loud beginning, and with it the misfit: a delay was suspected and no physics named."""
    campaign = Campaign("decays", (decay(0.9), decay(0.5)), Oscillator())
    assert common_delay(fit(Model(Oscillator()), campaign, initial=np.array([2.0, 20.0, 0.0]))) is None
    kinds = [(one.kind, one.unit) for one in nuisances(decay(0.9), decay(0.5).response)]
    assert ("delay", "samples") not in kinds and len(kinds) == 3


def test_what_a_decay_leaves_is_not_compared_with_a_drive_that_is_not_there():
    fitted = fit(Model(Oscillator()), Campaign("decays", (decay(0.9),), Oscillator()))
    where = locate(prepare(fitted))
    assert where.drive is None and where.fails
    assert "has a colour of its own. The misfit sits" in summary(where)
    titles = [text.get_text() for text in where_figure(where).texts]
    assert "At which velocity?" in titles and "Does it follow the drive?" not in titles
