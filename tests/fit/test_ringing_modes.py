"""A record cut out of the motion of two sharp modes begins with both of them ringing, many times as far as the drive
pushes them at rest."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from ident.campaign.campaign import Campaign
from ident.campaign.device import Oscillator
from ident.campaign.record import Channel, NoiseFloor, Trace
from ident.effects.registry import built_in
from ident.fit.rebuild import fit_at
from ident.fit.zeros import Zero, best_by
from ident.model import Model

FREQUENCIES, QUALITIES, GAINS = (487.31, 489.02), (2900.0, 1750.0), (2.1, 1.15)
TRAVEL = GAINS[1] / (2 * np.pi * FREQUENCIES[1]) ** 2  # static, per volt


def bell(seed: int) -> Trace:
    """Both modes under twenty tones, with the decays that these had left before: in closed form, in velocity."""
    rng, time = np.random.default_rng(seed), 4e-4 * np.arange(1400)
    tones, phases = 2 * np.pi * rng.uniform(300, 700, 20), rng.uniform(0, 2 * np.pi, 20)
    drive = 0.01 * np.sum(np.sin(np.outer(time, tones) + phases), axis=1)
    speed = np.zeros_like(time)
    for f, q, g in zip(FREQUENCIES, QUALITIES, GAINS, strict=True):
        w = 2 * np.pi * f
        answer = 0.01j * tones * g / (w**2 - tones**2 + 1j * w * tones / q)
        speed += np.sum(np.imag(answer * np.exp(1j * (np.outer(time, tones) + phases))), axis=1)
        ringing = (
            0.02 * np.exp(1j * rng.uniform(0, 2 * np.pi)) * np.exp((1j * w * (1 - 1 / (8 * q**2)) - w / (2 * q)) * time)
        )
        speed += np.real(ringing)
    sigma, one = 4e-3 * float(np.std(speed)), Channel("V", 1.0)
    floor = NoiseFloor(sigma, (), "given", 0.0)
    return Trace(
        f"cut {seed}",
        time,
        drive,
        speed + sigma * rng.normal(size=len(time)),
        one,
        one,
        floor,
        "unknown",
        measures="velocity",
    )


def test_the_histories_of_both_modes_are_found_beside_a_misfit() -> None:
    """A zero that the model lacks, of 20 noise floors: against a misfit as large an unlikely history counts."""
    records = [bell(1), bell(2)]
    off = [replace(one, response=one.response + 20 * one.noise.sigma) for one in records]
    campaign = Campaign("bell", tuple(off), Oscillator())
    model = Model(campaign.device, (built_in()["second-mode"](),))
    values = [FREQUENCIES[0], QUALITIES[0], GAINS[0], TRAVEL, 1 / FREQUENCIES[1], QUALITIES[1]]
    found = fit_at(model, campaign, np.array(values))
    left = [one.response - told for one, told in zip(found.campaign.traces, found.readings, strict=True)]
    assert [np.std(part) for part in left] == pytest.approx([one.noise.sigma for one in records], rel=0.1)


def test_a_motion_without_bound_has_no_zero() -> None:
    rows = np.array([[1.0, 1.0, np.nan, 1.0], [2.0, 2.0, 2.0, 2.0]])
    found = best_by([Zero(0, np.ones((1, 4)))], [slice(0, 4)], np.ones(4), rows)
    assert found == pytest.approx(np.array([[0.0] * 4, [2.0] * 4]))
