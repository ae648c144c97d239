"""What an instrument reads off a motion that is known."""

from __future__ import annotations

import numpy as np
import pytest

from ident.campaign import Channel, NoiseFloor
from ident.campaign.record import Sweep
from ident.response.passage import lay_passages

_VOLT = Channel("V", 1.0)


@pytest.mark.parametrize("averaging", [0.0, 0.28, 0.29, 0.58])  # 0.29 · 100 is 28.999999999999996
def test_a_motion_like_the_drive_reads_one_at_every_point(averaging: float) -> None:
    f = np.linspace(100.0, 102.0, 6)
    sweep = Sweep(
        "a.csv", f, np.ones(6), np.ones(6), np.zeros(6), np.ones(6, bool), "fundamental", _VOLT, Channel("m", 1.0),
        NoiseFloor(1e-3), dwell=np.ones(6), swept=True, averaging=averaging, fast=True,
    )  # fmt: skip
    passages = lay_passages((sweep,), 64)
    motion = np.concatenate([lane.voltage[::2] for lane in passages.tape.lanes])
    reading, _ = passages.read(motion)
    np.testing.assert_allclose(reading, 1.0, atol=1e-4)
