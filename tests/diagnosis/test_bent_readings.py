"""A sensor that saturates is looked for by a refit: what it reads is not the motion."""

from __future__ import annotations

import pytest

from ident.campaign.campaign import Campaign
from ident.campaign.device import Oscillator
from ident.diagnosis.ranking.look import first_look
from ident.effects.registry import built_in
from ident.fit import fit
from ident.model import Model
from tests.fit.test_bent_sensor import bent_sweep

_RIVALS = ("sensor-nonlinearity", "cubic-damping", "cubic-stiffness", "voltage-stiffness")


@pytest.mark.parametrize("phase", [True, False], ids=["phase", "amplitude"])
@pytest.mark.parametrize(("fold", "steep"), [(1.0, 2.0), (4.0, 0.9)], ids=["saturates", "folds"])
def test_a_sensor_that_saturates_is_seen_before_the_damping_that_it_resembles(
    fold: float, steep: float, phase: bool
) -> None:
    device = Oscillator(output="m")
    sweeps = tuple(bent_sweep(level, fold, steep, phase, k) for k, level in enumerate((1 / 3, 2 / 3, 1.0)))
    start = fit(Model(device), Campaign("", sweeps, device))
    look = first_look(start, {name: built_in()[name] for name in _RIVALS}, lambda _: None)
    assert look.candidates[0].name == "sensor-nonlinearity"
    assert look.candidates[0].predicted_gain > 0.99
