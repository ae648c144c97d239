"""The linear side may need a constant only once an effect has its place: each node of a walk asks again."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from ident.campaign import Campaign, Trace
from ident.campaign.device import Oscillator
from ident.campaign.record import Channel, NoiseFloor
from ident.diagnosis.linearised.regression import prepare
from ident.diagnosis.search.constant import with_its_constant, without_idle_constant
from ident.effects.registry import built_in
from ident.fit import fit
from ident.fit.linear.start_model import start_model

OMEGA, DAMPING, FRICTION = 2 * np.pi * 12.0, 1.5, 2.0  # rad/s, 1/s, m/s²
LIBRARY = {name: built_in()[name] for name in ("coulomb-friction", "sensor-offset")}


def drive(t: float, size: float) -> float:
    return size * min(t / 0.2, 1.0) * np.sin(2 * np.pi * (6.0 + 5.0 * t) * t)


def record(size: float, offset: float) -> Trace:
    """An accelerometer on a spring with dry friction, driven from rest; its zero is off by a hundredth of the
    signal."""
    t = np.arange(500) / 250.0

    def acceleration(s: float, z: float, v: float) -> float:
        return drive(s, size) - DAMPING * v - OMEGA**2 * z - FRICTION * np.tanh(v / 0.005)

    found = solve_ivp(lambda s, y: (y[1], acceleration(s, *y)), (0, t[-1]), (0, 0), "LSODA", t, rtol=1e-8, atol=1e-11)
    seen = np.array([acceleration(s, *y) for s, y in zip(t, found.y.T, strict=True)])
    noise = 0.02 * np.random.default_rng(int(size)).standard_normal(len(t))
    push = np.array([drive(s, size) for s in t])
    return Trace(f"{size}.csv", t, push, seen + offset + noise, Channel("N", 1.0), Channel("m/s^2", 1.0),
                 NoiseFloor(0.02), measures="acceleration")  # fmt: skip


@pytest.mark.parametrize("offset", [0.15, 0.0])
def test_a_constant_that_a_missing_friction_hid_is_asked_for_again(offset: float) -> None:
    campaign = Campaign("", tuple(record(size, offset) for size in (6.0, 12.0)), Oscillator("m/s^2", "N"))
    assert "sensor-offset" not in start_model(campaign).names
    rubbing = fit(start_model(campaign, ("coulomb-friction",)), campaign)
    found, regression = with_its_constant(rubbing, prepare(rubbing), LIBRARY, lambda _: None)
    assert ("sensor-offset" in found.model.names) == (offset > 0)
    with_one = found if offset else fit(start_model(campaign, ("coulomb-friction", "sensor-offset")), campaign)
    for told, kept in (((), offset > 0), (("sensor-offset",), True)):  # one that is asked for stays, needed or not
        asked = replace(with_one, campaign=replace(campaign, effects=told))
        left = without_idle_constant(asked, ("coulomb-friction",), rubbing, lambda _: None)
        assert ("sensor-offset" in left.model.names) == kept
    if offset:
        assert found.value("sensor-offset.offset") == pytest.approx(offset, rel=0.05)
        assert found.fitted.error_over_noise < 0.7 * rubbing.fitted.error_over_noise
        assert with_its_constant(found, regression, LIBRARY, lambda _: None)[0] is found
