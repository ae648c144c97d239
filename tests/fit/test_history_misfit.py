"""Histories that nothing tells stay likely beside a model that misses by many noise floors."""

from __future__ import annotations

import numpy as np
import pytest

from ident.campaign.campaign import Campaign
from ident.campaign.device import Oscillator
from ident.campaign.record import Channel, NoiseFloor, Trace
from ident.effects.registry import built_in
from ident.fit.minimise import minimise
from ident.fit.solve import How
from ident.model import Model

SIGMA, STEP = 1e-4, 5e-4
PLAYS = ((0.2, 0.2), (0.5, 0.15), (0.8, 0.1))  # half width in V, weight


def stage(hertz: float, seed: int) -> Trace:
    """A stage far below its resonance: a gain with exact plays and a bend that the model lacks, cut out of a record of
    triangles that grow."""
    time = STEP * np.arange(1200)
    volts = (0.3 + 0.7 * time / time[-1]) * (2 / np.pi) * np.arcsin(np.sin(2 * np.pi * hertz * time))
    shown = 1.4 * volts + volts**2
    for width, weight in PLAYS:
        play = np.empty_like(volts)
        at = 0.0
        for i, u in enumerate(volts):
            at = min(max(at, u - width), u + width)
            play[i] = at
        shown += weight * (play - volts)
    cut = slice(400, None)
    one = Channel("V", 1.0)
    noise = SIGMA * np.random.default_rng(seed).normal(size=len(time))
    return Trace(f"{hertz:g}", time[cut] - time[400], volts[cut], (shown + noise)[cut], one, one,
                 NoiseFloor(SIGMA, (), "given", 0.0), "unknown")  # fmt: skip


@pytest.fixture(scope="module")
def campaign() -> Campaign:
    return Campaign("stage", (stage(10.0, 0), stage(25.0, 1)), Oscillator())


def test_no_history_is_many_times_the_drive(campaign: Campaign) -> None:
    model = Model(campaign.device, (built_in()["prandtl-ishlinskii"](),))
    found = minimise(
        model,
        campaign,
        How(most=60),
        initial=[np.array([300.0, 0.7, 1.4 * (600 * np.pi) ** 2, 0.3, 0.0, *np.zeros(4), 0.8])],
    )
    assert found.error > 30  # the bend
    assert np.max(np.abs(found.best.unknowns.starts[:, 2:])) < 1.5  # times the drive; 4.5 where noise alone held them
