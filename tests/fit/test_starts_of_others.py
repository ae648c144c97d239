"""A record that the parameters have not seen and that begins in motion: its start is found from its beginning on."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from ident.campaign import Trace
from ident.campaign.device import Oscillator
from ident.campaign.record import Channel, NoiseFloor
from ident.effects.registry import built_in
from ident.fit.reading import read
from ident.model import Model

HERTZ, QUALITY, SOFTER = 10.0, 2000.0, 0.02
OMEGA = 2 * np.pi * HERTZ


def _record(begun: tuple[float, float], noise: float) -> Trace:
    """Of a softening oscillator of high quality, which rings on from before the record."""
    push = lambda t: 1.5 * np.sin(OMEGA * 0.97 * t) + 1.5 * np.sin(OMEGA * 0.985 * t + 1.0)
    law = lambda t, y: (y[1], push(t) - OMEGA / QUALITY * y[1] - OMEGA**2 * (y[0] - SOFTER * y[0] ** 3))
    time = np.arange(6000) / 160.0
    z = solve_ivp(law, (0, time[-1]), begun, t_eval=time, rtol=1e-9, atol=1e-11).y[0]
    read = z + noise * np.random.default_rng(4).standard_normal(len(time))
    unit = Channel("m", 1.0)
    return Trace("a.csv", time, push(time), read, Channel("m/s^2", 1.0), unit, NoiseFloor(noise), start="unknown")


@pytest.mark.parametrize("begun", [(3.0, 20.0), (1.0, -150.0)])
@pytest.mark.parametrize("noise", [0.03, 0.1])
def test_a_start_that_is_turns_away_at_the_end_is_found(begun, noise):
    """From what the first samples say of it one step for the whole record led to 1.2 to 73 noise floors."""
    record, device = _record(begun, noise), Oscillator("m", "m/s^2")
    model = Model(device) + built_in()["cubic-stiffness"](device)
    (told,) = read(model, np.array([HERTZ, QUALITY, 1.0, -SOFTER * OMEGA**2, 0.0]), [record])
    assert np.sqrt(np.mean((record.response - told) ** 2)) < 1.05 * noise
