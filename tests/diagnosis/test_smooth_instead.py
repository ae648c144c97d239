"""A drive that only a missing law had made look held is smooth in the end, and no lag is named."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from scipy.integrate import solve_ivp

from ident.campaign.campaign import Campaign
from ident.campaign.device import Oscillator
from ident.campaign.held_drive import Edges
from ident.campaign.record import Channel, NoiseFloor, Trace
from ident.diagnosis.search.discover import walk_on
from ident.diagnosis.search.drive import edges_of, smooth_instead, with_edges
from ident.diagnosis.search.steps import Walked
from ident.effects.registry import built_in
from ident.fit import fit
from ident.model import Model

F, Q, STEP, NOISE, CUBIC = 30.0, 25.0, 1 / 330.0, 0.003, 0.04
ONE = Channel("V", 1.0)
NAMES = ("cubic-stiffness", "sensor-lag", "drive-lag", "quadratic-stiffness")


def campaign() -> Campaign:
    """Sweeps at two levels of a spring that hardens by 4 % at a displacement of one, eleven samples a period."""
    w, t, records = 2 * np.pi * F, STEP * np.arange(1800), []
    for k, level in enumerate((0.05, 0.12)):
        drive = lambda t, level=level: level * np.sin(2 * np.pi * (20 * t + 2 * t**2))
        rates = lambda t, y, drive=drive: (y[1], w * w * (drive(t) - y[0] - CUBIC * y[0] ** 3) - w / Q * y[1])
        z = solve_ivp(rates, (0, t[-1]), (0, 0), "DOP853", t, rtol=1e-9, atol=1e-12).y[0]
        noise = NOISE * np.random.default_rng(k).standard_normal(len(t))
        records.append(Trace(f"{k}", t, drive(t), z + noise, ONE, ONE, NoiseFloor(NOISE), "rest"))
    return Campaign("sweeps", tuple(records), Oscillator("V", "V"))


def test_the_walk_is_gone_with_a_smooth_drive_too_and_the_better_answer_stands() -> None:
    held = with_edges(campaign(), Edges(0.0))
    assert smooth_instead(held) == Edges(0.0, False)
    library = {name: built_in()[name] for name in NAMES}
    ended = walk_on(Walked(fit(Model(held.device), held)), library)
    assert edges_of(ended.walked.start.campaign).first is None
    assert [step.added for step in ended.walked.steps] == ["cubic-stiffness"]
    assert ended.walked.final.fitted.error_over_noise < 1.1


def test_what_a_campaign_says_and_what_jumps_is_not_asked() -> None:
    held = with_edges(campaign(), Edges(0.0))
    told = replace(held, records=tuple(replace(r, between="hold") for r in held.traces))
    assert smooth_instead(told) is None and smooth_instead(campaign()) is None
    switched = [replace(r, drive=np.sign(np.sin(np.arange(1800) / 40))) for r in held.traces]
    assert smooth_instead(replace(held, records=tuple(switched))) is None
