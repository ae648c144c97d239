"""A mean that moves: a drift where it follows time, physics where it follows the square of the vibration."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from ident.campaign import Channel, NoiseFloor, Trace
from ident.campaign.quality.judge import judge

STEP, COUNT = 1 / 12000, 2400


def _record(quadratic: float, ramp: float) -> Trace:
    """From rest at resonance, still ringing up at its end; `ramp` of the largest response is added."""
    time = np.arange(COUNT) * STEP
    w, drive = 2 * np.pi * 480, np.sin(2 * np.pi * 480 * time)
    law = lambda t, y: [y[1], w * w * (0.005 * np.sin(w * t) - y[0] - quadratic * y[0] ** 2) - w / 300 * y[1]]
    z = solve_ivp(law, (0, time[-1]), [0, 0], t_eval=time, rtol=1e-8, atol=1e-10).y[0]
    z = z + ramp * np.max(np.abs(z)) * time / time[-1]
    noise = np.random.default_rng(1).normal(0, 0.003, COUNT)
    return Trace("a.csv", time, drive, z + noise, Channel("V", 1), Channel("V", 1), NoiseFloor(0.003, method="given"))


@pytest.mark.parametrize(
    "quadratic, ramp, told", [(0.0, 0.0, False), (0.2, 0.0, False), (0.0, 0.3, True), (0.2, 0.6, True)]
)
def test_a_drift_follows_time(quadratic, ramp, told):
    record = _record(quadratic, ramp)
    assert any("drifts" in remark for remark in judge(record).remarks) is told
    if quadratic and not ramp:
        assert abs(judge(record).drift) > 0.1 * judge(record).size  # which is why it must be told apart
