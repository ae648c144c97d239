"""Mains hum: lines that stand out of what a model leaves."""

from __future__ import annotations

import numpy as np
import pytest

from ident.campaign.noise.hum import standing


@pytest.mark.parametrize("seed", range(4))
def test_of_two_mains_lines_that_a_short_record_does_not_tell_apart_none_is_hum(seed):
    """100 and 120 Hz in 26 ms: noise alone gave each up to an eighth of its power, which the other took away."""
    rate = 2 * np.pi / 230e3
    left = np.random.default_rng(seed).standard_normal(6000)
    assert standing(left, [hz * rate for hz in (100.0, 120.0, 150.0, 180.0)]) == [0.0] * 4
    hum = np.sin(50.0 * 10 * rate * np.arange(6000))
    powers = standing(left + 0.5 * hum, [hz * 10 * rate for hz in (50.0, 60.0, 100.0, 120.0)])
    assert powers[0] == pytest.approx(0.125, rel=0.2) and powers[1:] == [0.0] * 3
