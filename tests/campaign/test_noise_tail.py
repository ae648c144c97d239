"""A motion's tail above its drive is no colour of the noise."""

from __future__ import annotations

import numpy as np
import pytest

from experiments.free_floors import campaign, shared
from ident.campaign.noise.autoregression import ORDER_PRICE, ar_spectrum
from ident.campaign.noise.tail import beside_a_tail

COUNT = 1400
PLACE = np.arange(200, 200 + COUNT) / 200
PRICE = ORDER_PRICE * float(np.log(COUNT))
WHITE = np.ones(COUNT)


def _power(rng: np.random.Generator, *parts: np.ndarray) -> np.ndarray:
    """Of a periodogram where these powers are expected together."""
    return np.sum(parts, axis=0) * rng.exponential(size=COUNT)


@pytest.mark.parametrize("steepness", [4, 6, 10, 16])
@pytest.mark.parametrize("size", [3.0, 300.0])
def test_the_level_of_noise_beside_a_tail(steepness, size):
    rng = np.random.default_rng(51)
    levels = []
    for _ in range(20):
        found = beside_a_tail(_power(rng, WHITE, size * PLACE**-steepness), WHITE, PLACE, PRICE)
        levels.append(found.level)
        assert 0.02 < found.error < 0.1
    assert np.mean(levels) == pytest.approx(1.0, abs=0.06)


@pytest.mark.parametrize("ar", [(), (0.8,), (1.2, -0.5)], ids=str)
def test_noise_of_its_own_colour_has_no_tail(ar):
    rng = np.random.default_rng(52)
    noise = ar_spectrum(np.array(ar), 1.0, 2 * (COUNT + 200))[200:-1]
    levels = [beside_a_tail(_power(rng, noise), noise, PLACE, PRICE).level for _ in range(40)]
    assert np.mean(levels) == pytest.approx(1.0, abs=0.01) and np.min(levels) > 0.9


def test_red_noise_is_described_worse_as_white_beside_a_tail():
    rng = np.random.default_rng(53)
    red = 0.05 + ar_spectrum(np.array([0.8]), 1.0, 2 * (COUNT + 200))[200:-1]
    for _ in range(10):
        power = _power(rng, red)
        assert beside_a_tail(power, red, PLACE, PRICE).deviance < beside_a_tail(power, WHITE, PLACE, PRICE).deviance


def test_noise_below_its_tail_everywhere_is_told_too_high_and_not_too_low():
    rng = np.random.default_rng(54)
    tail = 1e4 * PLACE**-4
    assert beside_a_tail(_power(rng, tail, 0.01 * WHITE), WHITE, PLACE, PRICE).level > tail[-1]


@pytest.mark.parametrize(("seed", "name"), [(30060, "sweep"), (30066, "multisine"), (30078, "steps")])
def test_white_noise_above_a_drive_is_not_called_coloured(seed, name):
    """Each floor was 1.4 to 3.1 times too high, in a colour that the tail of the motion had bent up."""
    kind, records = campaign(seed)
    assert kind == "white"
    floors = dict(zip([record.name for record in records], shared(records), strict=True))
    true = records[0].true
    assert floors[name].ar == () and floors[name].sigma == pytest.approx(true, rel=0.1)
