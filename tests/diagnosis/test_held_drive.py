"""A drive that is held, asked for beside a fit that took it for a smooth curve."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from types import SimpleNamespace
from typing import cast

import numpy as np
import pytest

from ident.campaign import Channel, NoiseFloor, Trace
from ident.campaign.campaign import Campaign
from ident.campaign.device import Oscillator
from ident.diagnosis.linearised.regression import prepare
from ident.diagnosis.ranking.look import Look
from ident.diagnosis.search.drive import other_drive, with_edges
from ident.fit import fit
from ident.fit.linear.forms import FORMS
from ident.fit.linear.start_model import start_model
from ident.fit.linear.stretches import stretch_of

F, Q, STEP = 30.0, 8.0, 1 / 600.0


def campaign_of(edge: float | None, **told: object) -> Campaign:
    """A linear oscillator under a square wave whose edges lie so many samples late, or a chirp; the fit is not told."""
    k = np.arange(1500)
    drive = np.where((k > 10) & ((k // 67) % 2 == 1), 1.0, 0.0) if edge is not None else np.sin(k**2 / 9000)
    volts, metres, floor = Channel("V", 1.0), Channel("m", 1.0), NoiseFloor(0.005)
    record = Trace("a", STEP * k, drive, drive, volts, metres, floor, "rest", **told)  # type: ignore[arg-type]
    one = stretch_of(replace(record, edge=edge))
    answer = (2 * np.pi * F) ** 2 * FORMS["oscillator"].answer(np.array([F, Q]), one, drive)
    response = answer + 0.005 * np.random.default_rng(5).standard_normal(len(k))
    return Campaign("square", (replace(record, response=response),), Oscillator("m", "V"))


def asked(campaign: Campaign) -> Campaign | None:
    found = fit(start_model(campaign), campaign)
    way = other_drive(found, prepare(found), lambda _: None)
    return None if way is None else with_edges(campaign, way)


def look_at(promise: float, tried: Sequence[object] = ()) -> Look:
    """As far as a drive asks what effects promise, and reach once they are refitted."""
    return cast(Look, SimpleNamespace(promise=promise, tried=tried))


@pytest.mark.parametrize("edge", [-0.9, -0.1, 1.0])
def test_the_edges_are_found_beside_a_fit(edge):
    """Those that lie far from a smooth curve in two steps: a push is linear, a model is not."""
    other = asked(campaign_of(edge))
    assert other is not None and other.traces[0].edge == pytest.approx(edge, abs=0.1)
    other = asked(other) or other
    assert other.traces[0].edge == pytest.approx(edge, abs=0.02)


def test_a_record_whose_drive_is_smooth_may_stay_so():
    """Beside a switch, whose edges a converter's clock does not tell."""
    square, chirp = campaign_of(-0.3), campaign_of(None)
    both = replace(square, records=(*square.records, *(replace(r, name="b") for r in chirp.records)))
    other = asked(both)
    assert other is not None and other.traces[1].edge is None
    assert other.traces[0].edge == pytest.approx(-0.3, abs=0.1)


def test_an_effect_that_promises_more_goes_first():
    """The loss of a rubber mount hid in a drive that was said to be held, and names were sought beside that."""
    found = fit(start_model(campaign_of(1.0)), campaign_of(1.0))
    regression = prepare(found)
    for promise, asked_for in ((0.5, True), (3.0, False)):
        look = look_at(promise * regression.chi2)
        assert (other_drive(found, regression, lambda _: None, look) is not None) is asked_for


def test_where_an_effect_promises_a_little_more_refits_decide():
    """Beside the surround of a rubber mount a lag of the sensor promised a twentieth more than a smooth drive, which
    has no number to fit; it stayed, and each record had a delay of its own in the end."""
    found = fit(start_model(campaign_of(1.0)), campaign_of(1.0))
    regression = prepare(found)
    for left, asked_for in ((0.5, True), (0.001, False)):
        refitted = [SimpleNamespace(left=left * regression.residual, numbers=regression.numbers + 1, possible=True)]
        look = look_at(1.5 * regression.chi2, refitted)
        assert (other_drive(found, regression, lambda _: None, look) is not None) is asked_for


def test_a_record_that_has_a_delay_of_its_own_keeps_its_edges():
    campaign = asked(campaign_of(-0.9))
    assert campaign is not None
    own = tuple(replace(record, own=("delay", (-0.4,)), edge=0.5) for record in campaign.traces)
    assert asked(replace(campaign, records=own)) is None


def test_in_the_place_of_an_effect_it_must_do_no_worse():
    """The drive of a loudspeaker was said to be held, for beside its spring alone that mimicked the loss of its
    surround; with both the smooth drive had reached the noise."""
    found = fit(start_model(campaign_of(1.0)), campaign_of(1.0))
    regression = prepare(found)
    for left, asked_for in ((0.5, True), (0.01, False)):
        second = replace(regression, residual=left * regression.residual)
        assert (other_drive(found, regression, lambda _: None, instead_of=second) is not None) is asked_for


def test_a_smooth_drive_and_one_that_is_told_stay_as_they_are():
    assert asked(campaign_of(None)) is None
    assert asked(campaign_of(-0.9, between="smooth")) is None
