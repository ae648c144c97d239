"""A noise floor that is only a bound falls to what the model leaves; one that is known, or sure, stays."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import ident
from ident.campaign.record import VAGUE

STEP, SIGMA = 1 / 2048, 0.05


def _shaken(seed: int) -> dict[str, np.ndarray]:
    """White noise up to the last frequency on a structure of 34 Hz, its acceleration read with white noise."""
    time, rng = np.arange(2048) * STEP, np.random.default_rng(seed)
    drive = 4 * rng.normal(size=len(time))
    push, w = lambda t: np.interp(t, time, drive) / 3.2, 2 * np.pi * 34.0
    law = lambda t, y: [y[1], push(t) - w * w * y[0] - w / 45 * y[1]]
    z, v = solve_ivp(law, (0, time[-1]), [0, 0], t_eval=time, rtol=1e-8, atol=1e-10, max_step=STEP).y
    acceleration = push(time) - w * w * z - w / 45 * v
    return {"time": time, "drive": drive, "response": acceleration + rng.normal(0, SIGMA, len(time))}


def _campaign(**told: object) -> dict[str, object]:
    device = {"kind": "oscillator", "output": "m/s^2", "input": "N"}
    return {"device": device, "record": [{"data": _shaken(k), "start": "rest", **told} for k in (1, 2)]}


def test_a_floor_beside_a_broadband_drive_falls_to_the_noise():
    campaign = ident.read_campaign(_campaign())
    assert all(r.noise.relative_error >= VAGUE and r.noise.sigma > 2 * SIGMA for r in campaign.traces)
    found = ident.fit(campaign)
    assert [r.noise.sigma for r in found.campaign.traces] == pytest.approx([SIGMA, SIGMA], rel=0.1)
    assert found.fitted.error_over_noise == pytest.approx(1.0, abs=0.1)
    assert all("what the model leaves" in r.noise.method for r in found.campaign.traces)


def test_a_floor_that_was_given_stays():
    found = ident.fit(_campaign(noise="0.2 m/s^2"))
    assert [r.noise.sigma for r in found.campaign.traces] == [0.2, 0.2]
    assert found.fitted.error_over_noise == pytest.approx(SIGMA / 0.2, rel=0.1)
