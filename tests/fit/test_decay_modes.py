"""Free decays with several modes: how many, and the fit of the model that they are."""

from __future__ import annotations

import numpy as np
import pytest

from ident.campaign.campaign import Campaign
from ident.campaign.device import Oscillator
from ident.campaign.record import Channel, NoiseFloor, Trace
from ident.fit import fit
from ident.fit.linear.choice import choose_linear
from ident.fit.linear.start_model import start_model

ONE, STEP = Channel("V", 1.0), 1 / 1400.0
MODES = ((23.5, 120.0), (144.0, 90.0), (61.0, 60.0))


def decay(sizes: tuple[float, ...], seed: int, noise: float = 0.01) -> Trace:
    rng, t = np.random.default_rng(seed), STEP * np.arange(4000)
    ring = lambda f, q, a: a * np.exp(-np.pi * f / q * t) * np.cos(2 * np.pi * f * t + rng.uniform(0, 2 * np.pi))
    response = sum(ring(f, q, a) for (f, q), a in zip(MODES, sizes, strict=False)) + noise * rng.standard_normal(len(t))
    return Trace(f"decay{seed}", t, np.zeros(len(t)), response, ONE, ONE, NoiseFloor(noise), "unknown")


@pytest.mark.parametrize("sizes", [(1.0,), (1.0, 0.2), (1.0, 0.2, 0.3)])
def test_decays_have_as_many_modes_as_ring(sizes):
    records = [decay(tuple(one * a for a in sizes), seed) for seed, one in enumerate((1.0, 0.5))]
    chosen = choose_linear(records).chosen
    assert 1 + len(chosen.further) == len(sizes)
    there = sorted([chosen.first, *(mode.frequency for mode in chosen.further)])
    np.testing.assert_allclose(there, sorted(f for f, _ in MODES[: len(sizes)]), rtol=1e-3)


def test_what_bends_with_its_amplitude_is_one_mode():
    t = STEP * np.arange(4000)
    falling = np.exp(-np.pi * 23.5 / 120 * t)
    bent = lambda a: a * falling * np.cos(2 * np.pi * 23.5 * (t + 0.004 * a * a * (1 - falling**2)))
    records = [Trace("bent", t, 0 * t, bent(a) + 0.002, ONE, ONE, NoiseFloor(0.002), "unknown") for a in (1.0, 0.5)]
    assert not choose_linear(records).chosen.further


def test_they_are_fitted_to_the_noise_floor():
    records = tuple(decay((a, 0.2 * a), seed) for seed, a in enumerate((1.0, 0.5)))
    campaign = Campaign("beam", records, Oscillator("V", "V"))
    found = fit(start_model(campaign), campaign)
    assert found.model.names == ("second-mode",)
    assert found.fitted.error_over_noise == pytest.approx(1.0, abs=0.04)
    assert found["frequency"].value == pytest.approx(23.5, rel=1e-3)
    assert found["second-mode.period"].value == pytest.approx(1 / 144.0, rel=1e-3)
    assert "second-mode.travel" not in [e.name for e in found.estimates if e.fitted]
