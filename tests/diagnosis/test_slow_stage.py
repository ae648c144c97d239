"""Where inertia hardly matters, score statistics are replaced by refits, and the hysteresis is found all the same."""

from __future__ import annotations

import numpy as np
import pytest

from ident.campaign.campaign import Campaign
from ident.campaign.device import Oscillator
from ident.campaign.record import Channel, NoiseFloor, Trace
from ident.diagnosis.diagnose import diagnose
from ident.diagnosis.linearised.regression import prepare
from ident.effects.registry import built_in
from ident.fit import fit
from ident.model import Model

RIVALS = ("prandtl-ishlinskii", "viscoelastic-support", "drive-lag")
STEP, NOISE = 2e-4, 2e-3


def play(voltage: np.ndarray, width: float) -> np.ndarray:
    """Output of a play of half width `width`, by its definition."""
    out, p = np.empty_like(voltage), 0.0
    for k, v in enumerate(voltage):
        p = min(max(p, v - width), v + width)
        out[k] = p
    return out


def record(hertz: float, seed: int, holdout: bool = False) -> Trace:
    """A growing triangle on a stage that follows its voltage at once, but for fifteen plays."""
    time = STEP * np.arange(1500)
    voltage = 10 * time / time[-1] * 2 / np.pi * np.arcsin(np.sin(2 * np.pi * hertz * time))
    lag = np.mean([voltage - play(voltage, width) for width in np.linspace(0.3, 5, 15)], axis=0)
    noise = NOISE * np.random.default_rng(seed).standard_normal(len(time))
    floor, channel = NoiseFloor(NOISE, method="given"), Channel("V", 1.0)
    response = 0.1 * (voltage - 0.3 * lag) + noise
    return Trace(f"{hertz:g}Hz.csv", time, voltage, response, channel, channel, floor, "rest", holdout)


@pytest.fixture(scope="module")
def campaign() -> Campaign:
    return Campaign("stage", (record(20, 1), record(80, 2), record(40, 3, holdout=True)), Oscillator())


def test_the_fit_bends_and_the_bench_knows(campaign: Campaign) -> None:
    bent = fit(Model(campaign.device), campaign)
    assert bent.fitted.error_over_noise > 5
    assert not prepare(bent).credible


def test_the_hysteresis_is_named_first_and_carries_over(campaign: Campaign) -> None:
    found = diagnose(fit(Model(campaign.device), campaign), {name: built_in()[name] for name in RIVALS}).discovery
    assert found.steps[0].added == "prandtl-ishlinskii"
    assert found.start.holdout is not None and found.final.holdout is not None
    assert found.final.holdout.error_over_noise < 0.5 * found.start.holdout.error_over_noise
