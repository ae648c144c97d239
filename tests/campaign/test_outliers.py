"""Outliers are found, and what devices do is none: no false ones on clean records, kinks, steps and ring-downs."""

from __future__ import annotations

import numpy as np
import pytest

from ident.campaign import read_campaign
from ident.campaign.noise.floor import noise_floor
from ident.campaign.quality.outliers import find_outliers, without_outliers
from tests.end_to_end.user import DATA

CLEAN = ("platform_clean", "platform_317hz", "platform_fe", "mystery_platform", "oscillator")


@pytest.mark.parametrize("name", CLEAN)
def test_clean_records_have_none_and_added_ones_are_found_exactly(name):
    random = np.random.default_rng(5)
    for record in read_campaign(DATA / name).traces:
        assert record.outliers == ()
        places = np.sort(random.choice(np.arange(20, len(record.time) - 20, 9), 4, replace=False))
        spoiled = record.response.copy()
        spoiled[places] += 60 * record.noise.sigma * random.choice([-1, 1], 4)
        found = find_outliers(spoiled)
        np.testing.assert_array_equal(found, places)
        repaired = without_outliers(spoiled, found)
        assert np.max(np.abs(repaired - record.response)) < 8 * record.noise.sigma
        before, after = (
            noise_floor(record.time, record.drive, x, record.period).sigma for x in (record.response, repaired)
        )
        assert abs(after / before - 1) < 0.1


def test_kinks_steps_and_decays_are_physics():
    index = np.arange(2000)
    noise = 1e-4 * np.random.default_rng(2).standard_normal(2000)
    motions = {
        "kink": np.abs(np.sin(index / 40)),
        "one kink": np.maximum(index - 1000.0, 0.0) / 1000,
        "step": (index > 1000) * 1.0,
        "decay": np.exp(-index / 100) * np.sin(index / 3),
        "square": np.sign(np.sin(index / 60)),
        "pulse of three": (np.abs(index - 1000) < 2) * 1.0,
    }
    for name, motion in motions.items():
        assert find_outliers(motion + noise).size == 0, name


def test_many_are_no_accident():
    signal = np.sin(np.arange(1000) / 20)
    signal[::10] = 0.0
    assert find_outliers(signal).size == 0
