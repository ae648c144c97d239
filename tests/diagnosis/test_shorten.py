"""Excerpts of long records keep where they move most, where they move less, and the rest before."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.signal import bilinear, lfilter

from ident.campaign.campaign import Campaign
from ident.campaign.device import Oscillator
from ident.campaign.record import Channel, NoiseFloor, Trace
from ident.diagnosis.linearised import shorten
from ident.diagnosis.linearised.shorten import CRAWLS, is_long, shortened, working
from ident.effects.registry import built_in
from ident.fit import fit
from ident.fit.rebuild import fit_at
from ident.model import Model
from ident.response.substeps import lay_out
from tests.fit.test_history_misfit import stage

REST, MOVING = 6000, 40_000


def growing() -> Trace:
    """A record of an oscillator at 60 Hz that rests, then moves more and more; 17 samples per period."""
    time = 1e-3 * np.arange(REST + MOVING)
    growth = np.clip(np.arange(len(time)) - REST, 0, None) / MOVING
    drive = growth * np.sin(2 * np.pi * 50 * time)
    omega = 2 * np.pi * 60
    answer = lfilter(*bilinear([omega**2], [1.0, omega / 10, omega**2], 1e3), drive)
    response = 2.0 * answer / np.max(answer) + 1e-3 * np.random.default_rng(0).standard_normal(len(time))
    channel = Channel("V", 1.0)
    return Trace("a.csv", time, drive, response, channel, channel, NoiseFloor(1e-3, method="given"), "rest")


def test_excerpts_cover_what_differs_and_are_no_longer_long() -> None:
    record = growing()
    campaign = Campaign("long", (record, replace(record, name="b.csv", holdout=True)), Oscillator())
    assert is_long(campaign)
    parts = working(fit(Model(campaign.device), campaign)).campaign
    assert not is_long(parts) and not parts.heldout
    sizes = [float(np.std(part.response[part.skip :])) for part in parts.fitted]
    assert len(sizes) == 3
    assert min(sizes) < 0.02 and max(sizes) > 1.2 and 0.2 < sorted(sizes)[1] / max(sizes) < 0.5
    assert sum(len(part.time) - part.skip for part in parts.fitted) < 0.4 * len(record.time)


def test_short_records_are_worked_on_whole() -> None:
    record = growing()
    short = replace(record, time=record.time[:9000], drive=record.drive[:9000], response=record.response[:9000])
    campaign = Campaign("short", (short,), Oscillator())
    found = fit(Model(campaign.device), campaign)
    assert working(found) is found


def test_a_long_record_is_one_that_takes_many_steps() -> None:
    record = growing()
    middle = replace(record, time=record.time[:28_000], drive=record.drive[:28_000], response=record.response[:28_000])
    campaign = lambda sigma: Campaign("one", (replace(middle, noise=NoiseFloor(sigma, method="given")),), Oscillator())
    assert not is_long(campaign(3e-2))
    assert is_long(campaign(1e-4))  # the same samples with less noise, below which the solver's error must stay


def test_a_fit_to_excerpts_that_crawls_is_left_as_refits_are(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(shorten, "_MOST", 1000)
    monkeypatch.setattr(shorten, "_KEPT", 800)
    campaign = Campaign("stage", (stage(10.0, 0), stage(25.0, 1)), Oscillator())
    model = Model(campaign.device, (built_in()["prandtl-ishlinskii"](),))
    values = np.array([300.0, 0.7, 1.4 * (600 * np.pi) ** 2, 0.3, 0.0, *np.zeros(4), 0.8])
    assert working(fit_at(model, campaign, values)).starts[0].steps <= CRAWLS  # 400 without


def test_an_excerpt_knows_how_long_the_record_has_lasted() -> None:
    """A stiffness that drifts from switching-on has drifted where the excerpt begins: where its clock began anew it was
    not found, and one record of four was called wrong in its time."""
    record = growing()
    parts = shortened(Campaign("long", (record,), Oscillator())).fitted
    assert max(part.time[0] for part in parts) > record.time[0] + 1.0
    tape = lay_out(parts, 60.0, 10.0, Model(Oscillator()))
    clocks = np.concatenate([chunk.clock for chunk in tape.chunks])
    for part, span in zip(parts, tape.spans, strict=True):
        assert clocks[span.block] == pytest.approx(part.time[0] - record.time[0], abs=1e-9)
    running = shortened(Campaign("long", (replace(record, start="unknown"),), Oscillator())).fitted
    assert not any(part.begins_in_motion for part in parts) and all(part.begins_in_motion for part in running)
