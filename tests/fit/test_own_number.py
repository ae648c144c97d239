"""Held-out levels of sweeps which ask for another drive, resonance or damping."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from ident.campaign.campaign import Campaign
from ident.campaign.device import Oscillator
from ident.campaign.record import Sweep
from ident.effects.registry import built_in
from ident.fit import Fit, fit
from ident.model import Model
from ident.report.words.own_numbers import own_number_words
from tests.fit.test_curves import CUBIC, QUALITY, sweep


def _fit(held: list[Sweep], cubic: float = CUBIC) -> Fit:
    device = Oscillator(output="m")
    model = Model(device) + built_in()["cubic-stiffness"](device)
    return fit(model, Campaign("", (sweep(0.5, cubic, False, 1), *(replace(s, holdout=True) for s in held)), device))


def test_a_drive_that_is_not_what_it_is_called() -> None:
    called = replace(sweep(0.218, CUBIC, False, 2), level=np.full(112, 0.2))
    found = _fit([called, sweep(0.3, CUBIC, False, 3)])
    (one,) = found.own_numbers
    assert (one.kind, one.names, one.level) == ("drive", (called.name,), pytest.approx(0.2))
    assert one.share == pytest.approx(0.09, abs=4 * one.error) and one.error < 0.003
    assert one.over_noise[1] == pytest.approx(1.0, abs=0.15) and one.over_peak[1] < 0.3 * one.over_peak[0]
    (words,) = own_number_words(found)
    assert "as if its drive were" in words and "% larger" in words


def test_ways_up_and_down_in_two_files_share_a_number() -> None:
    called = replace(sweep(0.218, CUBIC, True, 2), level=np.full(112, 0.2))
    ways = [
        replace(called, name=name, **{key: getattr(called, key)[rows] for key in (
            "frequency", "level", "amplitude", "phase", "up")})
        for name, rows in (("up", called.up), ("down", ~called.up))
    ]  # fmt: skip
    (one,) = _fit(ways).own_numbers
    assert one.names == ("up", "down") and one.share == pytest.approx(0.09, abs=0.003)


def test_a_damping_of_its_own_is_no_drive() -> None:
    """A loss that depends on the amplitude changes the peak of a level, and leaves its flanks where they are."""
    weak = sweep(0.2, 0.0, False, 2)
    r = weak.frequency / 40.0
    size = lambda q: 1 / np.hypot(1 - r**2, r / q)
    weak = replace(weak, amplitude=weak.amplitude * size(1.3 * QUALITY) / size(QUALITY))
    (one,) = _fit([weak], cubic=0.0).own_numbers
    assert one.kind == "quality" and one.share == pytest.approx(0.3, abs=0.02)


def test_a_level_that_is_predicted_asks_for_nothing() -> None:
    assert _fit([sweep(0.2, CUBIC, True, 2), sweep(0.3, CUBIC, False, 3)]).own_numbers == ()
